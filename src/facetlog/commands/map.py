"""`facetlog map`: map a room from one or several collections."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.shared import NO, YES, AsJson, ModelOptions, command
from facetlog.errors import InputError
from facetlog.output_folder import check_replaceable
from facetlog.terminal import show_progress, warn

if TYPE_CHECKING:
    from facetlog.mapping.room_map import RoomMap
    from facetlog.mapping.same_thing import MappedThing

__all__ = ["map_command"]

# The side of a cell, metres, as in floor_grid.py, which is loaded with the command.
DEFAULT_SIDE = 0.05


@command
def map_command(
    folders: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR…", help="Folders that facetlog collect has written, one per visit."
        ),
    ],
    models: ModelOptions,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="OUT", help="Folder for the map files.")
    ] = None,
    resolution: Annotated[
        float, typer.Option("--resolution", metavar="M", help="Side length of a floor cell (m).")
    ] = DEFAULT_SIDE,
    aligned: Annotated[
        bool,
        typer.Option("--aligned", help="The robot began each visit at the same pose."),
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Map a room: objects with pose and verdict, and the floor.

    With -o: map.png, map.json, map.glb, and for ROS map.pgm with map.yaml. Exit code 1: no object
    was found.
    """
    from facetlog.mapping.map_files import write_map
    from facetlog.mapping.map_record import format_map_json
    from facetlog.mapping.room_map import build_room_map
    from facetlog.output_folder import output_folder

    if not (math.isfinite(resolution) and resolution > 0.0):
        raise InputError(f"--resolution {resolution}: give the side of a cell in metres, above 0")
    if out is not None:
        check_replaceable(out, inputs=(*folders, *models.paths))
    with models.open_base() as base, show_progress() as progress:
        room = build_room_map(folders, base, side=resolution, aligned=aligned, progress=progress)
    for note in room.notes:
        warn(note)
    if out is not None:
        about: dict[str, object] = {"command": "map", "visits": list(map(str, folders))}
        with output_folder(out, about) as made:
            write_map(room, made)
    if as_json:
        typer.echo(format_map_json(room), nl=False)
    else:
        for line in _format_map(room):
            typer.echo(line)
    return YES if room.things else NO


def _format_map(room: "RoomMap") -> list[str]:
    """Describe in words what is on the map."""
    from facetlog.mapping.floor_grid import Cell
    from facetlog.plurals import many

    floor = room.floor
    passed = floor.area(Cell.PASSED)
    by_sonar = f"passed by sonars alone {passed:.1f} m², " if passed else ""
    count = many(len(room.things), "thing")
    views = many(len(room.taken), "view")
    head = (
        f"{count} from {views} of {many(len(room.visits), 'visit')}; floor free "
        f"{floor.area(Cell.FREE):.1f} m², occupied {floor.area(Cell.OCCUPIED):.1f} m², "
        f"{by_sonar}not seen {floor.area(Cell.UNSEEN):.1f} m²"
    )
    return [head, *map(_format_thing, room.things)]


def _format_thing(thing: "MappedThing") -> str:
    from facetlog.kb.explaining.verdict_text import NO_MODEL

    best = thing.best
    x, y, heading = best.pose.tolist()
    sds = [math.sqrt(max(float(v), 0.0)) for v in best.cov.diagonal()]
    length, width, height = best.lengths
    what = NO_MODEL
    if best.said:
        first = best.said[0]
        what = f"{first.model} ({first.sure:.0%})"
    return (
        f"{thing.name} {what}: at {x:.3f} ± {sds[0]:.3f}, {y:.3f} ± {sds[1]:.3f} m, "
        f"heading {math.degrees(heading):.1f}° ± {math.degrees(sds[2]):.1f}°, "
        f"{length.value:.3f} × {width.value:.3f} × {height.value:.3f} m"
    )
