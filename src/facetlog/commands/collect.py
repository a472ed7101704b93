"""`facetlog collect`: a robot drives a tour and collects pictures with their poses."""

import json
import math
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.__main__ import INTERRUPTED
from facetlog.commands.collect_options import (
    DEFAULT_MOST,
    DryRun,
    Explore,
    MostViews,
    Target,
    Until,
    asked_tour,
    check_explored,
    checked_explore,
    circles_in,
    explorer_of,
    recorded_goal,
    where_it_stood,
)
from facetlog.commands.collect_options import dry_run as say_next
from facetlog.commands.robot_options import (
    DEFAULT_SPEED,
    Baud,
    CameraFile,
    CameraUrl,
    Head,
    HeadPort,
    HeadUnheard,
    Latency,
    Mcap,
    Model,
    Noiseless,
    RobotAddress,
    Speed,
    Start,
    checked_head,
    checked_speed,
    ended_by_signals,
    optics_of,
    parsed_start,
)
from facetlog.commands.robot_words import (
    COLLECT_AGAIN,
    early_end_line,
    wording_errors,
)
from facetlog.commands.shared import NO, YES, AsJson, Models, Trust, command
from facetlog.counted import many
from facetlog.errors import FacetlogError, InputError
from facetlog.terminal import error, note, warn

if TYPE_CHECKING:
    from facetlog.exploring.explorer import Explorer
    from facetlog.judging.view_verdicts import ViewVerdict, ViewVerdicts
    from facetlog.robot.collecting.record import Taken
    from facetlog.robot.collecting.request import Request
    from facetlog.robot.collecting.run import Collected
    from facetlog.robot.collecting.session import Ended
    from facetlog.stream import Goal

__all__ = ["collect_command"]

SCHEMA = "facetlog-collected/1"
# One view alone has no depth: of two on there is something to judge.
LEAST_VIEWS = 2


