"""`facetlog recognize --follow`: a line for each view as it arrives, and the result at the end."""

import json
import shutil
import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from facetlog.__main__ import INTERRUPTED
from facetlog.commands.shared import NO, YES, JudgingOptions
from facetlog.degree_plot import Degrees, check_plots, collect_degrees
from facetlog.errors import InputError
from facetlog.kb.explaining.verdict_text import format_holding
from facetlog.output_folder import check_replaceable
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import Recognised, apply_stated_up, check_up
from facetlog.plurals import many
from facetlog.query_shell.words import nearest
from facetlog.report import format_verdicts_text, write_report
from facetlog.stream import Stop, StreamStep, steps
from facetlog.terminal import fit_on_one_line, note, show_times, warn

if TYPE_CHECKING:
    from facetlog.commands.recognize import FollowOptions, OutputOptions

__all__ = ["follow_views", "format_step_json"]


SCHEMA = "facetlog-stream/1"
DIGITS = 4
"""Digits of standard deviations and degrees in the lines after each view."""
SHOWN = 2  # open verdicts that a line has room for
# How long a followed folder may stay as it is, s: a robot drives to its next place in less.
FOLLOW_TIMEOUT_S = 30.0


def format_step(step: StreamStep) -> str:
    """Format what is known after a view, on one line."""
    if step.recognition is None:
        state = step.problem or "nothing is known yet"
        return f"{step.used:>4}  {fit_on_one_line(step.view)}: {state}"
    best = [f"{v.thing} is a {v.model} ({v.degree:.0%})" for v in step.recognition.best]
    said = [format_holding(best)]
    if step.largest_sd is not None:
        unit = " m" if step.scene is not None and step.scene.metric else ""
        said.append(f"sd ≤ {step.largest_sd:.2g}{unit}")
    if step.problem:
        said.append(step.problem)
    open_ = [v.summary for v in step.undecided]
    if open_:
        more = f" (and {len(open_) - SHOWN} more)" if len(open_) > SHOWN else ""
        said.append(f"open: {'; '.join(open_[:SHOWN])}{more}")
    return f"{step.used:>4}  {fit_on_one_line(step.view)}: {', '.join(said)}"


def format_step_json(step: StreamStep, *, full: bool = False) -> str:
    """Format a step as a line of JSON, the last one with all verdicts (`full`: whole proofs)."""
    found = step.recognition
    document: dict[str, object] = {
        "schema": SCHEMA,
        "view": step.view or None,
        "used": step.used,
        "largest_sd": _round_number(step.largest_sd),
        "problem": step.problem or None,
    }
    if step.ended:
        document["ended"] = step.ended
        document["recognition"] = None if found is None else found.to_json(full=full)
    elif found is not None:
        document["verdicts"] = [
            {"thing": v.thing, "model": v.model, "state": v.state.value,
             "degree": _round_number(v.degree), "degree_at_most": _round_number(v.degree_at_most),
             "summary": v.summary}
            for v in found.verdicts
        ]  # fmt: skip
    return json.dumps(document)


def _round_number(number: float | None) -> float | None:
    """Round a number to the digits that mean something."""
    return None if number is None else float(f"{number:.{DIGITS}g}")


@contextmanager
def _ignore_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C while what is known is reported and written."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _check_goal(stop: Stop, models: Iterable[str]) -> None:
    """Raise InputError if there is no such model, for the goal would never be reached."""
    if stop.until is None or stop.until.model in (known := tuple(models)):
        return
    meant = nearest(stop.until.model, known)
    guess = f"did you mean {meant}?" if meant else f"there are {', '.join(sorted(known))}"
    raise InputError(f"--until: there is no model {stop.until.model!r}; {guess}")


def _cut_line(line: str) -> str:
    """Cut a line to the width of the terminal."""
    width = shutil.get_terminal_size().columns
    fits = len(line) < width or not sys.stdout.isatty()
    return line if fits else f"{line[: width - 2]}…"


def follow_views(
    path: Path,
    judging: JudgingOptions,
    output: "OutputOptions",
    following: "FollowOptions",
    stop: Stop,
    *,
    unit: str | None,
    up: str | None,
) -> int:
    """Recognize what a folder shows while it is being filled; return the exit code.

    Ctrl-C ends it as a stop does, without a polish: what is known so far is reported and written.
    """
    from facetlog.perception.online.online_scene import OnlineScene
    from facetlog.perception.reading.follow_views import FollowedViews
    from facetlog.perception.reading.read_views import ViewSet

    out, as_json, full = output.out, output.as_json, output.full
    timeout = FOLLOW_TIMEOUT_S if following.timeout is None else following.timeout
    if out is not None:
        check_replaceable(out, inputs=(path, *judging.paths))
        check_plots()
    check_up(up)
    clock = StepClock()
    source = FollowedViews(path, unit=unit, trusted=judging.trust, timeout=timeout)
    last: StreamStep | None = None
    degrees: list[Degrees] = []
    interrupted = False
    with judging.open_base() as base:
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
        known = apply_stated_up(ViewSet(source.name, (), up=source.up, metric=source.metric), up)
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
            for last in steps(online, shown, base=base, stop=stop, polish=not following.no_polish):
                degrees.append(collect_degrees(last))
                if not last.ended:
                    typer.echo(format_step_json(last) if as_json else _cut_line(format_step(last)))
        except KeyboardInterrupt:
            interrupted = True
    for line in source.problems:
        warn(line)
    if last is None:
        note("interrupted before anything was known")
        return INTERRUPTED
    with _ignore_interrupts() if interrupted else nullcontext():
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
            typer.echo(format_step_json(last, full=full))
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
            typer.echo(format_verdicts_text(found, full=full))
        if interrupted:
            return INTERRUPTED
        return YES if last.recognition.best else NO
