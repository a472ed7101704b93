"""`facetlog recognize`, `reconstruct` and `demo`: from pictures and shapes to verdicts."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.shape_options import OverrideFile, Sensor, StatedOptions
from facetlog.commands.shape_options import read as read_shape
from facetlog.commands.shared import (
    NO,
    YES,
    AsJson,
    Full,
    JudgingOptions,
    Overwrite,
    Trust,
    command,
)
from facetlog.errors import InputError
from facetlog.output_file import OWN_SCENE, check_output_file
from facetlog.output_folder import check_replaceable, find_kept_cameras
from facetlog.perception.length_units import parse_length
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import (
    DEMO_WORLD,
    FrontEnd,
    Method,
    Progress,
    Recognised,
    apply_known_scale,
    holds_shape,
    read_views_from,
    recognize_scene,
    recognize_views,
    reconstruct_views,
    render_simulated_views,
    write_scene_file,
)
from facetlog.stream import Goal, Stop
from facetlog.terminal import note, show_progress, show_times, warn

if TYPE_CHECKING:
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.perception.facts.known_length import Scale
    from facetlog.perception.reading.read_views import ViewSet

__all__ = ["FollowOptions", "demo_command", "recognize_command", "reconstruct_command"]

WAY_TO_METRES = "give --unit, or a length that you know, as --scale 'height = 74 cm'"

Views = Annotated[
    Path,
    typer.Argument(
        metavar="VIEWS",
        help="Folder of pictures, alone or with camera poses (transforms.json, COLMAP, …), or a "
        "poses file.",
    ),
]
Source = Annotated[
    Path,
    typer.Argument(
        metavar="SOURCE",
        help="Folder of pictures, alone or with camera poses, or its poses file; or a scene, mesh "
        "or cloud, or the folder of one.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "-o", "--out", metavar="OUT", help="Folder for the scene, facts, meshes and pictures."
    ),
]


@dataclass(frozen=True, slots=True)
class _MethodOptions:
    """How pictures become a scene."""

    front_end: Annotated[
        FrontEnd,
        typer.Option(
            "--front-end", help="lines: any scene; paper: one bright block on dark ground."
        ),
    ] = FrontEnd.LINES
    sd_limit: Annotated[
        float | None,
        typer.Option(
            "--sd-limit",
            metavar="LENGTH",
            help="Ignore further views of a vertex once its standard deviation is below this "
            "(metres, or units of the poses).",
        ),
    ] = None

    def make_method(self, scale: str | None = None) -> Method:
        """Return the method; raise InputError for a length that cannot be."""
        if self.sd_limit is not None and not self.sd_limit > 0:
            raise InputError(f"--sd-limit {self.sd_limit:g}: give a length above 0")
        if scale is None:
            return Method(self.front_end, self.sd_limit)
        from facetlog.perception.facts.known_length import KnownLength

        return Method(self.front_end, self.sd_limit, KnownLength.parse(scale))


@dataclass(frozen=True, slots=True)
class _ViewOptions(_MethodOptions):
    """Statements about pictures and their poses."""

    unit: Annotated[
        str | None,
        typer.Option("--unit", metavar="U", help="Unit of the poses: m, cm, mm, in or ft."),
    ] = None
    up: Annotated[
        str | None,
        typer.Option(
            "--up",
            metavar="AXIS",
            help="Upward axis of the poses: x, y, z, -x, -y, -z, auto or none.",
        ),
    ] = None
    square: Annotated[
        str | None,
        typer.Option(
            "--square",
            metavar="LENGTH",
            help="Printed side length of a square of the mat, if its bar is not 100 mm long: "
            '"17.6 ± 0.02 mm".',
        ),
    ] = None
    scale: Annotated[
        str | None,
        typer.Option(
            "--scale",
            metavar="LENGTH",
            help='A known length, if the unit is unknown: "height = 74 cm", "v3 v7 = 25 ± 0.1 cm".',
        ),
    ] = None
    keep_poses: Annotated[
        bool,
        typer.Option("--keep-poses", help="Do not refine poses whose covariances the file states."),
    ] = False

    def read_views(self, views: Path, cameras: Path | None, *, trust: bool) -> "ReadViews":
        """Return what reads the views; raise InputError for a length that cannot be read.

        `cameras` is the folder for cameras that structure from motion finds.
        """
        square = None if self.square is None else parse_length(self.square, "--square")
        return lambda **progress: read_views_from(
            views,
            unit=self.unit,
            up=self.up,
            square=square,
            keep=cameras,
            trusted=trust,
            keep_poses=self.keep_poses,
            **progress,
        )


@dataclass(frozen=True, slots=True)
class _SourceOptions(_ViewOptions):
    """Statements about pictures, scenes, meshes and clouds."""

    sensor: Sensor = None
    override_file: OverrideFile = False

    def check_no_picture_options(self, path: Path) -> None:
        """Raise InputError if an option was given that is for pictures alone."""
        of_pictures = {
            "--front-end paper": self.front_end is not FrontEnd.LINES,
            "--sd-limit": self.sd_limit is not None,
            "--square": self.square is not None,
            "--keep-poses": self.keep_poses,
        }
        for option in (name for name, given in of_pictures.items() if given):
            raise InputError(f"{option} is for pictures, and {path} holds none: leave it out")


ReadViews = Callable[..., "ViewSet"]
"""Called with `progress` and `clock`."""


@dataclass(frozen=True, slots=True)
class FollowOptions:
    """How a folder that is being filled is followed."""

    follow: Annotated[
        bool,
        typer.Option("--follow", help="Process views as they arrive, with a verdict after each."),
    ] = False
    until: Annotated[
        str | None,
        typer.Option(
            "--until", metavar="GOAL", help='Stop at a goal, as "table >= 90%" (with --follow).'
        ),
    ] = None
    max_views: Annotated[
        int | None,
        typer.Option("--max-views", metavar="N", min=1, help="Stop after N views (with --follow)."),
    ] = None
    timeout: Annotated[
        float | None,
        typer.Option(
            "--timeout",
            metavar="S",
            min=0.0,
            help="Stop if no new view arrives for S seconds (with --follow; default: 30).",
        ),
    ] = None
    no_polish: Annotated[
        bool,
        typer.Option("--no-polish", help="Skip the final joint adjustment (with --follow)."),
    ] = False


@dataclass(frozen=True, slots=True)
class OutputOptions:
    """Where results go, and how much of them is shown."""

    out: Out = None
    as_json: AsJson = False
    full: Full = False


@command
def recognize_command(
    source: Source,
    judging: JudgingOptions,
    output: OutputOptions,
    stated: _SourceOptions,
    following: FollowOptions,
) -> int:
    """Recognize what pictures, a scene, a mesh or a cloud show, and explain why.

    Exit code 0: a model matches, 1: none does.
    """
    if holds_shape(source):
        stated.check_no_picture_options(source)
        if following != FollowOptions():
            raise InputError(f"--follow is for pictures, and {source} holds none: leave it out")
        return _recognize_shape(source, judging, output, stated)
    if stated.sensor is not None or stated.override_file:
        raise InputError(f"--sensor and --override-file are for shapes: {source} holds none")
    if following.follow:
        from facetlog.commands.follow import follow_views

        if stated.front_end is not FrontEnd.LINES:
            raise InputError("--follow takes --front-end lines: the other needs all views at once")
        if stated.scale is not None:
            raise InputError("--scale goes without --follow: give it to scene convert afterwards")
        goal = None if following.until is None else Goal.parse(following.until)
        stop = Stop(goal, stated.make_method().sd_limit, following.max_views)
        return follow_views(
            source, judging, output, following, stop, unit=stated.unit, up=stated.up
        )
    if following != FollowOptions():
        raise InputError("--until, --max-views, --timeout and --no-polish go with --follow")
    read_views = stated.read_views(source, find_kept_cameras(output.out), trust=judging.trust)
    method = stated.make_method(stated.scale)

    def recognize(base: "KnowledgeBase", progress: Progress | None, clock: StepClock) -> Recognised:
        view_set = read_views(progress=progress, clock=clock)
        return recognize_views(
            view_set, base=base, method=method, progress=progress, clock=clock, near=True
        )

    return _recognize(recognize, judging, output, inputs=(source,))


def _recognize_shape(
    path: Path, judging: JudgingOptions, output: OutputOptions, stated: _SourceOptions
) -> int:
    from facetlog.perception.reading.read_views import ViewSet

    options = StatedOptions(stated.up, stated.unit, stated.sensor, stated.override_file)

    def recognize(base: "KnowledgeBase", _: Progress | None, clock: StepClock) -> Recognised:
        with clock.step("read"):
            scene = read_shape(path, options, stated.scale).scene
        return recognize_scene(scene, ViewSet(scene.name, ()), base=base, clock=clock, near=True)

    return _recognize(recognize, judging, output, inputs=(path,))


@command
def reconstruct_command(
    views: Views,
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="FILE", help="Scene file to write (JSON).")
    ],
    stated: _ViewOptions,
    trust: Trust = False,
    overwrite: Overwrite = False,
) -> int:
    """Reconstruct vertices, edges and faces from pictures, with their uncertainty."""
    check_output_file(out, "-o", (views,), own=OWN_SCENE, overwrite=overwrite)
    method = stated.make_method(stated.scale)
    read_views = stated.read_views(views, find_kept_cameras(out.with_suffix("")), trust=trust)
    clock = StepClock()
    with show_progress() as progress:
        view_set = read_views(progress=progress, clock=clock)
        scene = reconstruct_views(view_set, method=method, progress=progress, clock=clock)
        scene, known = apply_known_scale(scene, method)
    write_scene_file(scene, out)
    _describe(view_set, known)
    for line in (*view_set.problems, *scene.warnings):
        warn(line)
    show_times(clock)
    return YES


@command
def demo_command(
    judging: JudgingOptions,
    output: OutputOptions,
    how: _MethodOptions,
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", help="Seed of noise, floor and light.")
    ] = 0,
    world: Annotated[
        str, typer.Option("--world", metavar="NAME", help="Simulated world to look at.")
    ] = DEMO_WORLD,
    paper: Annotated[
        bool,
        typer.Option("--paper", help="Rerun the paper's experiment and write its page to OUT."),
    ] = False,
) -> int:
    """Render the paper's tour of 24 views around a block, and recognize it from the pixels."""
    if paper:
        others = judging.models or judging.crisp or output.as_json or output.full
        if others or world != DEMO_WORLD or how.sd_limit is not None:
            raise InputError("--paper reruns the paper's experiment: it goes with -o and --seed")
        if output.out is None:
            raise InputError("--paper writes a page: give a folder for it by -o")
        return _run_paper_experiment(output.out, seed)

    method = how.make_method()

    def recognize(base: "KnowledgeBase", progress: Progress | None, clock: StepClock) -> Recognised:
        view_set = render_simulated_views(world, seed, progress=progress, clock=clock)
        return recognize_views(
            view_set, base=base, method=method, progress=progress, clock=clock, near=True
        )

    return _recognize(recognize, judging, output)


