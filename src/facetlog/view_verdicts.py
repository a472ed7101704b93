"""Verdicts on a collection while it grows: in a process of its own, so that the robot never waits.

Reconstruction keeps a processor busy for seconds, in which no thread of the same process would
renew the robot's lease in time. The pictures are read from the folder, where each is whole: one at
a time while it grows (folder_judge.py), all at once at the end, and of an area those of each place
at once (area_judge.py). Recordings are written there too.
"""

import os
import signal
import sys
import threading
from collections.abc import Mapping
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from facetlog.errors import FacetlogError
from facetlog.kb.explaining.proof import State
from facetlog.mapping.room_map import ScenePart
from facetlog.perception.types import FloatArray
from facetlog.recordings.on_scene import NO_MODEL
from facetlog.recordings.recorders import Recorders, Recordings

if TYPE_CHECKING:
    from facetlog.exploring.needs import Interest, Needs
    from facetlog.folder_judge import FolderJudge
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.recordings.area_recording import AreaRecording

__all__ = ["ViewVerdict", "ViewVerdicts", "verdict_of"]

_judges: "list[FolderJudge]" = []
"""Of the worker process: who judges, once its knowledge base is open."""
_recorders: list[Recorders] = []
"""Of the worker process: the recordings that it writes."""
_areas: "list[AreaRecording]" = []
"""Of the worker process: what records an area, while that can be written."""
_faults: list[str] = []
"""Of the worker process: why there is no recording, until that is said."""


@dataclass(frozen=True, slots=True)
class ViewVerdict:
    """What the models say of the first `views` views.

    `best` has a line for what holds; `excluded` and `unknown` are names of models that hold for
    nothing there; `problems` name views that were read since the verdict before and not used, or
    contradict others. `document` is all of it as `recognize --json` prints it; `fault` is why there
    is none. `outlines` are what holds, each with those of its faces (n, 3), of the last verdict.
    `needs` are what is undecided, where that was asked and something is known.
    """

    views: int
    best: tuple[str, ...] = ()
    excluded: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()
    document: Mapping[str, object] | None = None
    fault: str = ""
    outlines: tuple[tuple[str, tuple[FloatArray, ...]], ...] = field(default=(), compare=False)
    needs: "Needs | None" = field(default=None, compare=False)

    @property
    def line(self) -> str:
        """One line: what it is, what it is not and what is open, or why nothing can be said."""
        if self.fault:
            return "; ".join((self.fault, *self.problems))
        said = list(self.best) or [NO_MODEL]
        if self.unknown:
            said.append(f"unknown: {', '.join(self.unknown)}")
        if self.excluded:
            said.append(f"no: {', '.join(self.excluded)}")
        said += self.problems
        return "; ".join(said)


