"""The recordings that are asked for, and a collection's folder put into them."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.recordings.moments import Recorder

if TYPE_CHECKING:
    from facetlog.kb.knowledge_base import KnowledgeBase

__all__ = ["Recordings", "record_collection"]


@dataclass(frozen=True, slots=True)
class Recordings:
    """Where to record: an MCAP file, and a file of Rerun's, a viewer's address or `live`."""

    mcap: Path | None = None
    rerun: str | None = None

    def __bool__(self) -> bool:
        return self.mcap is not None or self.rerun is not None

    def check(self) -> None:
        """InputError where a package is missing or a name is none, before any work."""
        if self.mcap is not None:
            from facetlog.recordings.mcap_recording import checked_mcap

            checked_mcap(self.mcap)
        if self.rerun is not None:
            from facetlog.recordings.rerun_recording import rerun_target

            rerun_target(self.rerun)

    def open(self, name: str) -> list[Recorder]:
        """The recordings, begun; `name` is what is recorded. InputError as of `check`."""
        recorders: list[Recorder] = []
        if self.mcap is not None:
            from facetlog.recordings.mcap_recording import McapRecording

            recorders.append(McapRecording(self.mcap))
        if self.rerun is not None:
            from facetlog.recordings.rerun_recording import RerunRecording

            recorders.append(RerunRecording(self.rerun, name))
        return recorders


@contextmanager
def opened(recordings: Recordings, name: str) -> Iterator[Sequence[Recorder]]:
    """The recordings, ended afterwards whatever happens."""
    recorders = recordings.open(name)
    try:
        yield recorders
    finally:
        for recorder in recorders:
            recorder.close()


def record_collection(folder: Path, recordings: Recordings, base: "KnowledgeBase") -> int:
    """Records a collection's folder as it would have been while it grew; how many views it has.

    InputError if the folder holds no collection.
    """
    from facetlog.folder_judge import FolderJudge
    from facetlog.robot.collecting.record import read_record

    _, views = read_record(folder)
    with opened(recordings, folder.resolve().name) as recorders:
        judge = FolderJudge(folder, base, recorders)
        for count in range(1, len(views) + 1):
            judge.so_far(count)
    return len(views)
