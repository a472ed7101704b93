"""A run: scenes to workers, rows into the journal, and out in the order given."""

import json
import logging
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from facetlog.batch.content import hash_content
from facetlog.batch.journal import Journal, check_not_in_use, get_journal_path
from facetlog.batch.output import check_format, read_rows
from facetlog.batch.pool import Answer, Task
from facetlog.batch.profile import Profile
from facetlog.batch.rows import Row, has_run_out
from facetlog.batch.settings import Item, Settings
from facetlog.errors import InputError
from facetlog.output_file import check_output_file
from facetlog.plain_text import plain_text
from facetlog.safe_read import check_regular

_LOG = logging.getLogger(__name__)

Progress = Callable[[int, int, int], None]
"""Called with how many rows there are, of how many, and how many of them have errors."""


class Workers(Protocol):
    """Workers that answer tasks: processes here, or a cluster."""

    @property
    def models_hash(self) -> str:
        """Hash of the models."""

    @property
    def models(self) -> tuple[str, ...]:
        """The names of the models that they ask."""

    @property
    def profile(self) -> Profile:
        """Where their time went."""

    def answers(self, tasks: Iterable[Task]) -> Iterator[Answer]:
        """Return an answer to each task, as they come."""
        ...


@dataclass(frozen=True, slots=True)
class Plan:
    """Plan of a run: its scenes in order, and where its rows go, if anywhere.

    `resume` takes up what an earlier run to the same output left, but for scenes that ran out of
    time or memory, `overwrite` throws it away.
    `old` are rows of an earlier table by path: of a scene whose content, models and options are
    the same as then, the row is taken over.
    """

    items: tuple[Item, ...]
    settings: Settings
    output: Path | None = None
    resume: bool = False
    overwrite: bool = False
    old: Mapping[str, Row] | None = None


@dataclass(frozen=True, slots=True)
class Finished:
    """The rows of a run that ran through; `kept` of them were there before its `seconds`."""

    journal: Journal
    items: tuple[Item, ...]
    kept: int
    seconds: float

    def rows(self) -> Iterator[Row]:
        """Return the rows in the order in which the scenes were given, as often as wanted."""
        return self.journal.rows(item.path for item in self.items)


def check_output(plan: Plan, inputs: Iterable[Path] = ()) -> None:
    """Raise InputError if the rows may not be written at the end, or something is in the way.

    `inputs` are the files that the run reads.
    """
    output = plan.output
    if output is None:
        return
    check_format(output)
    journal = get_journal_path(output)
    # Both are read again: to go on, and to put rows into their order.
    for path in (output, journal):
        check_output_file(path, "-o", inputs, overwrite=True)
        check_regular(path)
    check_not_in_use(journal)
    if plan.resume or plan.overwrite:
        return
    if journal.exists():
        raise InputError(
            f"{journal} is of a run that was stopped: give --resume to go on with it, or "
            "--overwrite to start over"
        )
    if output.is_file() and output.stat().st_size:
        raise InputError(f"{output} exists: give --overwrite, or --resume to add what is missing")


@contextmanager
def classified(
    plan: Plan, workers: Workers, progress: Progress | None = None
) -> Iterator[Finished]:
    """Return the rows of all scenes of a plan, once the last one is there.

    The journal stays, whether something is raised or not: who has written the output removes it.
    Raise InputError if the journal cannot be used or written.
    """
    with ExitStack() as stack:
        journal = _journal(plan, workers.models_hash, stack)
        _take_over(plan, workers.models_hash, journal)
        missing = [item for item in plan.items if item.path not in journal]
        kept = done = len(plan.items) - len(missing)
        failed, start = 0, time.perf_counter()
        try:
            if progress is not None:
                progress(done, len(plan.items), failed)
            for answer in workers.answers(map(Task, missing)):
                journal.append(answer.task.item.path, answer.line)
                done += 1
                failed += answer.failed
                _LOG.info("%s is done, %d of %d", answer.task.item.path, done, len(plan.items))
                if progress is not None:
                    progress(done, len(plan.items), failed)
        finally:
            journal.sync()
        yield Finished(journal, plan.items, kept, time.perf_counter() - start)


def _journal(plan: Plan, models_hash: str, stack: ExitStack) -> Journal:
    if plan.output is None:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="facetlog-"))
        path = Path(folder, "rows")
    else:
        path = get_journal_path(plan.output)
    read_as = {item.path: item.read_as(plan.settings) for item in plan.items}
    begun = path.exists()
    afresh = plan.overwrite and not plan.resume
    opened = Journal.opened(path, {"models": models_hash}, read_as, afresh=afresh)
    journal = stack.enter_context(opened)
    if plan.output is not None and plan.resume and plan.output.exists() and not begun:
        try:
            _take_up(plan.output, models_hash, read_as, journal)
        except BaseException:
            journal.remove()
            raise
    return journal


def _take_up(output: Path, models_hash: str, read_as: Mapping[str, str], journal: Journal) -> None:
    """Copy the rows of an existing table into the journal.

    Raise InputError if it is of another run.
    """
    for row in read_rows(output):
        if row["models_hash"] != models_hash:
            raise InputError(f"{output}: was made by other models: give those, or --overwrite")
        wanted = read_as.get(row["path"])
        if wanted is not None and wanted != row["read_as"]:
            raise InputError(
                f"{output}: {row['path']} was read with {row['read_as']}, now {wanted}: give the "
                "options as then, or --overwrite"
            )
        if wanted is not None and not has_run_out(row):
            journal.append(row["path"], _line(row))


def _take_over(plan: Plan, models_hash: str, journal: Journal) -> None:
    """Copy the rows of the older table that are still valid into the journal."""
    for item in plan.items:
        row = (plan.old or {}).get(plain_text(item.path))
        if row is None or item.path in journal or row["error"] is not None:
            continue
        same = (models_hash, item.read_as(plan.settings))
        if (row["models_hash"], row["read_as"]) == same and _unchanged(item, row["sha256"]):
            journal.append(item.path, _line(row))


def _unchanged(item: Item, sha256: str) -> bool:
    try:
        return hash_content(Path(item.place)) == sha256
    except InputError:
        return False


def _line(row: Row) -> bytes:
    return json.dumps(row, separators=(",", ":")).encode()
