"""Where the pictures of a poses file are: under the names that it has, or where they were moved to.

Files that were written on another machine have backslashes, or its absolute paths.
"""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice, takewhile
from pathlib import Path, PurePosixPath, PureWindowsPath

from facetlog.perception.name_lists import named
from facetlog.perception.reading.pose_files.pose_checks import is_file
from facetlog.perception.reading.pose_files.poses_file import PosedPicture, PosesFile

__all__ = ["find_pictures", "may_be_below", "picture_path"]

MOST_FILES = 200_000
"""Looked through below a folder: more are no capture."""


def picture_path(folder: Path, name: str, extensions: Iterable[str] = ()) -> Path:
    """The file of a picture by its name, which may have backslashes, or lack one of these
    extensions; as it is written where there is none.
    """
    for written in dict.fromkeys((name, name.replace("\\", "/"))):
        for extension in ("", *extensions):
            if is_file(candidate := folder / (written + extension)):
                return candidate
    return folder / name


def find_pictures(file: PosesFile) -> PosesFile:
    """The file with pictures of absolute paths that are not there taken from below its folder,
    where exactly one file there has the name, and a note that says so.
    """
    moved = [p for p in file.pictures if _is_elsewhere(p)]
    if not moved:
        return file
    below = _files_by_name(file.folder)
    found = {p.name: path for p in moved if (path := _like(p.name, below)) is not None}
    once = {name for name in found if list(found.values()).count(found[name]) == 1}
    if not once:
        return file
    names = [p.name for p in moved if p.name in once]
    note = (
        f"{named(names)} {'is' if len(names) == 1 else 'are'} not there, on this machine: the "
        f"pictures of the same names below {file.folder} are used"
    )
    pictures = tuple(replace(p, path=found[p.name]) if p.name in once else p for p in file.pictures)
    return replace(file, pictures=pictures, notes=(*file.notes, note))


def may_be_below(folder: Path, name: str) -> bool:
    """Whether a picture is in a folder by its name, or by the end of one that is absolute."""
    if is_file(picture_path(folder, name)):
        return True
    return _is_absolute(name) and is_file(folder / PureWindowsPath(name).name)


def _is_absolute(name: str) -> bool:
    return PurePosixPath(name).is_absolute() or PureWindowsPath(name).is_absolute()


def _is_elsewhere(picture: PosedPicture) -> bool:
    absolute = _is_absolute(picture.name)
    return picture.frame is None and absolute and not is_file(picture.path)


def _files_by_name(folder: Path) -> dict[str, list[Path]]:
    by_name: dict[str, list[Path]] = {}
    for path in islice(_files(folder), MOST_FILES):
        by_name.setdefault(path.name, []).append(path)
    return by_name


def _files(folder: Path) -> Iterator[Path]:
    for where, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (Path(where) / name for name in sorted(names))


def _like(name: str, below: dict[str, list[Path]]) -> Path | None:
    """The one file whose path ends most like a name; None where there is none, or several."""
    parts = PureWindowsPath(name).parts  # which reads either kind of slash
    ranked = sorted(below.get(parts[-1], ()), key=lambda path: -_shared(path.parts, parts))
    if len(ranked) > 1 and _shared(ranked[0].parts, parts) == _shared(ranked[1].parts, parts):
        return None
    return ranked[0] if ranked else None


def _shared(one: Sequence[str], other: Sequence[str]) -> int:
    """How many parts at their ends two paths share."""
    pairs = zip(reversed(one), reversed(other), strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))
