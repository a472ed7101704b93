"""What a kind of poses file is to the register (register.py): how it is found, and read."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from facetlog.perception.reading.pose_files.poses_file import PosesFile

__all__ = ["PoseReader", "first_of"]


@dataclass(frozen=True, slots=True)
class PoseReader:
    """A kind of poses file.

    `find` is the poses file of this kind in a folder, None where there is none; `takes` says
    whether a path is one, by its name; `read` takes such a file and the unit that the user gave.
    `needs` lists what a folder must hold, for people. `made_from` names the kinds that programs
    write beside this one, and from the same poses: this one is read then. One that is found `alone`
    is for folders in which no other kind is found. `choice` says of a folder with several such
    files which one is read, for people; empty where there is one.
    """

    kind: str
    needs: str
    find: Callable[[Path], Path | None]
    takes: Callable[[Path], bool]
    read: Callable[[Path, str | None], PosesFile]
    made_from: tuple[str, ...] = ()
    alone: bool = False
    choice: Callable[[Path], str] = lambda _: ""


def first_of(*names: str) -> Callable[[Path], Path | None]:
    """What finds the first of these files in a folder that has them all."""

    def find(folder: Path) -> Path | None:
        paths = [folder / name for name in names]
        return paths[0] if all(path.is_file() for path in paths) else None

    return find
