"""What is said when an area is explored: why it ended, what was found, and what is left."""

from collections.abc import Sequence

from facetlog.counted import many
from facetlog.exploring.area_floor import Area, AreaFloor, KeptOff
from facetlog.exploring.area_groups import Group
from facetlog.mapping.same_thing import MappedThing
from facetlog.perception.fewest_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.next_stop import Around

__all__ = ["at", "end_of_area"]


def end_of_area(
    why: str,
    area: Area,
    floor: AreaFloor,
    groups: Sequence[Group],
    things: Sequence[MappedThing],
    around: Around,
    kept: Sequence[KeptOff],
) -> str:
    """One line: `why` it ended, empty where it did by itself, and what is left."""
    unseen = floor.area_of(floor.unseen(around.body, kept))
    parts = [why or "no unseen floor of the area can be reached, and no verdict can change"]
    parts.append(f"{many(len(things), 'thing')} found")
    parts.append(f"sonars did not reach {unseen:.1f} of {area[2] * area[3]:.1f} m² of floor")
    bare = [group for group in groups if group.thing is None]
    if nothing := [at(g.target) for g in bare if len(g.names) >= FEWEST_VIEWS]:
        parts.append(f"nothing is found at {' and '.join(nothing)}, where something echoes")
    if open_ := [group for group in groups if not group.settled and group.thing is not None]:
        parts.append(f"{many(len(open_), 'verdict')} still open")
    # Without a thing what echoes there is asked for no more (`AreaExplorer`), if it had its views.
    few = [at(group.target) for group in bare if len(group.names) < FEWEST_VIEWS]
    if left := [*few, *(at(echo.nearest) for echo in floor.echoes(around.body, kept))]:
        lack = "not looked at yet" if why else "of which no view can be reached"
        parts.append(f"echoes at {' and '.join(left)}, {lack}")
    return "; ".join(parts)


def at(place: FloatArray) -> str:
    """A place on the floor (2 or more,), in words."""
    return f"{float(place[0]):.2f}, {float(place[1]):.2f} m"
