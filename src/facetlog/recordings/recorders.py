"""The recordings that are asked for, and a collection's folder put into them."""

from collections.abc import Iterable
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from facetlog.errors import InputError, missing_extra
from facetlog.output_file import check_output_file
from facetlog.recordings.moments import Moment, Recorder

if TYPE_CHECKING:
    from facetlog.kb.knowledge_base import KnowledgeBase

__all__ = ["Recorders", "Recordings", "record_collection"]


@dataclass(frozen=True, slots=True)
class Recordings:
    """Where to record: an MCAP file, and a file of Rerun's, a viewer's address or `live`."""

    mcap: Path | None = None
    rerun: str | None = None

    def __bool__(self) -> bool:
        return self.mcap is not None or self.rerun is not None

    @property
    def files(self) -> tuple[tuple[str, Path], ...]:
        """The options that name files, with them; a viewer is none."""
        there = (("--mcap", self.mcap), ("--rerun", self.rerun))
        return tuple((o, Path(p)) for o, p in there if p is not None and Path(p).suffix)

    def check(self, inputs: Iterable[Path] = (), *, overwrite: bool = False) -> None:
        """Raise InputError where a package is missing, a name is none, or a file may not be written
        there (see `check_output_file`), before any work."""
        if self.mcap is not None:
            from facetlog.recordings.mcap_recording import checked_mcap

            checked_mcap(self.mcap)
        if self.rerun is not None:
            _rerun_recording().rerun_target(self.rerun)
        read = tuple(inputs)
        for option, path in self.files:
            if path.exists():  # else its folder is made, too
                check_output_file(path, option, read, overwrite=overwrite)

    def check_beside(self, folder: Path) -> None:
        """InputError where a recording would be among the views of a folder."""
        for _, file in self.files:
            if folder.resolve() in file.resolve().parents:
                raise InputError(f"{file} is in the folder of the views: put it beside {folder}")

    def open(self, name: str) -> "Recorders":
        """The recordings, begun; `name` is what is recorded. InputError as of `check`."""
        recorders: list[Recorder] = []
        with ExitStack() as begun:
            if self.rerun is not None:
                recorders.append(_rerun_recording().RerunRecording(self.rerun, name))
                begun.callback(recorders[-1].close)
            if self.mcap is not None:
                from facetlog.recordings.mcap_recording import McapRecording

                recorders.append(McapRecording(self.mcap))
            begun.pop_all()
        return Recorders(tuple(recorders))


@dataclass(frozen=True, slots=True)
class Recorders:
    """Several recordings as one; see `Recorder`."""

    each: tuple[Recorder, ...] = ()

    def add(self, moment: Moment) -> None:
        """See `Recorder`."""
        for recorder in self.each:
            recorder.add(moment)

    def close(self) -> None:
        """See `Recorder`; one that cannot be ended keeps none of the others from it."""
        with ExitStack() as stack:
            for recorder in self.each:
                stack.callback(recorder.close)


def record_collection(folder: Path, recordings: Recordings, base: "KnowledgeBase") -> int:
    """Records a collection's folder as it would have been while it grew; how many views it has.

    InputError if the folder holds no collection.
    """
    from facetlog.folder_judge import FolderJudge
    from facetlog.mapping.place import is_area
    from facetlog.recordings.area_recording import AreaRecording
    from facetlog.robot.collecting.record import read_log, read_record

    _, views = read_record(folder)
    with closing(recordings.open(folder.resolve().name)) as recorders:
        if is_area(read_log(folder)):
            AreaRecording(folder, base, recorders).rest()
            return len(views)
        judge = FolderJudge(folder, base, recorders)
        for count in range(1, len(views) + 1):
            judge.so_far(count)
    return len(views)


def _rerun_recording() -> ModuleType:
    """The module that needs Rerun, imported by whoever records with it; InputError without it."""
    try:
        from facetlog.recordings import rerun_recording
    except ModuleNotFoundError as exc:
        raise missing_extra("a Rerun recording", "rerun-sdk", "rerun") from exc
    return rerun_recording
