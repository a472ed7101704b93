"""The command line: results on stdout, everything else on stderr.

Exit codes: 0 yes or done, 1 a clean no, 2 bad input or usage, 3 engine failure, 130 Ctrl-C.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog import __version__
from facetlog.__main__ import INTERRUPTED
from facetlog.commands.classify import classify_command
from facetlog.commands.collect import collect_command
from facetlog.commands.doctor import doctor_command
from facetlog.commands.explain import why_command, why_not_command
from facetlog.commands.map import map_command
from facetlog.commands.mat.app import mat_app
from facetlog.commands.model.app import model_app
from facetlog.commands.mount import mount_command
from facetlog.commands.paper import paper_page
from facetlog.commands.query import query_command
from facetlog.commands.record import record_command
from facetlog.commands.scene.app import scene_app
from facetlog.commands.shared import NO, YES, AsJson, Full, Models, Raw, Trust, command
from facetlog.commands.simulate import simulate_command
from facetlog.errors import InputError
from facetlog.output_file import OWN_SCENE, Overwrite, check_output_file
from facetlog.output_folder import check_replaceable, kept_cameras
from facetlog.perception.length_units import stated_length
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import (
    DEMO_WORLD,
    FrontEnd,
    Method,
    Progress,
    Recognised,
    in_known_scale,
    open_models,
    recognize_views,
    reconstruct_views,
    simulated_views,
    views_from,
    write_scene_file,
)
from facetlog.stream import Goal, Stop
from facetlog.terminal import error, note, set_loudness, show_times, showing_progress, warn

if TYPE_CHECKING:
    from facetlog.perception.facts.known_length import Scale
    from facetlog.perception.reading.read_views import ViewSet

__all__ = ["app", "main"]

app = typer.Typer(
    name="facetlog",
    help="Recognises things made of flat faces in pictures with known cameras.",
    no_args_is_help=True,
    add_completion=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

# How long a followed folder may stay as it is, s: a robot drives to its next place in less.
FOLLOW_TIMEOUT_S = 30.0

Views = Annotated[
    Path,
    typer.Argument(
        metavar="VIEWS",
        help="Folder of pictures, with transforms.json, a COLMAP model, … or alone; or a file.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("-o", "--out", metavar="OUT", help="Folder for scene, facts, meshes, pictures."),
]
Unit = Annotated[
    str | None,
    typer.Option("--unit", metavar="U", help="Unit of the poses: m, cm, mm, in or ft."),
]
Up = Annotated[
    str | None,
    typer.Option(
        "--up", metavar="AXIS", help="Up in the poses' world: x y z -x -y -z, auto or none."
    ),
]
KnownLengthOf = Annotated[
    str | None,
    typer.Option(
        "--scale",
        metavar="LENGTH",
        help='A known length, where no unit is: "height = 74 cm", "v3 v7 = 25 ± 0.1 cm".',
    ),
]
Square = Annotated[
    str | None,
    typer.Option(
        "--square",
        metavar="LENGTH",
        help='Side of a square of the mat as printed, if its bar was off: "17.6 ± 0.02 mm".',
    ),
]
Crisp = Annotated[
    bool, typer.Option("--crisp", help="Take every measured value as exact, as the paper does.")
]
KeepPoses = Annotated[
    bool,
    typer.Option("--keep-poses", help="Do not correct poses of which the file states the errors."),
]
WithFrontEnd = Annotated[
    FrontEnd,
    Method,
    typer.Option("--front-end", help="lines: any scene; paper: one bright block on dark ground."),
]
SdLimit = Annotated[
    float | None,
    typer.Option(
        "--sd-limit",
        metavar="LENGTH",
        help="A vertex needs no more views once its standard deviation is below this (m or units).",
    ),
]


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"facetlog {__version__}")
        raise typer.Exit


@app.callback()
def _shared(
    version: Annotated[  # noqa: ARG001 - its callback ends the program
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
    quiet: Annotated[
        bool, typer.Option("-q", "--quiet", help="No notes, progress and times.")
    ] = False,
    verbose: Annotated[
        int,
        typer.Option(
            "-v", "--verbose", count=True, help="Each step with its time; twice: more of it."
        ),
    ] = 0,
) -> None:
    """What all commands share."""
    try:
        set_loudness(quiet=quiet, verbose=verbose)
    except InputError as exc:
        error(str(exc))
        raise typer.Exit(exc.exit_code) from exc


@app.command("recognize")
@command
def recognize_command(
    views: Views,
    models: Models = None,
    trust: Trust = False,
    crisp: Crisp = False,
    raw: Raw = False,
    as_json: AsJson = False,
    full: Full = False,
    out: Out = None,
    unit: Unit = None,
    up: Up = None,
    square: Square = None,
    scale: KnownLengthOf = None,
    front_end: WithFrontEnd = FrontEnd.LINES,
    sd_limit: SdLimit = None,
    keep_poses: KeepPoses = False,
    follow: Annotated[
        bool, typer.Option("--follow", help="Take views as they come; a verdict after each.")
    ] = False,
    until: Annotated[
        str | None,
        typer.Option("--until", metavar="GOAL", help='End at it, as "table >= 90%"; --follow.'),
    ] = None,
    max_views: Annotated[
        int | None, typer.Option("--max-views", metavar="N", min=1, help="End there; --follow.")
    ] = None,
    timeout: Annotated[
        float | None,
        typer.Option("--timeout", metavar="S", min=0.0, help="End without a new view; --follow."),
    ] = None,
    no_polish: Annotated[
        bool, typer.Option("--no-polish", help="Leave out the joint adjustment; --follow.")
    ] = False,
) -> int:
    """Says what is there, and why. Exit code 0: a model matches, 1: none does."""
    if follow:
        from facetlog.commands.follow import followed

        if front_end is not FrontEnd.LINES:
            raise InputError("--follow takes --front-end lines: the other needs all views at once")
        if scale is not None:
            raise InputError("--scale goes without --follow: give it to scene convert afterwards")
        goal = None if until is None else Goal.parse(until)
        return followed(
            views,
            unit=unit,
            up=up,
            timeout=FOLLOW_TIMEOUT_S if timeout is None else timeout,
            models=tuple(models or ()),
            trusted=trust,
            crisp=crisp,
            raw=raw,
            stop=Stop(goal, _method(front_end, sd_limit).sd_limit, max_views),
            polish=not no_polish,
            out=out,
            as_json=as_json,
            full=full,
        )
    if until is not None or max_views is not None or timeout is not None or no_polish:
        raise InputError("--until, --max-views, --timeout and --no-polish go with --follow")
    return _recognized(
        partial(
            views_from,
            views,
            unit=unit,
            up=up,
            square=None if square is None else stated_length(square, "--square"),
            keep=kept_cameras(out),
            trusted=trust,
            keep_poses=keep_poses,
        ),
        inputs=(views,),
        models=models,
        trusted=trust,
        crisp=crisp,
        raw=raw,
        method=_method(front_end, sd_limit, scale),
        out=out,
        as_json=as_json,
        full=full,
    )


@app.command("reconstruct")
@command
def reconstruct_command(
    views: Views,
    out: Annotated[Path, typer.Option("-o", "--out", metavar="FILE", help="The scene as JSON.")],
    trust: Trust = False,
    unit: Unit = None,
    up: Up = None,
    square: Square = None,
    scale: KnownLengthOf = None,
    front_end: WithFrontEnd = FrontEnd.LINES,
    sd_limit: SdLimit = None,
    keep_poses: KeepPoses = False,
    overwrite: Overwrite = False,
) -> int:
    """Writes the vertices, edges and faces that the views show, with their uncertainty."""
    check_output_file(out, "-o", (views,), own=OWN_SCENE, overwrite=overwrite)
    method = _method(front_end, sd_limit, scale)
    clock = StepClock()
    with showing_progress() as progress:
        view_set = views_from(
            views,
            unit=unit,
            up=up,
            square=None if square is None else stated_length(square, "--square"),
            keep=kept_cameras(out.with_suffix("")),
            trusted=trust,
            keep_poses=keep_poses,
            progress=progress,
            clock=clock,
        )
        scene = reconstruct_views(view_set, method=method, progress=progress, clock=clock)
        scene, known = in_known_scale(scene, method)
    write_scene_file(scene, out)
    _describe(view_set, known)
    for line in (*view_set.problems, *scene.warnings):
        warn(line)
    show_times(clock)
    return YES


@app.command("demo")
@command
def demo_command(
    out: Out = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Noise, floor and light.")] = 0,
    world: Annotated[
        str, typer.Option("--world", metavar="NAME", help="What the simulated camera looks at.")
    ] = DEMO_WORLD,
    models: Models = None,
    trust: Trust = False,
    crisp: Crisp = False,
    raw: Raw = False,
    as_json: AsJson = False,
    full: Full = False,
    front_end: WithFrontEnd = FrontEnd.LINES,
    sd_limit: SdLimit = None,
    paper: Annotated[
        bool, typer.Option("--paper", help="The paper's figures from this run, as a page in OUT.")
    ] = False,
) -> int:
    """Renders the paper's tour of 24 views round a block, and recognises it from the pixels."""
    if paper:
        if world != DEMO_WORLD or models or crisp or as_json or full or sd_limit is not None:
            raise InputError("--paper reruns the paper's experiment: it goes with -o and --seed")
        if out is None:
            raise InputError("--paper writes a page: give a folder for it by -o")
        return paper_page(out, seed)
    return _recognized(
        partial(simulated_views, world, seed),
        models=models,
        trusted=trust,
        crisp=crisp,
        raw=raw,
        method=_method(front_end, sd_limit),
        out=out,
        as_json=as_json,
        full=full,
    )


