"""The map as JSON, `facetlog-map/1`, and its JSON Schema; metres, radians, x and y on the floor."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt

from facetlog.mapping.floor_grid import Cell, FloorGrid
from facetlog.mapping.placed_thing import Length, PlacedThing, Said
from facetlog.mapping.same_thing import MappedThing

if TYPE_CHECKING:
    from facetlog.mapping.moved_thing import Moved
    from facetlog.mapping.room_map import RoomMap

SIGNS = {Cell.UNSEEN: " ", Cell.PASSED: ":", Cell.FREE: ".", Cell.OCCUPIED: "#"}
"""How cells of the floor are written."""

NotNegative = Annotated[float, Field(ge=0.0)]
Row3 = tuple[float, float, float]
Point = tuple[float, float]


class _Record(BaseModel):
    # It holds for the dataclasses within, too; they are checked as they are written.
    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, revalidate_instances="always"
    )


class PoseRecord(_Record):
    """The middle of the least rectangle round the plan, and the heading of its longer side.

    `covariance` is of x, y and heading (radians). After a turn by `turns_alike` (radians) the
    rectangle looks the same.
    """

    x: float
    y: float
    heading: float
    covariance: tuple[Row3, Row3, Row3]
    turns_alike: float


class SizeRecord(_Record):
    """Sides of the least rectangle round the plan, and the height over the floor."""

    length: Length
    width: Length
    height: Length


class SightingRecord(_Record):
    """A thing of a scene that is this one, or a part of it: where it was seen, and as what.

    `thing` is its name in that scene; `standard_deviations` its Mahalanobis distance from the pose.
    """

    visit: str
    thing: str
    models: tuple[str, ...]
    standard_deviations: NotNegative


class EarlierRecord(_Record):
    """Place of a thing before it was moved, and the visit that saw it there. `off` is how far
    from there it stood next, metres.
    """

    visit: str
    pose: PoseRecord
    off: NotNegative


class ThingRecord(_Record):
    """A thing: where, how large, what; `outline` is the convex hull of its plan.

    Of one that was moved the pose is that of where it was seen last, and `moved_from` has its
    places before in their order; its sightings are of all of them.
    """

    name: str
    model: str | None
    verdicts: tuple[Said, ...]
    pose: PoseRecord
    size: SizeRecord
    outline: tuple[Point, ...]
    sightings: tuple[SightingRecord, ...]
    moved_from: tuple[EarlierRecord, ...]


class FloorRecord(_Record):
    """The floor in square cells of `resolution`; `origin` is the corner of the first one of `rows`.

    A row is along x, the next one is higher in y. A space is a cell that nobody saw, `.` is free,
    `#` occupied, and `:` one that only sonars looked at and found nothing in at their height.
    `areas` are in square metres.
    """

    resolution: float
    origin: Point
    rows: tuple[str, ...]
    areas: dict[str, NotNegative]


class MapRecord(_Record):
    """The map of a room from one or several visits."""

    model_config = ConfigDict(title="facetlog-map/1")

    format: Literal["facetlog-map/1"] = Field(alias="schema")
    visits: tuple[str, ...]
    views: NonNegativeInt
    things: tuple[ThingRecord, ...]
    floor: FloorRecord
    notes: tuple[str, ...]


def format_map_json(room: "RoomMap") -> str:
    """Return the map as one JSON object."""
    record = MapRecord(
        schema="facetlog-map/1",
        visits=room.visits,
        views=len(room.taken),
        things=tuple(_thing(thing, room.moved) for thing in room.things),
        floor=_floor(room.floor),
        notes=room.notes,
    )
    return record.model_dump_json(by_alias=True, indent=1) + "\n"


def _thing(thing: MappedThing, moved: "Iterable[Moved]") -> ThingRecord:
    from facetlog.mapping.same_thing import distance

    best = thing.best
    length, width, height = best.lengths
    return ThingRecord(
        name=thing.name,
        model=thing.model or None,
        verdicts=best.said,
        pose=_pose(best),
        size=SizeRecord(length=length, width=width, height=height),
        outline=tuple(map(tuple, best.outline.tolist())),
        sightings=tuple(_sighting(seen, distance(best, seen)) for seen in thing.seen),
        moved_from=tuple(map(_earlier, (m for m in moved if m.now.name == thing.name))),
    )


def _earlier(moved: "Moved") -> EarlierRecord:
    before = moved.before.best
    return EarlierRecord(visit=before.source[0], pose=_pose(before), off=moved.off)


def _pose(placed: PlacedThing) -> PoseRecord:
    x, y, heading = placed.pose.tolist()
    return PoseRecord(
        x=x,
        y=y,
        heading=math.remainder(heading, math.tau),
        covariance=placed.cov.tolist(),
        turns_alike=placed.box.turns_alike,
    )


def _sighting(seen: PlacedThing, off: float) -> SightingRecord:
    visit, name = seen.source
    return SightingRecord(
        visit=visit,
        thing=name,
        models=tuple(said.model for said in seen.said),
        standard_deviations=off,
    )


def _floor(floor: FloorGrid) -> FloorRecord:
    signs = [SIGNS[state] for state in Cell]
    return FloorRecord(
        resolution=floor.side,
        origin=floor.low,
        rows=tuple("".join(signs[cell] for cell in row) for row in floor.cells.tolist()),
        areas={state.name.lower(): floor.area(state) for state in Cell},
    )
