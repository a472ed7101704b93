"""Progress of a run: a bar on a terminal, a line now and then elsewhere; on stderr."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from facetlog.batch.run import Progress
from facetlog.plurals import many
from facetlog.terminal import note

LINE_SECONDS = 10.0
"""Between two lines where stderr is no terminal, as in the log of a night's run."""

DRAWN_SECONDS = 0.1


@contextmanager
def show_rate(doing: str = "classify", what: str = "scene") -> Iterator[Progress]:
    """Show progress with rate and time left; yield the function to report it to."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines(what)
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.progress import (
        Progress as Bar,
    )

    columns = (
        TextColumn(doing),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
        TextColumn("[red]{task.fields[errors]}"),
    )
    with Bar(*columns, console=console, transient=True, auto_refresh=False) as bar:
        task = bar.add_task(doing, total=None, rate="", errors="")
        clock = _Clock()

        def report(done: int, total: int, failed: int) -> None:
            clock.begin(done)
            if not clock.due(DRAWN_SECONDS, last=done == total):
                return
            errors = many(failed, "error") if failed else ""
            rate = clock.rate(done)
            bar.update(
                task,
                completed=done,
                total=total,
                rate=f"{rate:.3g}/s" if rate else "",
                errors=errors,
                refresh=True,
            )

        yield report


def _lines(what: str) -> Progress:
    clock = _Clock()

    def report(done: int, total: int, failed: int) -> None:
        clock.begin(done)
        if clock.due(LINE_SECONDS, last=False) and done < total:
            note(format_progress(done, total, failed, clock.rate(done), what))

    return report


def format_progress(done: int, total: int, failed: int, rate: float, what: str = "scene") -> str:
    """Return the progress in one line.

    >>> format_progress(500, 2000, 1, 10.0)
    '500 of 2000 scenes, 10/s, 2 min 30 s left, 1 with an error'
    """
    said = [f"{done} of {many(total, what)}"]
    if rate > 0:
        said.append(f"{rate:.3g}/s")
        said.append(f"{_duration((total - done) / rate)} left")
    if failed:
        said.append(f"{failed} with {'an error' if failed == 1 else 'errors'}")
    return ", ".join(said)


def _duration(seconds: float) -> str:
    """Return a length of time as people say it.

    >>> _duration(7265.0), _duration(4.2)
    ('2 h 1 min', '4 s')
    """
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


class _Clock:
    """When the next report is due, and the rate since the run began."""

    def __init__(self) -> None:
        self._last = time.monotonic()
        self._start: tuple[float, int] | None = None

    def due(self, seconds: float, *, last: bool) -> bool:
        """Return whether `seconds` have passed since the last report."""
        now = time.monotonic()
        if not last and now - self._last < seconds:
            return False
        self._last = now
        return True

    def begin(self, done: int) -> None:
        """Start the clock at the first call, when `done` rows were there already."""
        if self._start is None:
            self._start = time.monotonic(), done

    def rate(self, done: int) -> float:
        """Return rows a second since it began."""
        since, before = self._start or (time.monotonic(), done)
        return (done - before) / max(time.monotonic() - since, 1e-9)
