"""`facetlog model draw`: what a model describes, as a picture and a mesh."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.drawn import (
    EFFORT,
    Effort,
    ModelName,
    conflict_lines,
    model_errors,
    workbench,
)
from facetlog.commands.shared import NO, YES, AsJson, Models, Trust, command

if TYPE_CHECKING:
    from facetlog.prototype.search import Search

__all__ = ["draw_command"]

PICTURE_PX = 960
SCHEMA = "facetlog-prototype/1"


@command
def draw_command(
    name: ModelName,
    models: Models = None,
    trust: Trust = False,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="DIR", help="The folder; drawn/NAME if not given."),
    ] = None,
    effort: Effort = EFFORT,
    as_json: AsJson = False,
) -> int:
    """Draws a solid that a model describes, with its measures in the middle of their limits.

    The folder gets NAME.png, NAME.glb and NAME.json. Exit code 0: it holds, 1: no solid was found
    that does, and which conditions cannot be met together is said, or the model has errors.
    """
    from facetlog.output_folder import check_replaceable, output_folder
    from facetlog.prototype.search import searched
    from facetlog.terminal import printable

    models = models or []
    if faults := model_errors(name, models):
        typer.echo(faults)
        return NO
    folder = out or Path("drawn") / Path(name).stem
    check_replaceable(folder, inputs=models)
    with workbench(name, models, trust=trust) as bench:
        search = searched(bench, effort)
        if not search.best.judged.holds:
            lines = list(conflict_lines(search))
            if as_json:
                typer.echo(json.dumps(_json(search) | {"conflict": lines}))
            else:
                typer.echo("\n".join(map(printable, lines)))
            return NO
        with output_folder(folder, {"command": "model draw", "model": bench.model}) as made:
            _write(search, made)
        if as_json:
            typer.echo(json.dumps(_json(search)))
        else:
            best = search.best
            written = f"{folder / bench.model}.png, .glb, .json"
            typer.echo(printable(f"{written}: the best of {bench.judged} that were judged"))
            typer.echo(printable(best.form.described(best.judged.sizes)))
            typer.echo("\n".join(map(printable, best.judged.verdict.lines())))
    return YES


def _write(search: "Search", folder: Path) -> None:
    from facetlog.perception.surfaces.mesh_export import write_mesh
    from facetlog.perception.surfaces.scene_file import write_scene
    from facetlog.prototype.picture import picture

    scene, name = search.best.judged.scene, search.bench.model
    (folder / f"{name}.png").write_bytes(picture(search.best.judged, PICTURE_PX))
    write_mesh(scene, folder / f"{name}.glb")
    write_scene(scene, folder / f"{name}.json")


def _json(search: "Search") -> dict[str, object]:
    best = search.best
    return {
        "schema": SCHEMA,
        "model": search.bench.model,
        "form": best.form.name,
        "sizes": dict(best.judged.sizes),
        "judged": search.bench.judged,
        "verdict": best.judged.verdict.to_json(),
    }
