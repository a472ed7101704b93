"""`facetlog recognize --follow`: a line for each view as it comes, and all of it at the end."""

import json
import shutil
import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from itertools import chain
from pathlib import Path

import typer

from facetlog.__main__ import INTERRUPTED
from facetlog.commands.shared import NO, YES
from facetlog.counted import many
from facetlog.degree_plot import Degrees, check_plots, degrees_of
from facetlog.errors import InputError
from facetlog.kb.explaining.verdict_text import holding_text
from facetlog.output_folder import check_replaceable
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import Recognised, check_up, open_models, with_stated_up
from facetlog.query_shell.words import nearest
from facetlog.report import verdicts_text, write_report
from facetlog.stream import Stop, StreamStep, steps
from facetlog.terminal import note, one_line, show_times, warn

__all__ = ["SCHEMA", "followed", "step_json", "step_line"]

SCHEMA = "facetlog-stream/1"
DIGITS = 4
"""Of standard deviations and degrees in the lines after each view."""
# Open verdicts that a line has room for.
SHOWN = 2


def step_line(step: StreamStep) -> str:
    """What is known after a view, on one line."""
    if step.recognition is None:
        return f"{step.used:>4}  {one_line(step.view)}: {step.problem or 'nothing is known yet'}"
    best = [f"{v.thing} is a {v.model} ({v.degree:.0%})" for v in step.recognition.best]
    said = [holding_text(best)]
    if step.largest_sd is not None:
        unit = " m" if step.scene is not None and step.scene.metric else ""
        said.append(f"sd ≤ {step.largest_sd:.2g}{unit}")
    if step.problem:
        said.append(step.problem)
    open_ = [v.summary for v in step.undecided]
    if open_:
        more = f" (and {len(open_) - SHOWN} more)" if len(open_) > SHOWN else ""
        said.append(f"open: {'; '.join(open_[:SHOWN])}{more}")
    return f"{step.used:>4}  {one_line(step.view)}: {', '.join(said)}"


def step_json(step: StreamStep, *, full: bool = False) -> str:
    """The same as one line of JSON; of the last step all verdicts, `full` with whole proofs."""
    found = step.recognition
    document: dict[str, object] = {
        "schema": SCHEMA,
        "view": step.view or None,
        "used": step.used,
        "largest_sd": _rounded(step.largest_sd),
        "problem": step.problem or None,
    }
    if step.ended:
        document["ended"] = step.ended
        document["recognition"] = None if found is None else found.to_json(full=full)
    elif found is not None:
        document["verdicts"] = [
            {"thing": v.thing, "model": v.model, "state": v.state.value,
             "degree": _rounded(v.degree), "degree_at_most": _rounded(v.degree_at_most),
             "summary": v.summary}
            for v in found.verdicts
        ]  # fmt: skip
    return json.dumps(document)


def _rounded(number: float | None) -> float | None:
    """A number with the digits that mean something of what is known by then."""
    return None if number is None else float(f"{number:.{DIGITS}g}")


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """What is known is to be said and written: a second Ctrl-C comes too late."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _check_goal(stop: Stop, models: Iterable[str]) -> None:
    """InputError if the goal is a model that there is not: it would never be reached."""
    if stop.until is None or stop.until.model in (known := tuple(models)):
        return
    meant = nearest(stop.until.model, known)
    guess = f"did you mean {meant}?" if meant else f"there are {', '.join(sorted(known))}"
    raise InputError(f"--until: there is no model {stop.until.model!r}; {guess}")


def _fitting(line: str) -> str:
    """As much of a line as the terminal's has room for: a view takes one."""
    width = shutil.get_terminal_size().columns
    fits = len(line) < width or not sys.stdout.isatty()
    return line if fits else f"{line[: width - 2]}…"


def followed(
    path: Path,
    *,
    unit: str | None,
    up: str | None,
    timeout: float,
    models: tuple[Path, ...],
    trusted: bool,
    crisp: bool,
    raw: bool,
    stop: Stop,
    polish: bool,
    out: Path | None,
    as_json: bool,
    full: bool,
) -> int:
    """Recognises what a folder shows that is being filled; the exit code.

    Ctrl-C ends it as a stop does, without a polish: what is known so far is said and written.
    """
    from facetlog.perception.online.online_scene import OnlineScene
    from facetlog.perception.reading.follow_views import FollowedViews
    from facetlog.perception.reading.read_views import ViewSet

    if out is not None:
        check_replaceable(out, inputs=(path, *models))
        check_plots()
    check_up(up)
    clock = StepClock()
    source = FollowedViews(path, unit=unit, trusted=trusted, timeout=timeout)
    last: StreamStep | None = None
    degrees: list[Degrees] = []
    interrupted = False
    with open_models(models, trusted=trusted, crisp=crisp, raw=raw) as base:
        _check_goal(stop, base.models)
        views = iter(source)
        try:
            first = next(views, None)
        except KeyboardInterrupt:
            note("interrupted before the first view came")
            return INTERRUPTED
        if first is None:
            for line in source.problems:
                warn(line)
            raise InputError(f"{path}: {source.ended}")
        known = with_stated_up(ViewSet(source.name, (), up=source.up, metric=source.metric), up)
        online = OnlineScene(
            name=known.name,
            up=known.up,
            find_up=known.find_up,
            metric=known.metric,
            error_kind=source.error_kind,
            clock=clock,
        )
        shown = chain([first], views)
        try:
            for last in steps(online, shown, base=base, stop=stop, polish=polish):
                degrees.append(degrees_of(last))
                if not last.ended:
                    typer.echo(step_json(last) if as_json else _fitting(step_line(last)))
        except KeyboardInterrupt:
            interrupted = True
    for line in source.problems:
        warn(line)
    if last is None:
        note("interrupted before anything was known")
        return INTERRUPTED
    with _uninterrupted() if interrupted else nullcontext():
        if interrupted:
            online.finish(polish=False)
            last = replace(last, view="", scene=online.scene, problem="", ended="interrupted")
        else:
            last = replace(last, ended=source.ended or last.ended)
        note("interrupted; this is known so far" if interrupted else last.ended)
        show_times(clock)
        if last.problem:
            warn(last.problem)
        if as_json:
            typer.echo(step_json(last, full=full))
        if last.scene is None or last.recognition is None:
            note(f"too little was seen in {many(last.used, 'view')} to say what is there")
            return INTERRUPTED if interrupted else NO
        for line in last.scene.warnings:
            warn(line)
        kept = replace(known, views=online.key_views, source=path)
        found = Recognised(kept, last.scene, last.facts, last.recognition, clock)
        if out is not None:
            write_report(out, found, degrees=degrees, full=full)
        if not as_json:
            typer.echo(verdicts_text(found, full=full))
        if interrupted:
            return INTERRUPTED
        return YES if last.recognition.best else NO
