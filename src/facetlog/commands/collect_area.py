"""`facetlog collect --explore --area`: which area is explored, who chooses, and its map."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.robot_options import numbers_in
from facetlog.errors import InputError
from facetlog.terminal import note, showing_progress, warn

if TYPE_CHECKING:
    from facetlog.exploring.area import AreaExplorer
    from facetlog.mapping.room_map import RoomMap
    from facetlog.robot.collecting.drawing.map_picture import Found
    from facetlog.robot.collecting.tour_file import Tour
    from facetlog.robot.pose2 import Pose2
    from facetlog.view_verdicts import ViewVerdicts

__all__ = [
    "MAP_FOLDER",
    "AreaOption",
    "area_explorer",
    "area_tour",
    "checked_area",
    "mapped_area",
    "recognised_in",
    "refuse_area",
]

MAP_FOLDER = "map"
"""The folder of an area's map in that of its views: map.png beside the views is the robot's way."""

AreaOption = Annotated[
    str | None,
    typer.Option(
        "--area", metavar="X,Y,W,H", help="Explore all that stands there: lowest corner, size (m)."
    ),
]

Area = tuple[float, float, float, float]


def checked_area(
    area: str | None, start: "Pose2 | None", others: Mapping[str, object]
) -> Area | None:
    """The area that is explored, None without one; `others` are options that do not go with it.

    InputError for another form, and where a robot at `start` does not stand in it.
    """
    if area is None:
        return None
    for name in (name for name, value in others.items() if value):
        raise InputError(f"{name} does not go with --area: an area is explored as a whole")
    x, y, width, height = numbers_in(area, "--area", "X,Y,WIDTH,HEIGHT (metres)", 4)
    if width <= 0 or height <= 0:
        raise InputError(f"--area {area!r:.40}: its width and height are above 0")
    if start is not None and not (x <= start.x <= x + width and y <= start.y <= y + height):
        raise InputError(
            f"--area {area!r:.40} does not hold the robot, which stands at {start.x:.2f}, "
            f"{start.y:.2f}: give an area round it, or where it stands by --start"
        )
    return x, y, width, height


def refuse_area(folder: Path) -> None:
    """InputError where a folder's views are of an area, which are no views of one target."""
    from facetlog.mapping.visit import recorded_area
    from facetlog.robot.collecting.record import LOG_FILE, read_log

    lines = read_log(folder) if (folder / LOG_FILE).is_file() else ()
    if area := recorded_area(lines):
        raise InputError(f"{folder} holds an explored area: give --area={_as_option(area)} again")


def _as_option(area: Area) -> str:
    """An area as --area takes it."""
    return ",".join(f"{each:g}" for each in area)


def area_tour(area: Area) -> "Tour":
    """A tour without views and without a target."""
    from facetlog.robot.collecting.tour_file import Tour

    return Tour(f"explore area {_as_option(area)}", (), None)


def area_explorer(
    verdicts: "ViewVerdicts", area: Area, most: int, folder: Path, *, resume: bool
) -> "AreaExplorer":
    """Who chooses, with the verdicts of the process that judges; to `resume` it takes up what the
    folder holds.
    """
    from facetlog.exploring.area import AreaExplorer
    from facetlog.mapping.visit import read_visit, recorded_area
    from facetlog.robot.collecting.record import read_log

    explorer = AreaExplorer(verdicts.explored_place, area, most=most)
    if resume:
        lines = read_log(folder)
        known = recorded_area(lines)
        if known != area:
            way = f"give --area={_as_option(known)}" if known else "leave out --area"
            raise InputError(f"{folder} was not collected in this --area: {way}")
        explorer.resume(lines, read_visit(folder))
    return explorer


def recognised_in(room: "RoomMap") -> "list[Found]":
    """The things of a map that have a name, as the map of the robot's way shows them."""
    import numpy as np
    import shapely

    from facetlog.robot.collecting.drawing.map_picture import Found

    found = []
    for thing in (thing for thing in room.things if thing.model):
        rim = shapely.get_coordinates(thing.best.plan)
        found.append(Found(thing.label, (np.insert(rim, 2, 0.0, axis=1),)))
    return found


def mapped_area(folder: Path, area: Area, models: tuple[Path, ...], *, trusted: bool) -> "RoomMap":
    """Maps an area from what a folder holds, and writes the map beside its views."""
    from facetlog.mapping.map_files import write_map
    from facetlog.mapping.room_map import map_of
    from facetlog.output_folder import output_folder
    from facetlog.pipeline import open_models

    with open_models(models, trusted=trusted) as base, showing_progress() as progress:
        room = map_of([folder], base, area=area, progress=progress)
    for line in room.notes:
        warn(line)
    made = folder / MAP_FOLDER
    with output_folder(made, {"command": "collect", "visits": [str(folder)]}) as part:
        write_map(room, part)
    note(f"the map is in {made}")
    return room
