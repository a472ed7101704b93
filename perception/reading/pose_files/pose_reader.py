"""What a kind of poses file is to the register (register.py): how it is found, and read."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.length_units import Length
from facetlog.perception.reading.pose_files.poses_file import PosesFile

__all__ = ["PoseOptions", "PoseReader", "by_unit", "first_of", "missing_of"]


@dataclass(frozen=True, slots=True)
class PoseOptions:
    """What a user states of poses, and what may be used to find them.

    `unit` is that of a file that does not give its own, `square` the side of a printed mat's
    squares where it is not as it should be; `axis` says that an axis of the poses'
    world was stated to be up. Poses that take long to find are kept in the folder `keep`.
    `progress` is called with the name of a step, how much of it is done, and of how much.
    """

    unit: str | None = None
    square: Length | None = None
    axis: bool = False
    keep: Path | None = None
    progress: Callable[[str, int, int], None] | None = None


@dataclass(frozen=True, slots=True)
class PoseReader:
    """A kind of poses file.

    `find` is the poses file of this kind in a folder, None where there is none; `takes` says
    whether a path is one, by its name; `read` takes such a file and what the user states.
    `needs` lists what a folder must hold, for people. `made_from` names the kinds that programs
    write beside this one, and from the same poses: this one is read then. One that is found `alone`
    is for folders in which no other kind is found. `choice` says of a folder with several such
    files which one is read, for people; empty where there is one. `lacks` says of a folder that
    has part of this kind, and so is not found, what is missing; empty of any other.
    """

    kind: str
    needs: str
    find: Callable[[Path], Path | None]
    takes: Callable[[Path], bool]
    read: Callable[[Path, PoseOptions], PosesFile]
    made_from: tuple[str, ...] = ()
    alone: bool = False
    choice: Callable[[Path], str] = lambda _: ""
    lacks: Callable[[Path], str] = lambda _: ""


def by_unit(
    read: Callable[[Path, str | None], PosesFile],
) -> Callable[[Path, PoseOptions], PosesFile]:
    """The `read` of a file that has poses: a unit is all that may be stated of it."""

    def reading(path: Path, options: PoseOptions) -> PosesFile:
        if options.square is not None:
            raise InputError(f"square is for pictures of a mat, and {path} has poses: omit it")
        return read(path, options.unit)

    return reading


def first_of(*names: str) -> Callable[[Path], Path | None]:
    """What finds the first of these files in a folder that has them all."""

    def find(folder: Path) -> Path | None:
        paths = [folder / name for name in names]
        return paths[0] if all(path.is_file() for path in paths) else None

    return find


def missing_of(*names: str) -> Callable[[Path], str]:
    """What says which of these files a folder lacks that has another of them."""

    def missing(folder: Path) -> str:
        there = [name for name in names if (folder / name).is_file()]
        absent = [name for name in names if name not in there]
        if not there or not absent:
            return ""
        verb = "is" if len(absent) == 1 else "are"
        return f"{' and '.join(absent)} {verb} missing beside {' and '.join(there)}"

    return missing
