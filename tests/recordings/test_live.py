"""Recordings while a collection grows, written by the process that judges it."""

from pathlib import Path

import pytest

from facetlog.recordings.recorders import Recordings
from facetlog.view_verdicts import ViewVerdicts
from tests.recordings.collected import collection
from tests.recordings.test_mcap_recording import messages

pytestmark = pytest.mark.slow


def test_views_that_nobody_asked_about_are_recorded_at_the_end(tmp_path: Path) -> None:
    collected = collection()
    folder, path = tmp_path / "views", tmp_path / "views.mcap"
    with ViewVerdicts(folder, recordings=Recordings(mcap=path)) as verdicts:
        collected.write(folder)
        verdicts.ask(1)
        verdicts.last()
    assert len(messages(path)["/camera/camera_info"]) == 2


def test_a_collection_without_a_view_leaves_what_was_recorded_before(tmp_path: Path) -> None:
    path = tmp_path / "views.mcap"
    path.write_bytes(b"earlier")
    with ViewVerdicts(tmp_path / "views", recordings=Recordings(mcap=path)):
        pass
    assert path.read_bytes() == b"earlier"
    assert [each.name for each in tmp_path.iterdir()] == ["views.mcap"]


def test_a_recording_that_cannot_be_written_is_said_and_the_verdicts_go_on(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "views"
    collection().write(folder)
    (tmp_path / "file").write_text("")
    recordings = Recordings(mcap=tmp_path / "file" / "views.mcap")
    with ViewVerdicts(folder, recordings=recordings) as verdicts:
        verdicts.ask(2)
        (answer,) = verdicts.last()
    assert "cannot be written" in answer.line
