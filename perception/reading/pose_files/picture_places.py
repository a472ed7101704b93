"""Where the pictures of a poses file are: under the names that it has, or where they were moved to.

Files that were written on another machine have backslashes, or its absolute paths.
"""

import os
from collections.abc import Iterable
from dataclasses import replace
from itertools import takewhile
from pathlib import Path, PurePosixPath, PureWindowsPath

from facetlog.perception.name_lists import named
from facetlog.perception.reading.pose_files.file_values import is_file
from facetlog.perception.reading.pose_files.poses_file import PosesFile

MOST_FILES = 200_000
"""Number of files that are searched below a folder: a capture has fewer."""


def resolve_picture_path(folder: Path, name: str, extensions: Iterable[str] = ()) -> Path:
    """Return the file of a picture by its name, which may have backslashes, or lack one of these
    extensions; as it is written where there is none.
    """
    for written in dict.fromkeys((name, name.replace("\\", "/"))):
        for extension in ("", *extensions):
            if is_file(candidate := folder / (written + extension)):
                return candidate
    return folder / name


def find_pictures(file: PosesFile) -> PosesFile:
    """Return the file with pictures of absolute paths that are not there taken from below its
    folder, where exactly one file there has the name, and a note that says so.
    """
    moved = [
        p for p in file.pictures if p.frame is None and _is_absolute(p.name) and not is_file(p.path)
    ]
    if not moved:
        return file
    below = _index_files_by_name(file.folder)
    found = {p.name: path for p in moved if (path := _find_most_alike(p.name, below)) is not None}
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
    """Return whether a picture is in a folder by its name, or by the end of an absolute one."""
    if is_file(resolve_picture_path(folder, name)):
        return True
    return _is_absolute(name) and is_file(folder / PureWindowsPath(name).name)


def _is_absolute(name: str) -> bool:
    return PurePosixPath(name).is_absolute() or PureWindowsPath(name).is_absolute()


def _index_files_by_name(folder: Path) -> dict[str, list[Path]]:
    by_name: dict[str, list[Path]] = {}
    count = 0
    for where, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names)[: MOST_FILES - count]:
            by_name.setdefault(name, []).append(Path(where) / name)
        count += len(names)
        if count >= MOST_FILES:
            break
    return by_name


def _find_most_alike(name: str, below: dict[str, list[Path]]) -> Path | None:
    """Return the one file whose path ends most like a name; None where there is none, or several
    are as like.
    """
    parts = PureWindowsPath(name).parts  # which reads either kind of slash

    def count_shared(path: Path) -> int:
        pairs = zip(reversed(path.parts), reversed(parts), strict=False)
        return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))

    ranked = sorted(below.get(parts[-1], ()), key=count_shared, reverse=True)
    if len(ranked) > 1 and count_shared(ranked[0]) == count_shared(ranked[1]):
        return None
    return ranked[0] if ranked else None