class ViewVerdicts:
    """A worker process that is asked after every view; answers come in the order of the questions.

    A question that waits while a newer one comes is dropped: of views that come faster than they
    are judged, the newest is of interest.
    """

    def __init__(
        self,
        folder: Path,
        models: tuple[Path, ...] = (),
        *,
        trusted: bool = False,
        recordings: Recordings | None = None,
    ) -> None:
        self._recordings = recordings or Recordings()
        # Not by fork: Prolog and threads do not outlive one.
        self._pool = ProcessPoolExecutor(
            1,
            get_context("spawn"),
            initializer=_open,
            initargs=(folder, models, trusted, self._recordings),
        )
        self._asked: list[Future[ViewVerdict]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for future in self._asked:
            future.cancel()
        try:
            if self._recordings:
                self._pool.submit(_end_recordings).result()
        except (BrokenProcessPool, CancelledError):
            pass  # said by the answer to a question
        finally:
            self._pool.shutdown(wait=True, cancel_futures=True)

    def ask(self, views: int, *, finally_: bool = False, degrees: bool = False) -> None:
        """Asks for a verdict on the first `views` views of the folder; with `degrees` in place of
        confidences.

        Only at the end are poses corrected by the pictures, which takes longer than to drive on.
        """
        self._asked = [future for future in self._asked if not future.cancel()]
        try:
            self._asked.append(self._pool.submit(_judge, views, finally_, degrees))
        except BrokenProcessPool:
            # Said by the answer to an earlier question.
            return

    def explored(self, views: int, interest: "Interest") -> ViewVerdict:
        """The verdict on the first `views` views with what is undecided, by degrees, which grow
        with what was seen; waits for it.
        """
        try:
            return _answer(self._pool.submit(_explore, views, interest))
        except BrokenProcessPool:
            return _DIED

    def explored_place(
        self, names: tuple[str, ...], interest: "Interest"
    ) -> "tuple[ViewVerdict, ScenePart]":
        """The same of views with these names, and the things that they show, in the world."""
        try:
            return self._pool.submit(_explore_place, names, interest).result()
        except (BrokenProcessPool, CancelledError):
            return _DIED, ScenePart()

    def ready(self) -> list[ViewVerdict]:
        """The verdicts that have come since it was last called; does not wait."""
        done: list[Future[ViewVerdict]] = []
        waiting: list[Future[ViewVerdict]] = []
        for future in self._asked:
            (done if future.done() else waiting).append(future)
        self._asked = waiting
        return list(map(_answer, done))

    def last(self) -> list[ViewVerdict]:
        """All verdicts that are still to come; waits for them."""
        waiting, self._asked = self._asked, []
        return list(map(_answer, waiting))


def _answer(future: Future[ViewVerdict]) -> ViewVerdict:
    try:
        return future.result()
    except (BrokenProcessPool, CancelledError):
        return _DIED


_DIED = ViewVerdict(0, fault="the process that judges views has died: no more verdicts")


def _open(folder: Path, models: tuple[Path, ...], trusted: bool, recordings: Recordings) -> None:
    """In the worker: opens models and recordings once for all questions."""
    from facetlog.folder_judge import FolderJudge
    from facetlog.pipeline import open_models
    from facetlog.recordings.area_recording import AreaRecording

    # Ctrl-C and Ctrl-Z end the collection; this process ends with it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTSTP, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        _recorders.append(recordings.open(folder.resolve().name))
    except FacetlogError as exc:
        _faults.append(str(exc))
    base = open_models(models, trusted=trusted)
    recorder = _recorders[0] if recordings and _recorders else None
    _judges.append(FolderJudge(folder, base, recorder))
    if recorder is not None:
        _areas.append(AreaRecording(folder, base, recorder))


def _end_with_parent() -> None:
    """In the worker: a parent that was killed asks no more, but its queue would be waited for."""
    if (parent := parent_process()) is not None:
        wait([parent.sentinel])
        os._exit(1)


def _end_recordings() -> None:
    """In the worker: the recordings are whole afterwards, with all views that are there."""
    from facetlog.mapping.place import is_area
    from facetlog.robot.collecting.record import read_log

    with suppress(FacetlogError):  # as of a folder in which there is no view yet
        if not is_area(read_log(_judges[0].folder)):
            _judges[0].so_far(sys.maxsize)
        elif _areas:
            _areas[0].rest()
    for recorder in _recorders:
        recorder.close()


def _judge(views: int, finally_: bool, degrees: bool) -> ViewVerdict:
    """In the worker: the verdict on the first views of the folder."""
    from facetlog.recordings.on_scene import outlined

    judge = _judges[0]
    try:
        whole = judge.at_once(views) if finally_ else None
        recognition = judge.so_far(views) if whole is None else whole.recognition
    except FacetlogError as exc:
        return ViewVerdict(views, fault=str(exc))
    if recognition is None:
        return _too_little(judge, views)
    shown = _graded(recognition) if degrees else recognition
    outlines = () if whole is None else outlined(whole.scene, shown)
    return replace(_said(judge, views, recognition, degrees=degrees), outlines=outlines)


def _explore(views: int, interest: "Interest") -> ViewVerdict:
    """In the worker: the verdict on the first views, and what is undecided.

    Of all of them at once: of so few that takes no longer than one at a time, and poses that were
    counted up are corrected.
    """
    from facetlog.exploring.needs import needs_of

    judge = _judges[0]
    try:
        if any(recorders.each for recorders in _recorders):
            judge.so_far(views)  # recordings are of the recursion
        whole = judge.at_once(views)
        recognition = whole.recognition
        needs = needs_of(whole.scene, recognition, interest)
    except FacetlogError as exc:
        return ViewVerdict(views, fault=str(exc))
    return replace(_said(judge, views, recognition, degrees=True), needs=needs)


def _explore_place(names: tuple[str, ...], interest: "Interest") -> "tuple[ViewVerdict, ScenePart]":
    """In the worker: what some views of the folder show, and what is undecided of it."""
    from facetlog.exploring.area_judge import place_verdict

    judge = _judges[0]
    found = place_verdict(judge.folder, names, interest, judge.base)
    if _areas:
        try:
            _areas[0].add(names, found.seen)
        except FacetlogError as exc:
            # The robot goes on without a recording; its end says so once more.
            _faults.append(str(exc))
            _areas.clear()
    return replace(found.verdict, problems=_problems(judge)), found.part


def _too_little(judge: "FolderJudge", views: int) -> ViewVerdict:
    return ViewVerdict(
        views, fault="too little was seen to say what is there", problems=_problems(judge)
    )


def _graded(recognition: "Recognition") -> "Recognition":
    """The same with degrees in place of confidences."""
    verdicts = tuple(replace(each, confidence=None) for each in recognition.verdicts)
    return replace(recognition, verdicts=verdicts)


def _said(
    judge: "FolderJudge", views: int, recognition: "Recognition", *, degrees: bool = False
) -> ViewVerdict:
    return verdict_of(recognition, views, _problems(judge), degrees=degrees)


def verdict_of(
    recognition: "Recognition", views: int, problems: tuple[str, ...] = (), *, degrees: bool = False
) -> ViewVerdict:
    """What was recognised in so many views; with `degrees` in place of confidences."""
    # In the order of the confidences all the same.
    best = recognition.best
    if degrees:
        best = tuple(replace(verdict, confidence=None) for verdict in best)
    # Of several things a model may be open for one and excluded for another: then it is open.
    open_for = {v.model: None for v in recognition.verdicts if v.state is State.UNKNOWN}
    asked = {verdict.model: None for verdict in recognition.verdicts}
    unknown = tuple(model for model in open_for if model not in recognition.models)
    return ViewVerdict(
        views,
        tuple(verdict.summary for verdict in best),
        tuple(m for m in asked if m not in recognition.models and m not in open_for),
        unknown,
        problems,
        recognition.to_json(),
    )


def _problems(judge: "FolderJudge") -> tuple[str, ...]:
    """What is to be said besides the verdict, once."""
    faults = tuple(_faults)
    _faults.clear()
    return (*faults, *judge.problems())
