"""The map of a room from the scenes of one or several visits."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import FacetlogError, InputError
from facetlog.mapping.floor_grid import RESOLUTION, FloorGrid, Seen, floor_grid
from facetlog.mapping.moved_thing import Looks, Moved, resolve_moved_things
from facetlog.mapping.placed_thing import PlacedThing, place_things
from facetlog.mapping.same_thing import Clash, MappedThing, merged
from facetlog.mapping.visit import Look, Visit, check_aligned, read_grouped_views, read_visit
from facetlog.perception.scene import SeenLattice
from facetlog.perception.step_clock import StepClock
from facetlog.robot.collecting.record import LOG_FILE, Taken
from facetlog.robot.pose2 import Pose2

if TYPE_CHECKING:
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.pipeline import Progress


@dataclass(frozen=True, eq=False, slots=True)
class _ScenePart:
    """Contribution of one scene to a map: its things in the world, the ground that it shows, and
    when the views of each lattice were taken, where that is known (seconds since 1970).
    """

    things: tuple[PlacedThing, ...]
    lattices: tuple[SeenLattice, ...]
    times: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class RoomMap:
    """Things and floor of a room in the world of the visits; metres, radians, z up.

    `moved` are those of the things that stood elsewhere before, with the names that they have now.
    `notes` say what was left out, and what visits say otherwise.
    """

    visits: tuple[str, ...]
    things: tuple[MappedThing, ...]
    floor: FloorGrid
    ways: tuple[tuple[Pose2, ...], ...]
    taken: tuple[Taken, ...]
    notes: tuple[str, ...] = ()
    moved: tuple[Moved, ...] = ()


def build_room_map(
    folders: Sequence[Path],
    base: "KnowledgeBase",
    *,
    side: float = RESOLUTION,
    aligned: bool = False,
    progress: "Progress | None" = None,
) -> RoomMap:
    """Return the map of what collections' folders hold; `side` is that of a cell of the floor,
    metres.

    With `aligned` their worlds count as one though nobody said so. InputError for a folder that is
    no collection's, or where worlds are not known to be one.
    """
    visits = [_visit(folder) for folder in dict.fromkeys(folders)]
    if not aligned:
        check_aligned(visits)
    parts: list[_ScenePart] = []
    notes: list[str] = []
    names = _names(visits)
    for visit, name in zip(visits, names, strict=True):
        sets = read_grouped_views(visit)
        if not sets:
            notes.append(f"{visit.folder} has too few views to find a face in")
        for number, look in enumerate(sets, start=1):
            if progress is not None:
                progress(f"scenes of {name}", number, len(sets))
            try:
                part = _scene_part(look, name, base)
            except FacetlogError as exc:
                notes.append(f"{visit.folder}: {exc}")
                continue
            parts.append(part)
    return _join_parts(visits, names, parts, side=side, notes=notes)


def _join_parts(
    visits: Sequence[Visit],
    names: Sequence[str],
    parts: Sequence[_ScenePart],
    *,
    side: float,
    notes: Iterable[str],
) -> RoomMap:
    """Join the scenes of visits to a map."""
    there, clashes = merged(thing for part in parts for thing in part.things)
    beams = tuple(beam for visit in visits for beam in visit.driven.beams)
    timed = (zip(part.lattices, part.times, strict=True) for part in parts if part.times)
    things, moved = resolve_moved_things(there, Looks(tuple(chain.from_iterable(timed)), beams))
    way = tuple(place for visit in visits for place in visit.way)
    seen = Seen(
        tuple(lattice for part in parts for lattice in part.lattices),
        way,
        max((visit.driven.radius for visit in visits), default=0.0),
        tuple(thing.best.plan for thing in things),
        beams,
    )
    return RoomMap(
        tuple(names),
        things,
        floor_grid(seen, side),
        tuple(visit.way for visit in visits),
        tuple(view for visit in visits for view in visit.taken),
        (*notes, *map(_format_clash_line, clashes), *map(_format_moved_line, moved)),
        moved,
    )


def _scene_part(look: Look, visit: str, base: "KnowledgeBase") -> _ScenePart:
    """Recognise what the views of one place show. Raise FacetlogError if they make no scene."""
    from facetlog.pipeline import recognize_views

    found = recognize_views(look.views, base=base, clock=StepClock())
    errors, ground = look.errors, found.scene.seen_ground
    things = place_things(
        found.scene,
        found.recognition,
        visit,
        () if errors is None else errors.poses,
        None if errors is None else errors.covariances,
    )
    if not look.times:
        return _ScenePart(things, ground)
    at = [look.times[name] for name in found.scene.views]
    when = min(at), max(at)
    return _ScenePart(
        tuple(replace(thing, when=when) for thing in things),
        ground,
        tuple(tuple(at[view] for view in lattice.views) for lattice in ground),
    )


def _visit(folder: Path) -> Visit:
    if not (folder / LOG_FILE).is_file():
        raise InputError(f"{folder} holds no collection: give what `facetlog collect` has left")
    return read_visit(folder)


def _names(visits: Sequence[Visit]) -> list[str]:
    """Return the folders' names; of equal ones the whole paths."""
    names = [visit.name for visit in visits]
    return [
        str(visit.folder) if names.count(name) > 1 else name
        for visit, name in zip(visits, names, strict=True)
    ]


def _format_moved_line(moved: Moved) -> str:
    before, now = moved.before.best, moved.now.best
    one, other = before.source[0], now.source[0]
    seen, later = (f" ({one})", f" ({other})") if one != other else ("", "")
    return (
        f"{moved.now.name} {moved.now.model} was moved by {moved.off:.2f} m: seen at {_at(before)}"
        f"{seen}, where the floor is free since, and later at {_at(now)}{later}"
    )


def _at(thing: PlacedThing) -> str:
    # Without the sign of what is less than 0 by a rounding.
    x, y = (round(float(each), 2) + 0.0 for each in thing.pose[:2])
    return f"{x:.2f}, {y:.2f} m"


def _format_clash_line(clash: Clash) -> str:
    one, other = clash.one, clash.other
    what = one.said[0].model if one.said else "thing"
    return (
        f"{other.source[0]} has the {what} at {_at(one)} "
        f"{clash.off:.2f} m and {math.degrees(clash.turned):.0f}° elsewhere than "
        f"{one.source[0]}, {clash.distance:.1f} standard deviations: it was moved, or the worlds "
        "of the two are not one (--start)"
    )
