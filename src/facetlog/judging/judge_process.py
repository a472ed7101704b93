"""The process that judges a collection while it grows, and writes its recordings.

Started by view_verdicts.py with the number of a socket, over which questions come one at a time.
Each gets one answer: what was asked for, or the FacetlogError that is why not.
"""

import os
import select
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

from facetlog.errors import FacetlogError
from facetlog.judging.folder_judge import FolderJudge
from facetlog.judging.view_verdicts import (
    EndRecording,
    Explore,
    Judge,
    Opening,
    Question,
    ViewVerdict,
    verdict_of,
)
from facetlog.kb.confidence import DEGREES_ASKED, Confidence
from facetlog.pipeline import open_models
from facetlog.recordings.on_scene import outlined
from facetlog.recordings.recording_request import open_recording

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.recordings.mcap_recording import McapRecording

__all__ = ["main"]


class _Judging:
    """Judges the folder and records it; both are opened once for all questions."""

    def __init__(self, opening: Opening) -> None:
        self._faults: list[str] = []
        """Why there is no recording, until that is said."""
        self._recording: McapRecording | None = None
        try:
            if opening.mcap is not None:
                self._recording = open_recording(opening.mcap)
        except FacetlogError as exc:
            self._faults.append(str(exc))
        base = open_models(opening.models, trusted=opening.trusted)
        self._judge = FolderJudge(opening.folder, base, self._recording)

    def answer(self, question: Question) -> object:
        """Answer a question; raise FacetlogError where recordings cannot be ended."""
        match question:
            case Judge():
                return self._judge_views(question)
            case Explore():
                return self._explore_views(question)
            case EndRecording():
                self._end_recording()
                return None

    def _judge_views(self, asked: Judge) -> ViewVerdict:
        judge, views = self._judge, asked.views
        try:
            whole = judge.at_once(views) if asked.finally_ else None
            recognition = judge.so_far(views) if whole is None else whole.recognition
        except FacetlogError as exc:
            return ViewVerdict(views, fault=str(exc))
        if recognition is None:
            fault = "too little was seen to say what is there"
            return ViewVerdict(views, fault=fault, problems=self._take_problems())
        shown = _drop_confidences(recognition) if asked.degrees else recognition
        outlines = () if whole is None else outlined(whole.scene, shown)
        found = verdict_of(recognition, views, self._take_problems(), degrees=asked.degrees)
        return replace(found, outlines=outlines)

    def _explore_views(self, asked: Explore) -> ViewVerdict:
        """Judge all views at once: for so few this is as fast as one at a time, and poses that were
        summed up by odometry are corrected.
        """
        from facetlog.exploring.open_questions import find_needs

        try:
            if self._recording is not None:
                self._judge.so_far(asked.views)  # recordings show the views one by one
            whole = self._judge.at_once(asked.views)
            needs = find_needs(whole.scene, whole.recognition, asked.interest)
        except FacetlogError as exc:
            return ViewVerdict(asked.views, fault=str(exc))
        found = verdict_of(whole.recognition, asked.views, self._take_problems(), degrees=True)
        return replace(found, needs=needs)

    def _end_recording(self) -> None:
        if self._recording is None:
            return
        with suppress(FacetlogError):  # as for a folder without views
            self._judge.so_far(sys.maxsize)
        self._recording.close()

    def _take_problems(self) -> tuple[str, ...]:
        """Return the problems that were not yet reported."""
        faults, self._faults = tuple(self._faults), []
        return (*faults, *self._judge.problems())


def _drop_confidences(recognition: "Recognition") -> "Recognition":
    """Replace confidences by degrees."""
    verdicts = tuple(
        replace(each, confidence=Confidence(reason=DEGREES_ASKED)) for each in recognition.verdicts
    )
    return replace(recognition, verdicts=verdicts)


def _receive_questions(line: Connection) -> Iterator[Question]:
    with suppress(EOFError, OSError):
        while True:
            yield line.recv()


def _end_with(descriptor: int) -> None:
    """End this process with the one that asks, also in the middle of an answer."""
    other = select.poll()
    other.register(descriptor, 0)  # that it hangs up is reported unasked
    other.poll()
    os._exit(0)


def main(descriptor: int) -> None:
    """Answer questions until the other side goes away."""
    line = Connection(descriptor)
    threading.Thread(target=_end_with, args=(descriptor,), daemon=True).start()
    judging = _Judging(line.recv())
    for question in _receive_questions(line):
        try:
            answer = judging.answer(question)
        except FacetlogError as exc:
            answer = exc
        line.send(answer)


if __name__ == "__main__":
    main(int(sys.argv[1]))
