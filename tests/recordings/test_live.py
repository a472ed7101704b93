"""Recordings while a collection grows, written by the process that judges it."""

from pathlib import Path
from typing import cast

import pytest

from facetlog.judging.folder_judge import FolderJudge
from facetlog.judging.view_verdicts import ViewVerdicts
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.online.online_scene import OnlineScene
from facetlog.recordings.frames import Moment
from tests.recordings.collected import collection


class Kept:
    """A recorder that keeps what it is given."""

    def __init__(self) -> None:
        self.moments: list[Moment] = []

    def add(self, moment: Moment) -> None:
        self.moments.append(moment)

    def close(self) -> None:
        pass


def test_views_that_come_together_are_each_recorded_with_their_own_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    collection().write(tmp_path)

    asked: list[OnlineScene] = []

    def said(_: object, online: OnlineScene) -> tuple[tuple[()], str]:
        asked.append(online)
        return (), f"verdict {len(asked)}"

    monkeypatch.setattr("facetlog.stream.judged", said)
    kept = Kept()
    last = FolderJudge(tmp_path, cast(KnowledgeBase, None), kept).so_far(2)
    assert [moment.taken.name for moment in kept.moments] == ["view1.png", "view2.png"]
    assert [str(moment.recognition) for moment in kept.moments] == ["verdict 1", "verdict 2"]
    assert str(last) == "verdict 2"


@pytest.mark.slow
def test_a_recording_that_cannot_be_written_is_said_and_the_verdicts_go_on(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "views"
    collection().write(folder)
    (tmp_path / "file").write_text("")
    with ViewVerdicts(folder, mcap=tmp_path / "file" / "views.mcap") as verdicts:
        verdicts.ask(2)
        (answer,) = verdicts.last()
    assert "cannot be written" in answer.line
