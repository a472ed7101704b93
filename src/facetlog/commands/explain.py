"""`facetlog why` and `facetlog why-not`: the reasons for one verdict."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.page_options import PageOptions
from facetlog.commands.shape_options import StatedOptions
from facetlog.commands.shared import NO, YES, AsJson, ModelOptions, Raw, command
from facetlog.errors import InputError
from facetlog.terminal import note

if TYPE_CHECKING:
    from facetlog.query_shell.explaining import About, Explanation
    from facetlog.query_shell.session import Session

__all__ = ["why_command", "why_not_command"]

Scene = Annotated[
    Path, typer.Argument(metavar="SCENE", help="A scene, mesh or cloud, or a folder written by -o.")
]
Parts = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[PART=FACE]...",
        help="Faces or pieces that are given for parts, as top=f1; of a set, whether it has them.",
    ),
]

_WAYS_TO_STATE = {
    "up": "--up z (or another axis) says which way is up",
    "scale": "--unit m (or cm, mm, in, ft) says of which unit lengths are",
}
"""Options that state what conditions lack, by the names that rules use."""


@dataclass(frozen=True, slots=True)
class _Question:
    """The options of both commands."""

    thing: Annotated[
        str | None, typer.Option("--thing", metavar="T", help="Only this thing of the scene.")
    ] = None
    as_json: AsJson = False


@command
def why_command(
    scene: Scene,
    model: Annotated[
        str,
        typer.Argument(
            metavar="MODEL|NAME",
            help="A model; or a face, edge, vertex or thing, or a fact as 'angle(f1, f2)'.",
        ),
    ],
    question: _Question,
    models: ModelOptions,
    page: PageOptions,
    stated: StatedOptions,
    parts: Parts = None,
    raw: Raw = False,
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="Show the whole proof, and where each face comes from, down to pixels."
        ),
    ] = False,
) -> int:
    """Explain why a model holds or does not, or where a face, piece or fact comes from.

    Exit code 0: the model holds, or what is given for a set belongs to it, 1: it does not.
    """
    from facetlog.query_shell.explaining import is_origin, make_unknown_subject_error, origin, why
    from facetlog.query_shell.scene_names import scene_names

    def explain(session: "Session", name: str, about: "About") -> "Explanation":
        if about.model in session.base.models:
            return why(session, name, about, full=full)
        names = {} if about.parts or about.thing else scene_names(session.base, (name,))
        if names and is_origin(names, about.model):
            return origin(session, name, about.model, full=full)
        raise make_unknown_subject_error(session.base.models, names, about.model)

    return _explain((scene, model, parts or []), question, models, page, stated, explain, raw=raw)


@command
def why_not_command(
    scene: Scene,
    model: Annotated[str, typer.Argument(metavar="MODEL", help="Name of a model.")],
    question: _Question,
    models: ModelOptions,
    page: PageOptions,
    stated: StatedOptions,
    parts: Parts = None,
    count: Annotated[
        int, typer.Option("--count", metavar="N", help="Largest number of near misses.")
    ] = 5,
    full: Annotated[bool, typer.Option("--full", help="Show the whole proof of each.")] = False,
) -> int:
    """Show what comes nearest to a model without being one, and by how much it misses.

    Exit code 1: nothing comes near.
    """
    from facetlog.query_shell.explaining import make_unknown_subject_error, why_not

    if count < 1:
        raise InputError(f"--count {count}: give a number above 0")

    def explain(session: "Session", name: str, about: "About") -> "Explanation":
        if about.model not in session.base.models:
            raise make_unknown_subject_error(session.base.models, {}, about.model)
        return why_not(session, name, about, count=count, full=full)

    return _explain((scene, model, parts or []), question, models, page, stated, explain)


def _explain(
    asked: tuple[Path, str, list[str]],
    question: _Question,
    models: ModelOptions,
    page: PageOptions,
    stated: StatedOptions,
    explain: "Callable[[Session, str, About], Explanation]",
    *,
    raw: bool = False,
) -> int:
    from facetlog.query_shell.explaining import About, parse_parts
    from facetlog.query_shell.session import Session

    scene, model, parts = asked
    about = About(model, question.thing, parse_parts(parts))
    page.check((scene, *models.paths))
    with Session(trust=models.trust, raw=raw, options=stated.find_given()) as session:
        session.load_models(models.paths)
        (file,) = session.load_scenes([scene])
        explanation = explain(session, file.name, about)
        if explanation.verdicts:
            page.write(file, verdicts=explanation.verdicts)
        elif page.html is not None:
            note(f"no verdict is about this: {page.html} was not written")
    typer.echo(explanation.json if question.as_json else "\n".join(explanation.lines))
    if not question.as_json:
        lacking = {what for verdict in explanation.verdicts for what in verdict.lacking}
        for what in sorted(lacking & _WAYS_TO_STATE.keys()):
            note(_WAYS_TO_STATE[what])
        if explanation.hint:
            options = models.to_words() + stated.to_words()
            note(f"facetlog why-not {options}{quote(str(scene))} {explanation.hint}")
        if explanation.cut:
            note("--full shows all of it")
    return YES if explanation.yes else NO
