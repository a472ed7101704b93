"""Write to stderr: progress on a terminal, warnings, log records, and the table of times."""

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from facetlog.errors import FacetlogError, InputError, RuleSyntaxError
from facetlog.perception.step_clock import StepClock, StepTime
from facetlog.plain_text import plain_text

if TYPE_CHECKING:
    from facetlog.pipeline import Progress

__all__ = [
    "error",
    "error_lines",
    "fit_on_one_line",
    "make_short_line",
    "note",
    "printable",
    "set_loudness",
    "shortened",
    "show_progress",
    "show_times",
    "warn",
]


# Characters: of a word, which a path may be, and so many of it on each side of the cut; of a line.
LONGEST_WORD, KEPT, LONGEST_LINE = 255, 40, 3_000
_LONG_WORD = re.compile(rf"\S{{{LONGEST_WORD},}}")


class _Stderr:
    """Whether notes, progress and times go to stderr."""

    quiet = False


class _Lines(logging.Handler):
    """Writes log records as lines in the form of all others."""

    def emit(self, record: logging.LogRecord) -> None:
        message = record.getMessage()
        if record.levelno >= logging.WARNING:
            warn(message)
        else:
            note(f"[{record.relativeCreated / 1000:.3f} s] {message}")


_LINES = _Lines()
LEVELS = (logging.NOTSET, logging.INFO, logging.DEBUG)
"""Log levels by how often --verbose is given; the first leaves the level to Python, which
shows warnings."""


def set_loudness(*, quiet: bool, verbose: int) -> None:
    """Set what goes to stderr from now on: with `quiet` no notes, progress and times; with
    `verbose` also each step with its time, from 2 what helps to find a fault.
    """
    if quiet and verbose:
        raise InputError("--quiet and --verbose exclude each other: give one")
    _Stderr.quiet = quiet
    logger = logging.getLogger("facetlog")
    logger.addHandler(_LINES)
    logger.setLevel(LEVELS[min(verbose, len(LEVELS) - 1)])


def printable(text: str) -> str:
    """Replace control characters, which could steer a terminal, but keep indentation.

    >>> printable("  a\\x1b[31mb")
    '  a [31mb'
    """
    plain = plain_text(text)
    # Nearly all texts are printable as they are, which is known at once.
    return plain if plain.isprintable() else "".join(c if c.isprintable() else " " for c in plain)


def fit_on_one_line(text: str) -> str:
    """Put a text on one line, without control characters that a file name may hold.

    >>> fit_on_one_line("a\\nb")
    'a b'
    """
    return " ".join(printable(text).split())


def make_short_line(text: str) -> str:
    """Put a text on one line as messages have it: what is long is cut in the middle."""
    # Of what is very long the middle is not even looked at.
    return shortened(fit_on_one_line(_cut(text, 4 * LONGEST_LINE, 2 * LONGEST_LINE)))


def shortened(line: str) -> str:
    """Cut long words, and what is long anyway, in the middle.

    >>> shortened("  " + "1" * 1000 + " is too large").replace("1" * 40, "1 to 1")
    '  1 to 1…(920 more)…1 to 1 is too large'
    """
    line = _LONG_WORD.sub(lambda word: _cut(word.group(), LONGEST_WORD, KEPT), line)
    return _cut(line, LONGEST_LINE, LONGEST_LINE // 3)


def _cut(text: str, longest: int, kept: int) -> str:
    if len(text) <= longest:
        return text
    return f"{text[:kept]}…({len(text) - 2 * kept:,} more)…{text[-kept:]}"


def error_lines(fault: FacetlogError) -> tuple[str, ...]:
    """Return the lines of an error: one, or for models one for each of their faults.

    >>> error_lines(RuleSyntaxError("a.pl:1: no word\\na.pl:2: no test"))
    ('a.pl:1: no word', 'a.pl:2: no test')
    """
    message = str(fault)
    faults = message.splitlines() if isinstance(fault, RuleSyntaxError) else [message]
    lines = tuple(line for line in map(make_short_line, faults) if line)
    return lines or (make_short_line(message),)


def error(message: str) -> None:
    """Write one line that says what was wrong and the way out."""
    typer.echo(f"facetlog: {make_short_line(message)}", err=True)


def warn(message: str) -> None:
    """Write one line about something that was left out or may be wrong."""
    typer.echo(f"facetlog: warning: {make_short_line(message)}", err=True)


def note(message: str) -> None:
    """Write one line about what the reader may do next, unless --quiet is given."""
    if _Stderr.quiet:
        return
    typer.echo(f"facetlog: {make_short_line(message)}", err=True)


@contextmanager
def show_progress() -> Iterator["Progress | None"]:
    """Show progress until the body ends; None where stderr is not a terminal, or with --quiet."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn

    console = Console(stderr=True)
    if _Stderr.quiet or not console.is_terminal:
        yield None
        return
    columns = (TextColumn("{task.description:<20}"), BarColumn(), MofNCompleteColumn())
    # Drawn when a step reports, not by a thread of its own: pictures are decoded with stderr
    # turned away (see picture_file.py), which would swallow what another thread writes.
    with Progress(*columns, console=console, transient=True, auto_refresh=False) as display:
        tasks: dict[str, TaskID] = {}

        def report(step: str, done: int, total: int) -> None:
            if step not in tasks:
                tasks[step] = display.add_task(step, total=total)
            display.update(tasks[step], completed=done, total=total, refresh=True)

        yield report


def show_times(clock: StepClock) -> None:
    """Write the table of the time that each step took, the rest, and the whole run."""
    from rich.console import Console
    from rich.table import Table

    if _Stderr.quiet:
        return
    table = Table("step", box=None, pad_edge=False)
    table.add_column("wall s", justify="right")
    table.add_column("CPU s", justify="right")
    run, steps = clock.run, clock.total
    rest = StepTime("the rest", max(run.wall - steps.wall, 0.0), max(run.cpu - steps.cpu, 0.0))
    for time in (*clock.times, rest, run):
        table.add_row(time.name, f"{time.wall:.3f}", f"{time.cpu:.3f}")
    Console(stderr=True).print(table)
