"""`facetlog collect --explore`: what is looked at and asked, and the choice from a record."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.robot_options import numbers_in
from facetlog.commands.shared import NO, YES
from facetlog.errors import InputError
from facetlog.terminal import note

if TYPE_CHECKING:
    from facetlog.exploring.explorer import Explorer
    from facetlog.robot.collecting.next_stop import Chooser
    from facetlog.robot.collecting.tour_file import Tour
    from facetlog.stream import Goal
    from facetlog.view_verdicts import ViewVerdicts

__all__ = [
    "DEFAULT_MOST",
    "DryRun",
    "Explore",
    "MostViews",
    "Target",
    "Until",
    "checked_goal",
    "dry_run",
    "explorer_of",
    "recorded_goal",
    "target_tour",
]

DEFAULT_MOST = 24
"""As many views as the paper's tour has, of one target."""

Explore = Annotated[
    bool, typer.Option("--explore", help="No tour: each next view is chosen by what is undecided.")
]
Target = Annotated[
    str | None, typer.Option("--target", metavar="X,Y,Z", help="What is explored, metres.")
]
Until = Annotated[
    str | None,
    typer.Option("--until", metavar="GOAL", help='Explore until a degree: "table >= 90%".'),
]
MostViews = Annotated[
    int | None,
    typer.Option(
        "--max-views",
        metavar="N",
        help=f"Explore with so many views at most (default: {DEFAULT_MOST}).",
    ),
]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Say which view comes next after those in DIR, no more.")
]


def target_tour(target: str | None) -> "Tour":
    """A tour without views that looks at the target; InputError without one."""
    import numpy as np

    from facetlog.robot.collecting.tour_file import Tour

    if target is None:
        raise InputError("--explore needs --target X,Y,Z: where what is looked at stands (metres)")
    x, y, z = numbers_in(target, "--target", "X,Y,Z (metres)", 3)
    return Tour(f"explore {x:g},{y:g},{z:g}", (), np.array([x, y, z]))


def checked_goal(until: str | None, most: int) -> "Goal | None":
    """The goal of an exploration; InputError for another form, and for too few views."""
    from facetlog.perception.fewest_views import FEWEST_VIEWS
    from facetlog.stream import Goal

    if most < FEWEST_VIEWS:
        raise InputError(f"--max-views {most}: a face needs {FEWEST_VIEWS} views or more")
    return None if until is None else Goal.parse(until)


def recorded_goal(folder: Path) -> "Goal | None":
    """The goal of a folder's last run, None of one without; InputError for another folder."""
    from facetlog.robot.collecting.record import read_log
    from facetlog.stream import Goal

    until = [line.get("until") for line in read_log(folder) if "schema" in line][-1]
    return None if until is None else Goal.parse(str(until))


def explorer_of(verdicts: "ViewVerdicts", goal: "Goal | None", most: int) -> "Explorer":
    """Who chooses, with the verdicts of the process that judges."""
    from facetlog.exploring.explorer import Explorer

    return Explorer(verdicts.explored, goal=goal, most=most)


def dry_run(folder: Path, explorer: "Chooser", *, as_json: bool) -> int:
    """Prints which view comes next after those of a folder that was explored, and why.

    Exit code 1 if none does. InputError for another folder.
    """
    from facetlog.robot.collecting.next_stop import Around, Chosen, Finished, place_sd
    from facetlog.robot.collecting.record import read_log, read_record
    from facetlog.robot.collecting.run_sessions import runs_of

    lines = read_log(folder)
    around = Around.recorded(lines)
    _, taken = read_record(folder)
    if taken:
        newest = max(taken, key=lambda view: view.time)
        margin = place_sd(newest.covariance)
        # Pictures may have put right since then where it stands.
        runs = [run for run in runs_of(lines, folder) if run.began <= newest.time]
        here = runs[-1].place(newest.odometry) if runs else newest.robot
        around = replace(around.kept_off(margin), here=here)
    found = explorer.next_stop(around, taken)
    if as_json:
        typer.echo(json.dumps(found.line, indent=1))
        return YES if isinstance(found, Chosen) else NO
    last = f"no further view: {found.reason}" if isinstance(found, Finished) else found.said[-1]
    for line in found.said[:-1] if isinstance(found, Chosen) else found.said:
        note(line)
    typer.echo(last)
    return YES if isinstance(found, Chosen) else NO
