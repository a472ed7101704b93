"""A folder of results that is there as a whole or not at all."""

import json
import os
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from facetlog.errors import InputError
from facetlog.regular_file import read_regular_text

__all__ = [
    "RUN_FILE",
    "check_replaceable",
    "kept_cameras",
    "output_folder",
    "written_files",
]

# Written last into each folder of results: who wrote it, and which files are its own.
RUN_FILE = "run.json"
RUN_SCHEMA = "facetlog-run/1"


def kept_cameras(out: Path | None) -> Path | None:
    """Where the cameras of pictures without poses are kept: beside a folder or file of results.

    >>> kept_cameras(Path("/out/photos")).as_posix()
    '/out/photos-cameras'
    """
    if out is None:
        return None
    folder = out.absolute()
    return folder.parent / f"{folder.name}-cameras"


def check_replaceable(folder: Path, option: str = "-o") -> None:
    """Raises InputError unless the folder is absent, empty, or holds an earlier run's files only.

    Called before the work, so that nobody waits for results that cannot be stored. `option` is how
    the folder was given.
    """
    try:
        if not folder.exists() and not folder.is_symlink():
            nearest = next(p for p in folder.absolute().parents if p.exists())
            if not nearest.is_dir() or not os.access(nearest, os.W_OK | os.X_OK):
                raise InputError(f"{folder} cannot be made: {nearest} is no folder to write in")
            return
        if folder.is_symlink() or not folder.is_dir():
            raise InputError(f"{folder} is no folder: give another name with {option}")
        present = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if not p.is_dir()}
    except (OSError, ValueError) as exc:
        raise InputError(f"{str(folder)!r} cannot be used: {exc}") from exc
    foreign = sorted(present - written_files(folder))
    if foreign:
        raise InputError(
            f"{folder} holds {foreign[0]}, which facetlog did not write: "
            f"give another folder with {option}"
        )


def written_files(folder: Path) -> set[str]:
    """The files of a folder that an earlier run wrote into it; none of another folder."""
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
    """A temporary folder to write into, renamed to `folder` when the body ends without an error.

    `about` goes into run.json beside the list of files. An earlier run's folder is replaced; after
    an error or Ctrl-C it is as it was.
    """
    check_replaceable(folder, option)
    folder = folder.absolute()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        made = _beside(folder)
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
        _put_in_place(made, folder)
    except OSError as exc:
        shutil.rmtree(made, ignore_errors=True)
        raise InputError(f"{folder} cannot be written: {exc}") from exc
    except BaseException:
        shutil.rmtree(made, ignore_errors=True)
        raise


def _put_in_place(made: Path, folder: Path) -> None:
    if not folder.exists():
        made.rename(folder)
        return
    old = _beside(folder)
    folder.rename(old)
    try:
        made.rename(folder)
    except OSError:
        old.rename(folder)
        raise
    shutil.rmtree(old)


def _beside(folder: Path) -> Path:
    """A new name on the same file system, so that a rename moves nothing."""
    return folder.with_name(f".{folder.name}.{uuid.uuid4().hex}")
