"""`facetlog why` and `facetlog why-not`: reasons in one shot."""

from collections.abc import Callable
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.page_file import Html, write_page
from facetlog.commands.scene.shape import (
    AUTO,
    NONE,
    OverrideFile,
    Sensor,
    Unit,
    Up,
    as_given,
    options_given,
)
from facetlog.commands.shared import NO, YES, AsJson, Models, Raw, Trust, command
from facetlog.errors import InputError
from facetlog.output_file import Overwrite
from facetlog.page.page_path import check_page
from facetlog.terminal import note

if TYPE_CHECKING:
    from facetlog.query_shell.explaining import About, Explanation
    from facetlog.query_shell.session import Session

__all__ = ["why_command", "why_not_command"]

SceneArgument = Annotated[
    Path, typer.Argument(metavar="SCENE", help="A scene, mesh or cloud, or a folder written by -o.")
]
ModelArgument = Annotated[str, typer.Argument(metavar="MODEL", help="Name of a model.")]
SubjectArgument = Annotated[
    str,
    typer.Argument(
        metavar="MODEL|NAME",
        help="A model; or a face, edge, vertex or thing, or a fact as 'angle(f1, f2)'.",
    ),
]
Parts = Annotated[
    list[str] | None,
    typer.Argument(metavar="[PART=FACE]...", help="Parts that are given, as top=f1."),
]
Thing = Annotated[
    str | None, typer.Option("--thing", metavar="T", help="Only this thing of the scene.")
]

_STATED_BY = {
    "up": "--up z (or another axis) says which way is up",
    "scale": "--unit m (or cm, mm, in, ft) says of which unit lengths are",
}
"""How to state what conditions lack, by what the rules call it."""


@command
def why_command(
    scene: SceneArgument,
    model: SubjectArgument,
    parts: Parts = None,
    thing: Thing = None,
    models: Models = None,
    trust: Trust = False,
    raw: Raw = False,
    as_json: AsJson = False,
    full: Annotated[
        bool,
        typer.Option("--full", help="The whole proof, and where each face comes from, to pixels."),
    ] = False,
    html: Html = None,
    overwrite: Overwrite = False,
    up: Up = AUTO,
    unit: Unit = NONE,
    sensor: Sensor = NONE,
    override_file: OverrideFile = False,
) -> int:
    """Says why a model holds, or where a face, a piece or a fact comes from.

    Exit code 0: it does, 1: it does not; then what comes nearest.
    """
    from facetlog.query_shell.explaining import is_origin, origin, unknown_subject, why
    from facetlog.query_shell.scene_names import scene_names

    def explain(session: "Session", name: str, about: "About") -> "Explanation":
        if about.model in session.base.models:
            return why(session, name, about, full=full)
        names = {} if about.parts or about.thing else scene_names(session.base, (name,))
        if names and is_origin(names, about.model):
            return origin(session, name, about.model, full=full)
        raise unknown_subject(session.base.models, names, about.model)

    return _explained(
        *(explain, scene, model, parts, thing, models, html),
        stated=(up, unit, sensor, override_file),
        overwrite=overwrite,
        trust=trust,
        raw=raw,
        as_json=as_json,
    )


@command
def why_not_command(
    scene: SceneArgument,
    model: ModelArgument,
    parts: Parts = None,
    thing: Thing = None,
    models: Models = None,
    trust: Trust = False,
    as_json: AsJson = False,
    count: Annotated[
        int, typer.Option("--count", metavar="N", help="How many near misses at most.")
    ] = 5,
    full: Annotated[bool, typer.Option("--full", help="The whole proof of each.")] = False,
    html: Html = None,
    overwrite: Overwrite = False,
    up: Up = AUTO,
    unit: Unit = NONE,
    sensor: Sensor = NONE,
    override_file: OverrideFile = False,
) -> int:
    """Shows what nearly is one, and by how much it is not. Exit code 1: there is nothing to say."""
    from facetlog.query_shell.explaining import unknown_subject, why_not

    if count < 1:
        raise InputError(f"--count {count}: give a number above 0")

    def explain(session: "Session", name: str, about: "About") -> "Explanation":
        if about.model not in session.base.models:
            raise unknown_subject(session.base.models, {}, about.model)
        return why_not(session, name, about, count=count, full=full)

    return _explained(
        *(explain, scene, model, parts, thing, models, html),
        stated=(up, unit, sensor, override_file),
        overwrite=overwrite,
        trust=trust,
        as_json=as_json,
    )


def _explained(
    explain: "Callable[[Session, str, About], Explanation]",
    scene: Path,
    model: str,
    parts: list[str] | None,
    thing: str | None,
    models: list[Path] | None,
    html: Path | None,
    *,
    stated: tuple[str, str, str, bool],
    overwrite: bool,
    trust: bool,
    raw: bool = False,
    as_json: bool,
) -> int:
    from facetlog.query_shell.explaining import About, parts_given
    from facetlog.query_shell.session import Session

    about = About(model, thing, parts_given(parts or ()))
    if html is not None:
        check_page(html, "--html", (scene, *(models or ())), overwrite=overwrite)
    with Session(trust=trust, raw=raw, options=options_given(*stated)) as session:
        session.load_models(models or ())
        (file,) = session.load_scenes([scene])
        explanation = explain(session, file.name, about)
        if html is not None and explanation.verdicts:
            write_page(html, file, verdicts=explanation.verdicts)
        elif html is not None:
            note(f"no verdict is about this: {html} was not written")
    typer.echo(explanation.json if as_json else "\n".join(explanation.lines))
    if not as_json:
        lacking = {what for verdict in explanation.verdicts for what in verdict.lacking}
        for what in sorted(lacking & _STATED_BY.keys()):
            note(_STATED_BY[what])
    if explanation.hint and not as_json:
        note(f"facetlog why-not {as_given(*stated)}{quote(str(scene))} {explanation.hint}")
    if explanation.cut and not as_json:
        note("--full shows all of it")
    return YES if explanation.yes else NO