def _run_paper_experiment(out: Path, seed: int) -> int:
    """Run the paper's experiment and write its page to the folder `out`; return the exit code."""
    from facetlog.degree_plot import check_plots
    from facetlog.kb.explaining.verdict_text import format_holding
    from facetlog.paper.experiment import run_experiment
    from facetlog.paper.page import PAGE_FILE, write_paper_page

    check_replaceable(out)
    check_plots()
    clock = StepClock()
    with show_progress() as progress:
        run = run_experiment(seed, progress, clock)
    with clock.step("write page"):
        write_paper_page(out, run, seed)
    show_times(clock)
    best = run.found.recognition.best
    typer.echo(format_holding(v.summary for v in best))
    typer.echo(f"{out / PAGE_FILE}: the paper's figures 8 to 14 from this run")
    return YES if best else NO


def _recognize(
    recognize: "Callable[[KnowledgeBase, Progress | None, StepClock], Recognised]",
    judging: JudgingOptions,
    output: OutputOptions,
    inputs: tuple[Path, ...] = (),
) -> int:
    """Print and write what is recognised; what cannot be written or judged is refused before any
    work.
    """
    from facetlog.report import format_verdicts_json, format_verdicts_text, write_report

    if output.out is not None:
        check_replaceable(output.out, inputs=(*inputs, *judging.paths))
    clock = StepClock()
    with judging.open_base() as base, show_progress() as progress:
        found = recognize(base, progress, clock)
        if output.out is not None:
            write_report(output.out, found, full=output.full, progress=progress)
    _describe(found.view_set, found.scale)
    for line in (*found.view_set.problems, *found.scene.warnings):
        warn(line)
    show_times(found.clock)
    typer.echo(
        (format_verdicts_json if output.as_json else format_verdicts_text)(found, full=output.full)
    )
    return YES if found.recognition.best else NO


def _describe(view_set: "ViewSet", scale: "Scale | None") -> None:
    if view_set.description:
        open_unit = scale is None and not view_set.metric
        note(view_set.description + (f": {WAY_TO_METRES}" if open_unit else ""))
    if scale is not None:
        note(f"by the known length {scale}")