app.command("classify")(classify_command)
app.command("collect")(collect_command)
app.command("record")(record_command)
app.command("map")(map_command)
app.command("mount")(mount_command)
app.command("query")(query_command)
app.command("doctor")(doctor_command)
app.command("why")(why_command)
app.command("why-not")(why_not_command)
app.command("simulate")(simulate_command)
app.add_typer(mat_app)
app.add_typer(model_app)
app.add_typer(scene_app)


def _recognized(
    source: Callable[..., "ViewSet"],
    *,
    inputs: tuple[Path, ...] = (),
    models: list[Path] | None,
    trusted: bool,
    crisp: bool,
    raw: bool,
    method: Method,
    out: Path | None,
    as_json: bool,
    full: bool,
) -> int:
    """What is there in the views of a source; all that could be refused is asked before them."""
    if out is not None:
        check_replaceable(out, inputs=(*inputs, *(models or ())))
    clock = StepClock()
    with (
        open_models(tuple(models or ()), trusted=trusted, crisp=crisp, raw=raw) as base,
        showing_progress() as progress,
    ):
        view_set = source(progress=progress, clock=clock)
        found = recognize_views(view_set, base=base, method=method, progress=progress, clock=clock)
        _write(out, found, progress, full=full)
    return _answer(found, as_json=as_json, full=full)


