"""`facetlog scene convert`: any shape as a scene, a mesh of its faces, or facts."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.scene.shape import (
    AUTO,
    NONE,
    OverrideFile,
    Scale,
    Sensor,
    ShapeArgument,
    Unit,
    Up,
    read,
)
from facetlog.commands.shared import YES, command
from facetlog.output_file import Overwrite, check_output_file
from facetlog.terminal import warn

if TYPE_CHECKING:
    from facetlog.perception.scene import Scene

__all__ = ["convert_command"]

SCENE, FACTS, PIECES = ".json", ".pl", ".glb"


@command
def convert_command(
    shape: ShapeArgument,
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="A scene (.json), a mesh of its faces (.ply, .glb, .gltf), or facts (.pl); with "
            "--pieces a mesh of its pieces (.glb).",
            show_default=False,
        ),
    ],
    up: Up = AUTO,
    unit: Unit = NONE,
    sensor: Sensor = NONE,
    override_file: OverrideFile = False,
    scale: Scale = None,
    pieces: Annotated[
        bool,
        typer.Option(
            "--pieces", help="A mesh of pieces, coloured by kind, in a haze of unseen space."
        ),
    ] = False,
    overwrite: Overwrite = False,
) -> int:
    """Writes a scene, mesh or cloud in another form; the suffix says which."""
    writers = {PIECES: _write_pieces} if pieces else _WRITERS
    check_output_file(out, "OUT", (shape,), suffixes=tuple(writers), overwrite=overwrite)
    scene = read(shape, up, unit, sensor, scale, override=override_file).scene
    for line in scene.warnings:
        warn(line)
    writers[out.suffix.lower()](scene, out)
    return YES


def _write_scene(scene: "Scene", path: Path) -> None:
    from facetlog.perception.facts.most_faces import MOST_FACES
    from facetlog.perception.surfaces.scene_file import SceneFileError, write_scene
    from facetlog.perception.surfaces.scene_json.scene_checks import scene_faults

    if faults := tuple(scene_faults(scene)):  # it could not be read again
        raise SceneFileError(f"{path} is not written: the scene", faults)
    write_scene(scene, path)
    if len(scene.faces) > MOST_FACES:
        warn(
            f"{path}: has {len(scene.faces):,} faces: it can be shown, but of at most "
            f"{MOST_FACES:,} facts are made, so it is not judged: leave out what does not matter"
        )


def _write_mesh(scene: "Scene", path: Path) -> None:
    from facetlog.perception.surfaces.mesh_export import write_mesh

    write_mesh(scene, path)
    if scene.patches:
        warn(f"{path}: holds the flat faces alone; surface that is not flat has no triangles")


def _write_pieces(scene: "Scene", path: Path) -> None:
    from facetlog.perception.atomic_write import write_whole
    from facetlog.perception.facts.pieces.piece_facts import shown_pieces
    from facetlog.perception.pieces.piece_meshes import pieces_bytes

    write_whole(path, pieces_bytes(scene, shown_pieces(scene)))


def _write_facts(scene: "Scene", path: Path) -> None:
    from facetlog.kb.loading.encode import facts_program
    from facetlog.perception.atomic_write import write_whole
    from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts

    # A file can be asked for nothing later.
    made = (*scene_facts(scene), *facts_on_demand(scene))
    facts = (fact.row for fact in made)
    write_whole(path, ("\n".join(facts_program(facts)) + "\n").encode())


_WRITERS: Mapping[str, Callable[["Scene", Path], None]] = MappingProxyType(
    {
        SCENE: _write_scene,
        **dict.fromkeys((".ply", ".glb", ".gltf"), _write_mesh),
        FACTS: _write_facts,
    }
)
