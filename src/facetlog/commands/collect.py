"""`facetlog collect`: a robot drives a tour and collects pictures with their poses."""

import json
import math
import time
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.__main__ import INTERRUPTED
from facetlog.commands.robot_options import (
    Mcap,
    RobotAddress,
    RobotOptions,
    Start,
    end_at_signals,
    parse_number_list,
    parse_start,
)
from facetlog.commands.robot_words import COLLECT_AGAIN, format_early_end, reword_errors
from facetlog.commands.shared import NO, YES, AsJson, ModelOptions, command
from facetlog.errors import FacetlogError, InputError
from facetlog.plurals import many
from facetlog.terminal import error, note, warn

if TYPE_CHECKING:
    from facetlog.exploring.explorer import Explorer
    from facetlog.judging.view_verdicts import ViewVerdict, ViewVerdicts
    from facetlog.robot.collecting.next_stop import Chooser
    from facetlog.robot.collecting.record import Taken
    from facetlog.robot.collecting.request import Request
    from facetlog.robot.collecting.route import Circle
    from facetlog.robot.collecting.run import Collected
    from facetlog.robot.collecting.session import Ended
    from facetlog.robot.collecting.tour_file import Tour
    from facetlog.stream import Goal

__all__ = ["collect_command", "read_recorded_goal"]

SCHEMA = "facetlog-collected/1"
# One view alone has no depth: from two on there is something to judge.
LEAST_VIEWS = 2
DEFAULT_MOST = 24  # as many views as the paper's tour has, of one target


@dataclass(frozen=True, slots=True)
class TourOptions:
    """The way of the robot: a tour, or the exploration of one target."""

    tour: Annotated[
        str | None,
        typer.Option("--tour", metavar="CSV", help="Camera poses; `paper`: the built-in tour."),
    ] = None
    unit: Annotated[
        str | None,
        typer.Option("--unit", metavar="U", help="Unit of the tour: m, cm, mm, in or ft."),
    ] = None
    explore: Annotated[
        bool,
        typer.Option(
            "--explore", help="Instead of a tour, choose each next view by what is undecided."
        ),
    ] = False
    target: Annotated[
        str | None,
        typer.Option("--target", metavar="X,Y,Z", help="Position of what is explored (m)."),
    ] = None
    keep_out: Annotated[
        list[str] | None,
        typer.Option(
            "--keep-out",
            metavar="RADIUS",
            help="Distance that the robot keeps from the target (m), or X,Y,RADIUS; repeatable.",
        ),
    ] = None
    until: Annotated[
        str | None,
        typer.Option(
            "--until", metavar="GOAL", help='Explore until a goal is reached: "table >= 90%".'
        ),
    ] = None
    max_views: Annotated[
        int,
        typer.Option("--max-views", metavar="N", help="Largest number of views to explore with."),
    ] = DEFAULT_MOST
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run", help="Only print which view would follow those in DIR; do not drive."
        ),
    ] = False

    def check(self) -> "Goal | None":
        """Return the goal, if any; raise InputError for options that do not go together."""
        from facetlog.perception.min_views import FEWEST_VIEWS
        from facetlog.stream import Goal

        if not self.explore:
            if self.tour is None:
                raise InputError("give --tour CSV, or --explore --target X,Y,Z --keep-out RADIUS")
            alone = {"--target": self.target, "--until": self.until, "--dry-run": self.dry_run}
            for name in (name for name, value in alone.items() if value):
                raise InputError(f"{name} goes with --explore")
            return None
        if self.tour is not None:
            raise InputError("--explore chooses the views itself: leave out --tour")
        lacks = []
        if self.target is None:
            lacks.append("--target X,Y,Z (where what is looked at stands, metres)")
        if not self.keep_out:
            lacks.append("--keep-out RADIUS (how near the robot may come, metres)")
        if lacks and not self.dry_run:
            raise InputError(f"--explore needs {' and '.join(lacks)}")
        if self.max_views < FEWEST_VIEWS:
            raise InputError(
                f"--max-views {self.max_views}: a face needs {FEWEST_VIEWS} views or more"
            )
        return None if self.until is None else Goal.parse(self.until)

    def read_tour(self, unit_of_camera: float | None) -> "Tour":
        """Read the tour; of an exploration one without views that looks at the target.

        `unit_of_camera` is the unit of length in metres, unless --unit states it.
        """
        import numpy as np

        from facetlog.perception.reading.pose_files.file_values import get_metres_per
        from facetlog.robot.collecting.tour_file import PAPER_TOUR, Tour, make_paper_tour, read_tour

        unit = unit_of_camera if self.unit is None else get_metres_per(self.unit, "--unit")
        if self.tour == PAPER_TOUR:
            return make_paper_tour()
        if self.tour is not None:
            return read_tour(Path(self.tour), unit=unit)
        x, y, z = parse_number_list(self.target or "", "--target", "X,Y,Z (metres)", 3)
        return Tour(f"explore {x:g},{y:g},{z:g}", (), np.array([x, y, z]))

    @property
    def tour_file(self) -> Path | None:
        """The file of the tour, None of the built-in one and of an exploration."""
        return None if self.tour in (None, "paper") else Path(self.tour or "")

    def parse_circles(self) -> "float | tuple[Circle, ...] | None":
        """Return the radius about the target, or circles, into which the robot does not drive."""
        from facetlog.robot.collecting.route import Circle

        given = self.keep_out
        if not given:
            return None
        form = "RADIUS, or X,Y,RADIUS as often as needed (metres)"
        circles = []
        for text in given:
            numbers = parse_number_list(text, "--keep-out", form, 1, 3)
            if numbers[-1] <= 0:
                raise InputError(f"--keep-out {text!r:.40}: a radius is above 0")
            if len(numbers) == 1 and len(given) == 1:
                return numbers[0]
            if len(numbers) == 1:
                raise InputError(f"--keep-out {text!r:.40}: of several, each is X,Y,RADIUS")
            circles.append(Circle(*numbers))
        return tuple(circles)


