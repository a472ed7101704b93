"""Options of `facetlog collect`: which go together, what they drive or explore, and --dry-run."""

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
    from facetlog.judging.view_verdicts import ViewVerdicts
    from facetlog.robot.collecting.next_stop import Chooser
    from facetlog.robot.collecting.route import Circle
    from facetlog.robot.collecting.tour_file import Tour
    from facetlog.stream import Goal

__all__ = [
    "DEFAULT_MOST",
    "DryRun",
    "Explore",
    "MostViews",
    "Target",
    "Until",
    "asked_tour",
    "check_explored",
    "checked_explore",
    "circles_in",
    "dry_run",
    "explorer_of",
    "recorded_goal",
    "where_it_stood",
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
    from facetlog.perception.min_views import FEWEST_VIEWS
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
    """Return the explorer, which asks the judging process for verdicts."""
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


def checked_explore(
    explore: bool,
    tour: str | None,
    target: str | None,
    until: str | None,
    most: int,
    keep_out: list[str] | None,
    dry: bool,
) -> "Goal | None":
    """The goal, if there is one; InputError for options that do not go together."""
    if not explore:
        if tour is None:
            raise InputError("give --tour CSV, or --explore --target X,Y,Z --keep-out RADIUS")
        alone = {"--target": target, "--until": until, "--dry-run": dry or None}
        for name in (name for name, value in alone.items() if value is not None):
            raise InputError(f"{name} goes with --explore")
        return None
    if tour is not None:
        raise InputError("--explore chooses the views itself: leave out --tour")
    if not dry:
        _check_target(target, keep_out)
    return checked_goal(until, most)


def check_explored(folder: Path) -> None:
    """InputError for a folder without a collection, of which --dry-run says what comes next."""
    from facetlog.robot.collecting.record import LOG_FILE

    if not (folder / LOG_FILE).is_file():
        raise InputError(f"{folder} holds no collection: --dry-run goes on from one")


def _check_target(target: str | None, keep_out: list[str] | None) -> None:
    """InputError that names all that is missing for the exploration of one target."""
    lacks = []
    if target is None:
        lacks.append("--target X,Y,Z (where what is looked at stands, metres)")
    if not keep_out:
        lacks.append("--keep-out RADIUS (how near the robot may come, metres)")
    if lacks:
        raise InputError(f"--explore needs {' and '.join(lacks)}")


def circles_in(given: list[str] | None) -> "float | tuple[Circle, ...] | None":
    """One radius about the target, or circles."""
    from facetlog.robot.collecting.route import Circle

    if not given:
        return None
    form = "RADIUS, or X,Y,RADIUS as often as needed (metres)"
    circles = []
    for text in given:
        numbers = numbers_in(text, "--keep-out", form, 1, 3)
        if numbers[-1] <= 0:
            raise InputError(f"--keep-out {text!r:.40}: a radius is above 0")
        if len(numbers) == 1 and len(given) == 1:
            return numbers[0]
        if len(numbers) == 1:
            raise InputError(f"--keep-out {text!r:.40}: of several, each is X,Y,RADIUS")
        circles.append(Circle(*numbers))
    return tuple(circles)


def _tour(name: str, scale: float | None) -> "Tour":
    from facetlog.robot.collecting.tour_file import PAPER_TOUR, paper_tour, read_tour

    return paper_tour() if name == PAPER_TOUR else read_tour(Path(name), unit=scale)


def asked_tour(tour: str | None, target: str | None, scale: float | None) -> "Tour":
    """Return the tour of a file or name, else one without views that looks at the target."""
    return target_tour(target) if tour is None else _tour(tour, scale)


def where_it_stood(folder: Path) -> str:
    """Where an earlier run left the robot, as a hint for --start."""
    from facetlog.robot.collecting.option_words import stated_pose
    from facetlog.robot.collecting.run_sessions import last_place

    try:
        last = last_place(folder)
    except InputError:
        last = None
    if last is None:
        return " (where it stood last is not recorded: measure it)"
    return f" ({last.how} {stated_pose(last.pose)})"
