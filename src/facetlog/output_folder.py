"""A folder of results that is there as a whole or not at all."""

import json
import os
import shutil
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from facetlog.errors import InputError
from facetlog.output_file import check_no_input
from facetlog.safe_read import read_regular_text

__all__ = [
    "RUN_FILE",
    "UNFINISHED",
    "check_replaceable",
    "find_kept_cameras",
    "list_written_files",
    "output_folder",
]

# Written last into each folder of results: who wrote it, and which files are its own.
RUN_FILE = "run.json"
RUN_SCHEMA = "facetlog-run/1"

UNFINISHED = ".facetlog-"
"""Prefix of the folder into which a run writes until it is done; a killed run leaves it."""


def find_kept_cameras(out: Path | None) -> Path | None:
    """Return where cameras of pictures without poses are kept: beside the folder or file of
    results.

    >>> find_kept_cameras(Path("/out/photos")).as_posix()
    '/out/photos-cameras'
    """
    if out is None:
        return None
    folder = out.absolute()
    return folder.parent / f"{folder.name}-cameras"


def check_replaceable(folder: Path, option: str = "-o", inputs: Iterable[Path] = ()) -> None:
    """Raise InputError unless the folder is absent, empty, or holds an earlier run's files only.

    Called before the work, so that nobody waits for results that cannot be stored. `option` is how
    the folder was given; none of the `inputs` may be in it.
    """
    try:
        target = folder.resolve()
        if not target.exists():
            nearest = next(p for p in target.parents if p.exists())
            if not nearest.is_dir() or not os.access(nearest, os.W_OK | os.X_OK):
                raise InputError(f"{folder} cannot be made: {nearest} is no folder to write in")
            return
        if not target.is_dir():
            raise InputError(f"{folder} is no folder: give another name with {option}")
        if not os.access(target, os.W_OK | os.X_OK):
            raise InputError(f"{folder} is no folder to write in: give another with {option}")
        paths = (p.relative_to(target) for p in target.rglob("*") if not p.is_dir())
        present = {p.as_posix() for p in paths if not p.parts[0].startswith(UNFINISHED)}
        foreign = sorted(present - list_written_files(target))
        check_no_input(folder, option, inputs)
    except (OSError, ValueError, RuntimeError) as exc:  # RuntimeError: a link to itself
        raise InputError(f"{str(folder)!r} cannot be used: {exc}") from exc
    if foreign:
        raise InputError(
            f"{folder} holds {foreign[0]}, which facetlog did not write: "
            f"give another folder with {option}"
        )


def list_written_files(folder: Path) -> set[str]:
    """Return the files that an earlier run wrote into a folder; none for another folder."""
    try:
        run = json.loads(read_regular_text(folder / RUN_FILE))
    except (OSError, ValueError):
        return set()
    if not isinstance(run, dict) or run.get("schema") != RUN_SCHEMA:
        return set()
    files = run.get("files")
    return {str(f) for f in files} | {RUN_FILE} if isinstance(files, list) else set()


@contextmanager
def output_folder(folder: Path, about: dict[str, object], option: str = "-o") -> Iterator[Path]:
    """Make a temporary folder, whose files are moved to `folder` when the body ends without an
    error.

    `about` goes into run.json beside the list of files. An earlier run's files are replaced; after
    an error or Ctrl-C they are as they were. A folder that is there stays the same folder, which
    may be somebody's current one or a mount; a link to one stays a link.
    """
    check_replaceable(folder, option)
    folder = folder.resolve()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        made = _make_temporary_name(folder)
        made.mkdir()
    except OSError as exc:
        raise InputError(
            f"{folder} cannot be made: {exc.strerror}: choose another {option}"
        ) from exc
    try:
        yield made
        files = sorted(p.relative_to(made).as_posix() for p in made.rglob("*") if p.is_file())
        run = {"schema": RUN_SCHEMA, **about, "files": files}
        (made / RUN_FILE).write_text(json.dumps(run, indent=1) + "\n", encoding="utf-8")
        _move_into_place(made, folder)
    except OSError as exc:
        raise InputError(f"{folder} cannot be written: {exc}") from exc
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _move_into_place(made: Path, folder: Path) -> None:
    if made.parent != folder:
        made.rename(folder)
        return
    old = _make_temporary_name(folder)
    old.mkdir()
    moved: list[tuple[Path, Path]] = []
    try:
        for source, goal in ((folder, old), (made, folder)):
            for path in tuple(source.iterdir()):
                if not path.name.startswith(UNFINISHED):
                    moved.append((path, goal / path.name))
                    path.rename(goal / path.name)
    except BaseException:
        for before, after in reversed(moved):
            if not os.path.lexists(before):
                after.rename(before)
        raise
    finally:
        shutil.rmtree(old, ignore_errors=True)


def _make_temporary_name(folder: Path) -> Path:
    """Make up a new name on the same file system, so that a rename moves nothing: in an existing
    folder (the one above may be on another), else beside it.
    """
    name = f"{UNFINISHED}{uuid.uuid4().hex}"
    return folder / name if folder.exists() else folder.with_name(name)
