"""Running a command again whenever a file that it read has changed."""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from time import sleep
from typing import Annotated, NoReturn

import typer

from facetlog.commands.model.files import is_stdin
from facetlog.errors import FacetlogError, InputError
from facetlog.plurals import many
from facetlog.query_shell.model_files import Stamp, read_stamp
from facetlog.terminal import error, error_lines, note

__all__ = ["Ran", "Watch", "changes", "watched"]

LOOK_AGAIN_MS = 1000
"""Interval at which files are checked even without events.

Network and shared file systems report no changes; the price is a few calls of stat a second.
"""

Watch = Annotated[
    bool,
    typer.Option("--watch", help="Run again whenever one of the files changes; Ctrl-C ends it."),
]

Stamps = Mapping[Path, Stamp | None]
Wait = Callable[[frozenset[Path]], None]
"""Returns when something may have changed in one of the folders, or after a while."""


@dataclass(frozen=True, slots=True)
class Ran:
    """Result of one run: the exit code, and all files that it depends on."""

    code: int
    files: frozenset[Path]


def watched(run: Callable[[], Ran], named: Callable[[], Iterable[Path]], *, watch: bool) -> int:
    """Run a command and return its exit code; with `watch` run it again at every change until
    Ctrl-C.

    `named` says which files the arguments name now: new ones in a folder count as a change. An
    error of a run is reported, and the next change awaited.
    """
    if not watch:
        return run().code
    if any(map(is_stdin, named())):
        raise InputError("--watch needs files: standard input is read only once")
    return _run_for_ever(run, named)


def _run_for_ever(run: Callable[[], Ran], named: Callable[[], Iterable[Path]]) -> NoReturn:
    # What a failed run depends on is not known: the files of the one before stand in for them.
    used: frozenset[Path] = frozenset()

    def files() -> frozenset[Path]:
        return used | _list_named(named)

    before = _read_stamps(files())
    while True:
        try:
            used = run().files
        except FacetlogError as exc:
            for line in error_lines(exc):
                error(line)
        sys.stdout.flush()  # who reads a pipe wants the result now
        note(f"watching {many(len(files()), 'file')}; Ctrl-C ends it")
        # What changed while the run went on is run again: files known before keep their stamps.
        before = next(changes(files, {**_read_stamps(files()), **before}))


def _list_named(named: Callable[[], Iterable[Path]]) -> frozenset[Path]:
    try:
        return frozenset(named())
    except InputError:
        return frozenset()  # a folder from which the last model went


def _read_stamps(files: Iterable[Path], before: Stamps | None = None) -> Stamps:
    return {path: read_stamp(path, (before or {}).get(path)) for path in files}


def changes(
    files: Callable[[], frozenset[Path]], before: Stamps, wait: Wait | None = None
) -> Iterator[Stamps]:
    """Yield the stamps of the files each time that one has changed, come or gone.

    Stamps decide; what the file system reports only wakes earlier.
    """
    wait = wait or wait_for_events
    while True:
        now = _read_stamps(files(), before)
        if _have_changed(before, now):
            yield now
        before = now
        wait(frozenset(path.absolute().parent for path in now))


def _have_changed(before: Stamps, now: Stamps) -> bool:
    return before.keys() != now.keys() or any(
        not _is_same(stamp, now[path]) for path, stamp in before.items()
    )


def _is_same(one: Stamp | None, other: Stamp | None) -> bool:
    if one is None or other is None:
        return one is other
    return one.has_same_content(other)


def wait_for_events(folders: frozenset[Path]) -> None:
    """Wait for the next event in one of the folders, at most LOOK_AGAIN_MS.

    Folders are watched, not files: editors save by putting another file in their place.
    """
    from watchfiles import watch

    there = sorted(folder for folder in folders if folder.is_dir())
    if not there:
        sleep(LOOK_AGAIN_MS / 1000)
        return
    events = watch(*there, rust_timeout=LOOK_AGAIN_MS, yield_on_timeout=True, recursive=False)
    with closing(events):
        next(events)
