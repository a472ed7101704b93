"""Which files are meant: paths, globs, folders and lists of them, each file once, in order."""

import codecs
import glob
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from facetlog.errors import InputError
from facetlog.output_folder import RUN_FILE, UNFINISHED, list_written_files
from facetlog.perception.shapes.shape_options import find_shape_files
from facetlog.pictures_hint import make_pictures_hint
from facetlog.query_shell.scene_files import SCENE_FILE
from facetlog.safe_read import MOST_BYTES, read_regular

STDIN = "-"
UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def find_scene_paths(sources: Sequence[str], listed: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the files that are meant, in the order given, each once.

    A source is a file, a folder (searched with all that is in it for files of known suffixes; what
    a run wrote with -o is one scene, its scene.json) or a glob, where ** stands for any folders;
    `listed` are paths of files, taken as they are. Files that are not there are kept: their row
    says so. Raise InputError for a folder or glob that finds none, and if there is nothing at all.
    """
    found = [path for source in sources for path in _found(source)]
    once: dict[str, str] = {}
    for path in (*found, *listed):
        once.setdefault(os.path.realpath(path), path)
    if not once:
        raise InputError(
            "there is no scene to classify: give files, folders or globs, or a list of them"
        )
    return tuple(once.values())


def _recoded(data: bytes, source: str) -> bytes:
    try:
        return os.fsencode(data.decode("utf-16"))
    except UnicodeError as exc:
        raise InputError(f"{source}: the list is no UTF-16 text: {exc}") from exc


def _found(source: str) -> tuple[str, ...]:
    if Path(source).is_dir():
        inside = tuple(_shapes_in(source))
        if not inside:
            hint = make_pictures_hint(Path(source))
            raise InputError(f"{source}: the folder has no scene, mesh or cloud{hint}")
        return inside
    if not glob.has_magic(source) or Path(source).exists():
        return (source,)
    matched = sorted(_matched(source))
    if not matched:
        raise InputError(f"{source}: no file is called so")
    files = (path for path in matched if not Path(path).is_dir())
    folders = (path for path in matched if Path(path).is_dir())
    return (*files, *(inside for folder in folders for inside in _shapes_in(folder)))


def _matched(pattern: str) -> Iterator[str]:
    """Yield the paths that a glob matches; ** stands for folders, and not for links to some.

    Python's own follows them: two links of a folder to itself are 2^40 paths.
    """
    head, deep, rest = pattern.partition("**")
    if not deep or rest[:1] not in ("", os.sep) or head[-1:] not in ("", os.sep):
        # Of pathlib there is none for an absolute pattern.
        yield from glob.iglob(pattern)  # noqa: PTH207
        return
    rest = rest.lstrip(os.sep)
    for top in glob.iglob(head) if head else ("",):  # noqa: PTH207
        for place, inner, names in os.walk(top or "."):
            inner[:] = [name for name in inner if not name.startswith(".")]
            folder = place if top else os.path.relpath(place)
            folder = "" if folder == "." else os.path.join(folder, "")  # noqa: PTH118
            if rest:
                yield from _matched(glob.escape(folder) + rest)
            else:
                yield from (folder + name for name in names if not name.startswith("."))


def _shapes_in(folder: str) -> Iterator[str]:
    for place, inner, names in os.walk(folder):
        inner[:] = sorted(name for name in inner if not name.startswith(UNFINISHED))
        written = list_written_files(Path(place)) if RUN_FILE in names else set()
        # Meshes that -o wrote beside a scene are drawn from it: they are no other thing.
        drawn = written - {SCENE_FILE} if SCENE_FILE in written else set()
        for name in find_shape_files([name for name in names if name not in drawn]):
            yield str(Path(place, name))


def read_path_list(source: str) -> tuple[str, ...]:
    """Return the paths in a text file, one on a line; '-' is standard input.

    Empty lines and lines that begin with # are none; relative paths are so to the current folder,
    as `find` writes them. Where there are NULs, as `find -print0` writes them, they end paths, and
    lines are none. Raise InputError if the list cannot be read.
    """
    try:
        if source == STDIN:
            data = sys.stdin.buffer.read(MOST_BYTES + 1)
        else:
            data = read_regular(Path(source))
    except OSError as exc:
        raise InputError(
            f"{source}: the list cannot be read: {exc.strerror or exc} (- is standard input)"
        ) from exc
    if len(data) > MOST_BYTES:
        raise InputError(f"{source}: the list is too long: at most {MOST_BYTES:,} bytes")
    if data.startswith(UTF16):  # as PowerShell writes it
        data = _recoded(data, source)
    data = data.removeprefix(codecs.BOM_UTF8)
    if b"\0" in data:
        return tuple(filter(None, os.fsdecode(data).split("\0")))
    lines = (line.removesuffix("\r") for line in os.fsdecode(data).split("\n"))
    return tuple(line for line in lines if line.strip() and not line.startswith("#"))
