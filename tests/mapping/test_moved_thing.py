"""A thing that stands elsewhere than before is one thing; what only looks like it is another."""

import math
from dataclasses import replace

import numpy as np
import pytest

from facetlog.mapping.moved_thing import Looks, resolve_moved_things
from facetlog.mapping.placed_thing import PlacedThing
from facetlog.mapping.same_thing import merged
from facetlog.mapping.sonar_beams import Beam
from facetlog.perception.scene import SeenLattice
from tests.mapping.rooms import box_thing

FROM, TO = (1.0, 0.0), (3.0, 1.0)
BEFORE, SINCE = 15.0, 30.0
PITCH = 0.04


def seen_at(
    place: tuple[float, float],
    number: int,
    when: tuple[float, float],
    *,
    model: str = "box",
    size: tuple[float, float, float] = (0.4, 0.3, 0.2),
    pose_sd: float = 0.005,
) -> PlacedThing:
    thing = box_thing(*place, 0.3, size, model=model, pose_sd=pose_sd)
    return replace(thing, source=("one", f"t{number}"), when=when)


def beams(at: float, *, echo: bool, about: tuple[float, float] = FROM) -> tuple[Beam, ...]:
    """From all round: to the middle of the place, or far beyond it."""
    found = []
    for k in range(24):
        angle = k * math.tau / 24
        x, y = about[0] - 1.2 * math.cos(angle), about[1] - 1.2 * math.sin(angle)
        found.append(Beam(x, y, angle, 1.05 if echo else 3.0, echo, at))
    return tuple(found)


def ground(at: float, *, hole: float = 0.0) -> tuple[SeenLattice, tuple[float, ...]]:
    """The floor of the whole room, but for circles about where the feet of a table stand."""
    lattice = np.stack(np.meshgrid(np.arange(150), np.arange(100), indexing="ij"), axis=-1) * PITCH
    places = lattice - np.array([1.0, 2.0])
    shown = np.ones(places.shape[:2], np.bool_)
    for x in (-0.5, 0.5):
        for y in (-0.4, 0.4):
            away = np.linalg.norm(places - np.array([FROM[0] + x, FROM[1] + y]), axis=-1)
            shown &= away >= hole
    steps = np.array([[PITCH, 0.0, 0.0], [0.0, PITCH, 0.0]])
    corner = np.array([-1.0, -2.0, 0.0])
    return SeenLattice(corner, steps, np.zeros((1, 3)), shown[None], (0,)), (at,)


BOX, LATER = seen_at(FROM, 1, (10.0, 20.0)), seen_at(TO, 2, (40.0, 50.0))
HEARD = beams(BEFORE, echo=True)
PASSED = beams(SINCE, echo=False)


def mapped(*things: PlacedThing, looks: Looks) -> tuple[list[tuple[float, ...]], list[float]]:
    """Where the things of the map stand, and by how much some were moved."""
    left, moved = resolve_moved_things(merged(things)[0], looks)
    places = [tuple(np.round(t.best.pose[:2], 6).tolist()) for t in left]
    assert [thing.name for thing in left] == [f"m{k}" for k in range(1, len(left) + 1)]
    return sorted(places), [each.off for each in moved]


def test_a_box_where_sonars_pass_now_stands_where_it_was_seen_later() -> None:
    places, moved = mapped(BOX, LATER, looks=Looks(beams=HEARD + PASSED))
    assert places == [TO]
    assert moved == [pytest.approx(math.sqrt(5.0), abs=1e-6)]


@pytest.mark.parametrize(
    "looks",
    [
        Looks(),
        Looks(beams=HEARD),
        Looks(beams=HEARD + beams(SINCE, echo=True)),
        # A box that sonars never met is lower than they are: that they pass it says nothing.
        Looks(beams=PASSED),
        Looks(beams=HEARD + beams(SINCE, echo=False, about=(-3.0, -3.0))),
    ],
)
def test_what_may_still_stand_there_is_another_thing(looks: Looks) -> None:
    assert mapped(BOX, LATER, looks=looks) == ([FROM, TO], [])


@pytest.mark.parametrize(
    "other",
    [
        seen_at(TO, 2, (40.0, 50.0), model="chair"),
        seen_at(TO, 2, (40.0, 50.0), model=""),
        seen_at(TO, 2, (40.0, 50.0), size=(0.5, 0.3, 0.2)),
        seen_at(TO, 2, (0.0, 0.0)),
        # While the first was looked at the second stood where it stands.
        seen_at(TO, 2, (12.0, 50.0)),
    ],
)
def test_what_is_not_the_same_or_was_there_before_is_another_thing(other: PlacedThing) -> None:
    assert mapped(BOX, other, looks=Looks(beams=HEARD + PASSED)) == ([FROM, TO], [])


def test_a_table_stands_on_its_legs_though_the_floor_shows_between_them() -> None:
    legs = np.concatenate(
        [
            box_thing(FROM[0] + x, FROM[1] + y, 0.0, (0.06, 0.06, 0.7)).triangles
            for x in (-0.5, 0.5)
            for y in (-0.4, 0.4)
        ]
    )
    size = (1.06, 0.86, 0.72)
    before = replace(seen_at(FROM, 1, (10.0, 20.0), model="table", size=size), triangles=legs)
    later = seen_at((3.2, 1.6), 2, (40.0, 50.0), model="table", size=size)
    assert len(mapped(before, later, looks=Looks((ground(SINCE, hole=0.08),)))[0]) == 2
    assert len(mapped(before, later, looks=Looks((ground(SINCE),)))[0]) == 1
