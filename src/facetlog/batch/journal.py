"""The journal of a run: every row as soon as there is one, so that none is lost or repeated.

A text file beside the output, only ever appended to: the first line says of which run it is, each
other one is a row. What a kill or a power cut leaves of a last line is cut off when it is opened.
"""

import fcntl
import json
import os
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, Self

from facetlog.batch.output import MOST_LINE_BYTES
from facetlog.batch.rows import Row, has_run_out, parse_row
from facetlog.errors import InputError
from facetlog.plurals import many
from facetlog.safe_read import check_regular, open_regular

FORMAT = "facetlog-journal/1"
HEAD = json.dumps({"journal": FORMAT}).removesuffix("}").encode()
"""How each journal begins."""

SYNC_SECONDS = 1.0
"""A power cut costs the rows of so long; a kill, that of the program alone, costs none."""


def get_journal_path(output: Path) -> Path:
    """Return where the journal of a run with this output is: of a link beside what it leads to."""
    place = output.resolve() if output.is_symlink() else output
    return place.with_name(f"{place.name}.partial")


def check_not_in_use(path: Path) -> None:
    """Raise InputError if another run is writing a journal there; nothing if there is none."""
    with suppress(OSError), open_regular(path) as file:  # what cannot be opened is told later
        _lock(file.fileno(), path, fcntl.LOCK_SH)


class Journal:
    """Rows by the path of their scene. A context manager; the file stays until it is removed."""

    def __init__(self, path: Path, descriptor: int) -> None:
        self.path = path
        self._descriptor = descriptor
        self._end = 0
        self._places: dict[str, tuple[int, int]] = {}
        self._synced = time.monotonic()

    @classmethod
    def opened(
        cls,
        path: Path,
        run: Mapping[str, Any],
        read_as: Mapping[str, str],
        *,
        afresh: bool = False,
    ) -> Self:
        """Return the journal of a run: a new one, or the one that is there with all that it holds.

        `run` says what it was made by, `read_as` with what options each scene is read. Rows of
        scenes that ran out of time or memory count for none: they are to be tried again. `afresh`
        throws away what the one that is there holds.

        Raise InputError if it cannot be written, is in use, or was begun by another run.
        """
        journal = cls(path, _locked(path))
        try:
            journal._take_up(run, read_as, afresh=afresh)
        except BaseException:
            journal.close()
            raise
        return journal

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, which stays."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def remove(self) -> None:
        """Remove the file, whose rows are in the output; one of another run stays."""
        if _is_at(self._descriptor, self.path):
            self.path.unlink()

    def __contains__(self, path: str) -> bool:
        return path in self._places

    def __len__(self) -> int:
        return len(self._places)

    def append(self, path: str, line: bytes) -> None:
        """Write the row of a scene; raise InputError if there is no room for it."""
        self._places[path] = self._written(line)
        if time.monotonic() - self._synced >= SYNC_SECONDS:
            self.sync()

    def sync(self) -> None:
        """Wait until all that was appended would survive a power cut."""
        os.fsync(self._descriptor)
        self._synced = time.monotonic()

    def rows(self, paths: Iterable[str]) -> Iterator[Row]:
        """Yield the rows of these scenes, in this order, read one by one."""
        for path in paths:
            start, length = self._places[path]
            row: Row = json.loads(os.pread(self._descriptor, length, start))
            row.setdefault("warnings", [])  # a journal that an older version began has none
            yield row

    def _take_up(self, run: Mapping[str, Any], read_as: Mapping[str, str], *, afresh: bool) -> None:
        with os.fdopen(os.dup(self._descriptor), "rb") as file:
            file.seek(0)
            head = file.readline(MOST_LINE_BYTES)
            if afresh and head.startswith(HEAD):
                pass
            elif head.endswith(b"\n"):
                _check_head(self.path, head, run)
                self._end = len(head)
                for line in iter(partial(file.readline, MOST_LINE_BYTES), b""):
                    if not line.endswith(b"\n") and len(line) < MOST_LINE_BYTES:
                        break  # cut off in the middle
                    row = _taken_up(line, f"{self.path}: row {len(self) + 1}")
                    wanted = read_as.get(row["path"], row["read_as"])
                    if wanted != row["read_as"]:
                        raise _begun_with(self.path, "options", row["read_as"], wanted)
                    if not has_run_out(row):
                        self._places[row["path"]] = (self._end, len(line))
                    self._end += len(line)
            elif not HEAD.startswith(head[: len(HEAD)]):  # cut off in the middle, too
                raise _no_journal(self.path)
        os.ftruncate(self._descriptor, self._end)
        if self._end == 0:
            first = {"journal": FORMAT, **run}
            self._written(json.dumps(first).encode())
            self.sync()

    def _written(self, line: bytes) -> tuple[int, int]:
        data = memoryview(line + b"\n")
        start, length = self._end, len(data)
        try:
            while data:
                data = data[os.write(self._descriptor, data) :]
        except OSError as exc:
            os.ftruncate(self._descriptor, start)  # which needs no room
            raise InputError(
                f"{self.path}: cannot be written: {exc.strerror}: it holds "
                f"{many(len(self), 'row')}; make room and give --resume"
            ) from exc
        self._end += length
        return start, length


def _locked(path: Path) -> int:
    """Open a journal that no other run has; InputError if one does, or it cannot be written."""
    check_regular(path)
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
        except OSError as exc:
            raise InputError(f"{path}: cannot be written: {exc.strerror}") from exc
        try:
            _lock(descriptor, path, fcntl.LOCK_EX)
            if _is_at(descriptor, path):  # else the run that had it has just removed it
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _lock(descriptor: int, path: Path, kind: int) -> None:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError(f"{path}: another run is writing there: wait for it") from None
    except OSError as exc:
        raise InputError(f"{path}: cannot be locked: {exc.strerror}") from exc


def _is_at(descriptor: int, path: Path) -> bool:
    """Return whether an open file is the one that has this name now."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except OSError:
        return False


def _check_head(path: Path, head: bytes, run: Mapping[str, Any]) -> None:
    """Raise InputError if the journal is none, or was begun by another run than this."""
    try:
        begun = json.loads(head)
    except (ValueError, RecursionError):
        begun = None
    if not isinstance(begun, dict) or begun.get("journal") != FORMAT:
        raise _no_journal(path)
    for key, value in run.items():
        if begun.get(key) != value:
            raise _begun_with(path, key, begun.get(key), value)


def _no_journal(path: Path) -> InputError:
    return InputError(f"{path}: is no journal of classify: move it away")


def _taken_up(line: bytes, place: str) -> Row:
    try:
        data = json.loads(line)
    except (ValueError, RecursionError) as exc:
        raise InputError(f"{place}: is no row: move the journal away, or give --overwrite") from exc
    return parse_row(data, place)


def _begun_with(path: Path, what: str, then: object, now: object) -> InputError:
    return InputError(
        f"{path}: was begun with other {what}: {then}, now {now}: give those as then, or "
        "--overwrite to start over"
    )