@command
def collect_command(
    robot: RobotAddress,
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Folder for the views.")],
    tour: Annotated[
        str | None,
        typer.Option("--tour", metavar="CSV", help="Camera poses; `paper`: the built-in one."),
    ] = None,
    explore: Explore = False,
    target: Target = None,
    until: Until = None,
    max_views: MostViews = None,
    dry_run: DryRun = False,
    camera: CameraUrl = None,
    head: Head = "sony-evi-d30",
    head_port: HeadPort = "aux1",
    head_unheard: HeadUnheard = False,
    mount: Annotated[
        Path | None,
        typer.Option("--mount", metavar="TOML", help="Where the head sits: see facetlog mount."),
    ] = None,
    start: Start = None,
    camera_file: CameraFile = None,
    unit: Annotated[
        str | None, typer.Option("--unit", metavar="U", help="Of the tour: m, cm, mm, in, ft.")
    ] = None,
    speed: Speed = DEFAULT_SPEED,
    keep_out: Annotated[
        list[str] | None,
        typer.Option(
            "--keep-out",
            metavar="RADIUS",
            help="No part of the robot comes nearer to what is looked at (m), or X,Y,RADIUS.",
        ),
    ] = None,
    recognize: Annotated[
        bool, typer.Option("--recognize", help="Say after every view what the models say.")
    ] = False,
    models: Models = None,
    trust: Trust = False,
    mcap: Mcap = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Resume DIR: take the views that are missing there.")
    ] = False,
    latency: Latency = None,
    noiseless: Noiseless = False,
    model: Model = None,
    baud: Baud = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace a recording that is there already.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Drives a tour, or explores, and takes views. Exit code 0: all, 1: some left out, 3: a device.

    With --recognize or --explore also 1 if no model matches, or --until is not reached.
    """
    from facetlog.perception.reading.pose_files.file_values import metres_per
    from facetlog.recordings.recording_request import check_recording
    from facetlog.robot.collecting.map_picture import Found
    from facetlog.robot.collecting.request import Request, check_begun
    from facetlog.robot.mount.mount import DEFAULT_MOUNT, read_mount

    begin = parsed_start(start)
    most = DEFAULT_MOST if max_views is None else max_views
    goal = checked_explore(explore, tour, target, until, most, keep_out, dry_run)
    checked_speed(speed)
    checked_head(head, head_port, unheard=head_unheard)
    if explore and dry_run:
        check_explored(out)
        goal = goal or recorded_goal(out)
        with ended_by_signals(), ExitStack() as stack:
            verdicts = _judging(stack, out, tuple(models or ()), trust, None, goal)
            return say_next(out, explorer_of(verdicts, goal, most), as_json=as_json)
    if resume:
        check_begun(out)
    if resume and start is None:
        raise InputError(
            "--resume: odometry restarts, so give by --start X,Y,HEADING_DEG where the robot "
            f"stands now{where_it_stood(out)}"
        )
    optics, of_file = optics_of(camera_file, None if tour in (None, "paper") else Path(tour))
    scale = metres_per(unit, "--unit") if unit is not None else of_file
    request = Request(
        robot,
        asked_tour(tour, target, scale),
        out,
        camera,
        optics,
        DEFAULT_MOUNT if mount is None else read_mount(mount),
        begin,
        start_stated=start is not None,
        head=head,
        head_port=head_port,
        head_unheard=head_unheard,
        latency=latency,
        noisy=not noiseless,
        keep_out=circles_in(keep_out),
        speed=speed,
        resume=resume,
        model=model,
        baud=baud,
        until=until,
    )
    with ended_by_signals(), ExitStack() as stack:
        if mcap is not None:
            check_recording(mcap, out, models or (), overwrite=overwrite)
        judging: ViewVerdicts | None = None
        explorer: Explorer | None = None
        if recognize or mcap or explore:
            judging = _judging(stack, out, tuple(models or ()), trust, mcap, goal)
        if judging and explore:
            explorer = explorer_of(judging, goal, most)
        collected = _collected(replace(request, chooser=explorer), judging)
        said = judging if recognize or explore else None
        last = _last_verdict(said, len(collected.taken), degrees=explore) if said else None
    if last is not None and collected.mapped is not None:
        collected.mapped.draw(out, [Found(said, loops) for said, loops in last.outlines])
    _answer(collected, last, explored=explorer is not None, as_json=as_json)
    if collected.ended.fault is not None:  # which was said when it came
        return collected.ended.fault.exit_code
    complete = not collected.plan.skipped and (last is None or bool(last.best))
    if explorer is not None and goal is not None:
        complete = explorer.reached
    return YES if complete else NO


def _judging(
    stack: ExitStack,
    folder: Path,
    models: tuple[Path, ...],
    trusted: bool,
    mcap: Path | None,
    goal: "Goal | None" = None,
) -> "ViewVerdicts":
    """The process that judges and records; unusable models are refused before the robot moves."""
    from facetlog.judging.view_verdicts import ViewVerdicts
    from facetlog.pipeline import open_models

    with open_models(models, trusted=trusted) as base:
        if goal is not None and goal.model not in base.models:
            raise InputError(f"--until: there is no model {goal.model!r}: give it by --models")
    verdicts = ViewVerdicts(folder, models, trusted=trusted, mcap=mcap)
    return stack.enter_context(verdicts)


class _ProgressLines:
    """Lines on stderr: each view, and each verdict as it comes."""

    def __init__(self, verdicts: "ViewVerdicts | None", *, explores: bool = False) -> None:
        self._verdicts = verdicts
        self._most = "at most " if explores else ""
        self._began = time.monotonic()
        self.has_ended = False
        """Whether it was said why the collection ended early, and how to go on."""

    def view_taken(self, done: int, total: int, view: "Taken") -> None:
        seconds = time.monotonic() - self._began
        note(
            f"view {done} of {self._most}{total} ({seconds:.0f} s): {view.name} from "
            f"{view.pose.centre[0]:.2f}, {view.pose.centre[1]:.2f} m, pan "
            f"{math.degrees(view.pan):+.1f}°, tilt {math.degrees(view.tilt):+.1f}°"
        )
        if self._verdicts is not None:
            # The robot stands: where judging takes longer than driving it waits, so that what is
            # said is never more than one view behind.
            _report(self._verdicts.last())
            if done >= LEAST_VIEWS:
                self._verdicts.ask(done)

    def warn(self, message: str) -> None:
        warn(message)

    def note(self, message: str) -> None:
        note(message)

    def ended_early(self, ended: "Ended", there: int, total: int) -> None:
        # Before anything is judged or mapped, which takes its time and may be interrupted.
        error(early_end_line(ended, there, total, most=self._most))
        self.has_ended = True


def _report(verdicts: "list[ViewVerdict]") -> None:
    for verdict in verdicts:
        note(f"of {verdict.views} views: {verdict.line}")


def _collected(request: "Request", verdicts: "ViewVerdicts | None") -> "Collected":
    from facetlog.robot.collecting.run import run_collection

    # Who explores says himself what each view brought.
    explores = request.chooser is not None
    lines = _ProgressLines(None if explores else verdicts, explores=explores)
    try:
        with wording_errors(COLLECT_AGAIN):
            collected = run_collection(request, lines)
    except (FacetlogError, KeyboardInterrupt) as exc:
        if not lines.has_ended:
            raise
        code = exc.exit_code if isinstance(exc, FacetlogError) else INTERRUPTED
        raise typer.Exit(code) from exc
    return collected


def _last_verdict(verdicts: "ViewVerdicts", views: int, *, degrees: bool) -> "ViewVerdict | None":
    """The verdict on all views, once it is there; those before it are printed."""
    _report(verdicts.ready())
    if views < LEAST_VIEWS:
        return None
    verdicts.ask(views, finally_=True, degrees=degrees)
    come = verdicts.last()
    _report(come[:-1])
    return come[-1] if come else None


def _answer(
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
    # Who explores has no number that all are.
    views = many(there, "view") if explored else f"{there} of {earlier + wanted} views"
    early = ", ended early" if collected.ended.fault is not None else ""
    typer.echo(f"{views}, {collected.way:.1f} m driven in {collected.seconds:.0f} s{early}")
    if collected.reason:
        typer.echo(f"no further view: {collected.reason}")
    if last is not None:
        typer.echo(last.line)
