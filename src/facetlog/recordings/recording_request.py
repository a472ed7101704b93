"""Recordings that are asked for: check the file, open it, and record a folder afterwards."""

from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import InputError
from facetlog.output_file import check_output_file

if TYPE_CHECKING:
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.recordings.mcap_recording import McapRecording


def check_recording(
    path: Path, views: Path, inputs: Iterable[Path] = (), *, overwrite: bool = False
) -> None:
    """Raise InputError unless a recording of the folder `views` can be written to `path`."""
    from facetlog.recordings.mcap_recording import checked_mcap

    checked_mcap(path)
    if path.exists():  # else its folder is made, too
        check_output_file(path, "--mcap", (views, *inputs), overwrite=overwrite)
    if views.resolve() in path.resolve().parents:
        raise InputError(f"{path} is in the folder of the views: put it beside {views}")


def open_recording(path: Path) -> "McapRecording":
    """Begin a recording. Raise InputError if it cannot be written."""
    from facetlog.recordings.mcap_recording import McapRecording

    return McapRecording(path)


def record_collection(folder: Path, path: Path, base: "KnowledgeBase") -> int:
    """Record a collection as it would have been while it grew. Return its number of views.

    Raise InputError if the folder holds no collection.
    """
    from facetlog.judging.folder_judge import FolderJudge
    from facetlog.robot.collecting.record import read_record

    _, views = read_record(folder)
    with closing(open_recording(path)) as recording:
        judge = FolderJudge(folder, base, recording)
        for count in range(1, len(views) + 1):
            judge.so_far(count)
    return len(views)