@command
def collect_command(
    robot: RobotAddress,
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Folder for the views.")],
    drive: TourOptions,
    reach: RobotOptions,
    models: ModelOptions,
    mount: Annotated[
        Path | None,
        typer.Option(
            "--mount", metavar="TOML", help="Position of the camera head (see facetlog mount)."
        ),
    ] = None,
    start: Start = None,
    recognize: Annotated[
        bool, typer.Option("--recognize", help="Print what the models say after every view.")
    ] = False,
    mcap: Mcap = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Resume DIR: take the views that are missing there.")
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing recording.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Drive a robot along a tour, or explore, and collect pictures with their poses.

    Exit code 0: all views were taken, 1: some were left out, 3: a device failed. With --recognize
    or --explore also 1 if no model matches, or the goal of --until is not reached.
    """
    from facetlog.recordings.recording_request import check_recording
    from facetlog.robot.collecting.map_picture import Found
    from facetlog.robot.collecting.record import LOG_FILE
    from facetlog.robot.collecting.request import Request, check_begun
    from facetlog.robot.mount.mount import DEFAULT_MOUNT, read_mount

    begin = parse_start(start)
    goal = drive.check()
    reach.check()
    if drive.dry_run:
        if not (out / LOG_FILE).is_file():
            raise InputError(f"{out} holds no collection: --dry-run goes on from one")
        goal = goal or read_recorded_goal(out)
        with end_at_signals(), _open_judge(out, models, None, goal) as verdicts:
            return dry_run(out, make_explorer(verdicts, goal, drive.max_views), as_json=as_json)
    if resume:
        check_begun(out)
    if resume and start is None:
        raise InputError(
            "--resume: odometry restarts, so give by --start X,Y,HEADING_DEG where the robot "
            f"stands now{describe_last_pose(out)}"
        )
    optics, unit = reach.read_optics(drive.tour_file)
    request = Request(
        robot,
        drive.read_tour(unit),
        out,
        reach.camera,
        optics,
        DEFAULT_MOUNT if mount is None else read_mount(mount),
        begin,
        start_stated=start is not None,
        head=reach.head,
        head_port=reach.head_port,
        head_unheard=reach.head_unheard,
        latency=reach.latency,
        noisy=not reach.noiseless,
        keep_out=drive.parse_circles(),
        speed=reach.speed,
        resume=resume,
        model=reach.model,
        baud=reach.baud,
        until=drive.until,
    )
    with end_at_signals(), ExitStack() as stack:
        if mcap is not None:
            check_recording(mcap, out, models.paths, overwrite=overwrite)
        judging: ViewVerdicts | None = None
        explorer: Explorer | None = None
        if recognize or mcap or drive.explore:
            judging = stack.enter_context(_open_judge(out, models, mcap, goal))
        if judging and drive.explore:
            explorer = make_explorer(judging, goal, drive.max_views)
        collected = _collect(replace(request, chooser=explorer), judging)
        last = None
        if judging and (recognize or drive.explore):
            last = _wait_for_last_verdict(judging, len(collected.taken), degrees=drive.explore)
    if last is not None and collected.mapped is not None:
        collected.mapped.draw(out, [Found(name, loops) for name, loops in last.outlines])
    _print_result(collected, last, explored=explorer is not None, as_json=as_json)
    if collected.ended.fault is not None:  # which was reported when it came
        return collected.ended.fault.exit_code
    complete = not collected.plan.skipped and (last is None or bool(last.best))
    if explorer is not None and goal is not None:
        complete = explorer.reached
    return YES if complete else NO


def _open_judge(
    folder: Path, models: ModelOptions, mcap: Path | None, goal: "Goal | None"
) -> "ViewVerdicts":
    """Start the process that judges and records; refuse unusable models before the robot moves."""
    from facetlog.judging.view_verdicts import ViewVerdicts

    with models.open_base() as base:
        if goal is not None and goal.model not in base.models:
            raise InputError(f"--until: there is no model {goal.model!r}: give it by --models")
    return ViewVerdicts(folder, models.paths, trusted=models.trust, mcap=mcap)


class _ProgressLines:
    """Writes a line to stderr for each view, and for each verdict as it comes."""

    def __init__(self, verdicts: "ViewVerdicts | None", *, explores: bool = False) -> None:
        self._verdicts = verdicts
        self._most = "at most " if explores else ""
        self._began = time.monotonic()
        self.has_ended = False
        """Whether it was reported why the collection ended early, and how to go on."""

    def view_taken(self, done: int, total: int, view: "Taken") -> None:
        seconds = time.monotonic() - self._began
        note(
            f"view {done} of {self._most}{total} ({seconds:.0f} s): {view.name} from "
            f"{view.pose.centre[0]:.2f}, {view.pose.centre[1]:.2f} m, pan "
            f"{math.degrees(view.pan):+.1f}°, tilt {math.degrees(view.tilt):+.1f}°"
        )
        if self._verdicts is not None:
            # Where judging takes longer than driving the robot waits, so that the verdict that is
            # shown is never more than one view behind.
            _report(self._verdicts.last())
            if done >= LEAST_VIEWS:
                self._verdicts.ask(done)

    def warn(self, message: str) -> None:
        warn(message)

    def note(self, message: str) -> None:
        note(message)

    def ended_early(self, ended: "Ended", there: int, total: int) -> None:
        # Before anything is judged or mapped, which takes its time and may be interrupted.
        error(format_early_end(ended, there, total, most=self._most))
        self.has_ended = True


def _report(verdicts: "list[ViewVerdict]") -> None:
    for verdict in verdicts:
        note(f"of {verdict.views} views: {verdict.line}")


def _collect(request: "Request", verdicts: "ViewVerdicts | None") -> "Collected":
    from facetlog.robot.collecting.run import run_collection

    # An explorer reports itself what each view brought.
    explores = request.chooser is not None
    lines = _ProgressLines(None if explores else verdicts, explores=explores)
    try:
        with reword_errors(COLLECT_AGAIN):
            collected = run_collection(request, lines)
    except (FacetlogError, KeyboardInterrupt) as exc:
        if not lines.has_ended:
            raise
        code = exc.exit_code if isinstance(exc, FacetlogError) else INTERRUPTED
        raise typer.Exit(code) from exc
    return collected


def _wait_for_last_verdict(
    verdicts: "ViewVerdicts", views: int, *, degrees: bool
) -> "ViewVerdict | None":
    """Wait for the verdict on all views and return it; print those before it."""
    _report(verdicts.ready())
    if views < LEAST_VIEWS:
        return None
    verdicts.ask(views, finally_=True, degrees=degrees)
    come = verdicts.last()
    _report(come[:-1])
    return come[-1] if come else None


def _print_result(
    collected: "Collected",
    last: "ViewVerdict | None",
    *,
    explored: bool,
    as_json: bool,
) -> None:
    if as_json:
        document: dict[str, object] = {"schema": SCHEMA, **collected.to_json()}
        if last is not None:
            document["verdict"] = last.document if last.document is not None else last.fault
        typer.echo(json.dumps(document, indent=1))
        return
    there, wanted = len(collected.taken), len(collected.plan.stops) + len(collected.plan.skipped)
    earlier = there - collected.ended.taken
    # An exploration has no number of views to reach.
    views = many(there, "view") if explored else f"{there} of {earlier + wanted} views"
    early = ", ended early" if collected.ended.fault is not None else ""
    typer.echo(f"{views}, {collected.way:.1f} m driven in {collected.seconds:.0f} s{early}")
    if collected.reason:
        typer.echo(f"no further view: {collected.reason}")
    if last is not None:
        typer.echo(last.line)


def read_recorded_goal(folder: Path) -> "Goal | None":
    """Return the goal of a folder's last run, None without one; InputError for another folder."""
    from facetlog.robot.collecting.record import read_log
    from facetlog.stream import Goal

    until = [line.get("until") for line in read_log(folder) if "schema" in line][-1]
    return None if until is None else Goal.parse(str(until))


def make_explorer(verdicts: "ViewVerdicts", goal: "Goal | None", most: int) -> "Explorer":
    """Return the explorer, which asks the judging process for verdicts."""
    from facetlog.exploring.explorer import Explorer

    return Explorer(verdicts.explored, goal=goal, most=most)


def dry_run(folder: Path, explorer: "Chooser", *, as_json: bool) -> int:
    """Print which view comes next after those of a folder that was explored, and why.

    Return exit code 1 if none does. Raise InputError for another folder.
    """
    from facetlog.robot.collecting.next_stop import Around, Chosen, Finished, place_sd
    from facetlog.robot.collecting.record import read_log, read_record
    from facetlog.robot.collecting.run_sessions import list_runs

    lines = read_log(folder)
    around = Around.recorded(lines)
    _, taken = read_record(folder)
    if taken:
        newest = max(taken, key=lambda view: view.time)
        margin = place_sd(newest.covariance)
        # Pictures may have corrected the pose since then.
        runs = [run for run in list_runs(lines, folder) if run.began <= newest.time]
        here = runs[-1].place(newest.odometry) if runs else newest.robot
        around = replace(around.enlarge_keep_out(margin), here=here)
    found = explorer.next_stop(around, taken)
    if as_json:
        typer.echo(json.dumps(found.line, indent=1))
        return YES if isinstance(found, Chosen) else NO
    last = f"no further view: {found.reason}" if isinstance(found, Finished) else found.said[-1]
    for line in found.said[:-1] if isinstance(found, Chosen) else found.said:
        note(line)
    typer.echo(last)
    return YES if isinstance(found, Chosen) else NO


def describe_last_pose(folder: Path) -> str:
    """Return where an earlier run left the robot, as a hint for --start."""
    from facetlog.robot.collecting.option_words import format_start_pose
    from facetlog.robot.collecting.run_sessions import last_place

    try:
        last = last_place(folder)
    except InputError:
        last = None
    if last is None:
        return " (where it stood last is not recorded: measure it)"
    return f" ({last.how} {format_start_pose(last.pose)})"
