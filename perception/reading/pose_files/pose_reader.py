"""The interface of a kind of poses file: how the register (register.py) finds and reads it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.length_units import Length
from facetlog.perception.reading.pose_files.file_values import get_metres_per
from facetlog.perception.reading.pose_files.poses_file import PosesFile


@dataclass(frozen=True, slots=True)
class PoseOptions:
    """Options for reading poses, as the user gives them.

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

    `find` returns the poses file of this kind in a folder, None where there is none; `takes` says
    whether a path is one, by its name; `read` reads such a file. `needs` lists what a folder must
    hold, for people. `made_from` names the kinds that programs write beside this one, and from the
    same poses: this one is read then. One that is found `alone` is for folders in which no other
    kind is found. `choice` says of a folder with several such files which one is read, for people;
    empty where there is one. `lacks` says of a folder that has part of this kind, and so is not
    found, what is missing; empty of any other.
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


def make_metric_reader(
    read: Callable[[Path], PosesFile], default: str | None = None
) -> Callable[[Path, PoseOptions], PosesFile]:
    """Return the `read` of a file that has poses: they become metres by its unit, if it is known.

    The unit is that of the file, or the one that the user gives, or else the format's `default`.
    """

    def read_with_unit(path: Path, options: PoseOptions) -> PosesFile:
        if options.square is not None:
            raise InputError(f"square is for pictures of a mat, and {path} has poses: omit it")
        if options.unit is not None:
            get_metres_per(options.unit, "--unit")
        file = read(path)
        if file.unit and options.unit and file.unit != options.unit:
            raise InputError(
                f"{path}: its unit is {file.unit!r}, and {options.unit!r} was given: leave one out"
            )
        unit = file.unit or options.unit or default
        return file if unit is None else file.to_metres(get_metres_per(unit, "--unit"))

    return read_with_unit


def make_file_finder(*names: str) -> Callable[[Path], Path | None]:
    """Return a function that finds the first of these files in a folder that has them all."""

    def find(folder: Path) -> Path | None:
        paths = [folder / name for name in names]
        return paths[0] if all(path.is_file() for path in paths) else None

    return find


def make_missing_check(*names: str) -> Callable[[Path], str]:
    """Return a function that names the files that a folder lacks which has another of them."""

    def find_missing(folder: Path) -> str:
        there = [name for name in names if (folder / name).is_file()]
        absent = [name for name in names if name not in there]
        if not there or not absent:
            return ""
        verb = "is" if len(absent) == 1 else "are"
        return f"{' and '.join(absent)} {verb} missing beside {' and '.join(there)}"

    return find_missing