def _method(front_end: FrontEnd, sd_limit: float | None, scale: str | None = None) -> Method:
    if sd_limit is not None and not sd_limit > 0:
        raise InputError(f"--sd-limit {sd_limit:g}: give a length above 0")
    if scale is None:
        return Method(front_end, sd_limit)
    from facetlog.perception.facts.known_length import KnownLength

    return Method(front_end, sd_limit, KnownLength.parse(scale))


def _write(out: Path | None, found: Recognised, progress: Progress | None, *, full: bool) -> None:
    from facetlog.report import write_report

    if out is not None:
        write_report(out, found, full=full, progress=progress)


WAY_TO_METRES = "give --unit, or a length that you know, as --scale 'height = 74 cm'"


def _describe(view_set: "ViewSet", scale: "Scale | None") -> None:
    if view_set.description:
        open_unit = scale is None and not view_set.metric
        note(view_set.description + (f": {WAY_TO_METRES}" if open_unit else ""))
    if scale is not None:
        note(f"by the known length {scale}")


def _answer(found: Recognised, *, as_json: bool, full: bool) -> int:
    from facetlog.report import verdicts_json, verdicts_text

    _describe(found.view_set, found.scale)
    for line in (*found.view_set.problems, *found.scene.warnings):
        warn(line)
    show_times(found.clock)
    typer.echo((verdicts_json if as_json else verdicts_text)(found, full=full))
    return YES if found.recognition.best else NO


def main(argv: Sequence[str]) -> int:
    """The exit code of the command line `argv` (without the program's name)."""
    try:
        app(args=list(argv), prog_name="facetlog")
    except SystemExit as exc:
        return exc.code if isinstance(exc.code, int) else int(exc.code is not None)
    except KeyboardInterrupt:
        return INTERRUPTED
    return YES
