"""The floor of an area: what echoes, where ways lead, and what is taken for a thing's."""

import math

import numpy as np
import pytest
import shapely

from facetlog.exploring.area_floor import CLEARANCE, AreaFloor, KeptOff
from facetlog.mapping.place import OVERHANG
from facetlog.mapping.sonar_beams import Beam
from facetlog.robot.collecting.route import Circle
from facetlog.robot.pose2 import Pose2

AREA = (0.0, 0.0, 6.0, 4.0)
RADIUS = 0.25
POLE = np.array([3.0, 2.0])


def _beams(x: float, y: float) -> list[Beam]:
    """All round from a place, towards a thin pole."""
    found = []
    for heading in np.arange(0.0, math.tau, math.radians(10.0)).tolist():
        to_pole = POLE - [x, y]
        off = math.remainder(math.atan2(to_pole[1], to_pole[0]) - heading, math.tau)
        far = float(np.hypot(*to_pole))
        hit = abs(off) <= math.radians(15.0)
        found.append(Beam(x, y, heading, far if hit else 5.0, hit))
    return found


@pytest.fixture
def floor() -> AreaFloor:
    found = AreaFloor(AREA)
    found.begin((1.0, 2.0))
    for x, y in ((1.0, 2.0), (1.2, 1.0), (2.0, 0.7), (3.0, 0.5), (2.0, 3.2), (4.6, 2.3)):
        found.add(_beams(x, y))
    return found


def test_a_pole_is_one_place_where_it_stands(floor: AreaFloor) -> None:
    (found,) = floor.echoes(RADIUS, ())
    assert found.middle == pytest.approx(POLE, abs=0.15)
    assert found.reach < 0.4


def test_ways_keep_as_far_off_an_echo_as_something_may_overhang_it(floor: AreaFloor) -> None:
    ways = floor.ways((1.0, 2.0), RADIUS, (), ())
    off = floor.lattice.away((3.0, 2.0))
    assert off[ways.open].min() >= RADIUS + OVERHANG - 0.2
    route = ways.route_to((5.0, 2.0))
    assert route is not None
    line = shapely.LineString(route)
    assert line.distance(shapely.Point(*POLE)) > RADIUS + OVERHANG - 0.2


def test_a_thing_that_is_known_takes_its_echoes_and_is_kept_off_by_its_plan(
    floor: AreaFloor,
) -> None:
    plan = shapely.box(2.8, 1.8, 3.2, 2.2)
    assert floor.echoes(RADIUS, (KeptOff(plan, 0.0),)) == ()
    near = floor.ways((1.0, 2.0), RADIUS, (KeptOff(plan, 0.0),), ())
    wide = floor.ways((1.0, 2.0), RADIUS, (KeptOff(plan, 0.3),), ())
    points = shapely.points(floor.lattice.middles)
    away = shapely.distance(plan, points)
    assert away[near.open].min() >= RADIUS + CLEARANCE
    assert away[wide.open].min() >= RADIUS + CLEARANCE + 0.3
    assert near.open.sum() > wide.open.sum()


def test_what_pictures_were_asked_of_is_no_place_any_more_and_still_in_the_way(
    floor: AreaFloor,
) -> None:
    before = floor.ways((1.0, 2.0), RADIUS, (), ()).open
    floor.asked |= floor.lattice.away((3.0, 2.0)) <= 0.5
    assert floor.echoes(RADIUS, ()) == ()
    assert (floor.ways((1.0, 2.0), RADIUS, (), ()).open == before).all()


def test_ways_keep_out_of_circles(floor: AreaFloor) -> None:
    circle = Circle(1.8, 1.0, 0.4)
    ways = floor.ways((1.0, 2.0), RADIUS, (), (circle,))
    assert floor.lattice.away((1.8, 1.0))[ways.open].min() >= 0.4


def test_where_the_robot_was_nothing_is_though_an_arc_says_so(floor: AreaFloor) -> None:
    assert floor.echoed(RADIUS).any()
    for x in np.arange(2.0, 4.0, 0.1).tolist():
        floor.moved(Pose2(x, 2.0))
    assert not floor.echoed(0.5).any()


def test_before_anything_was_heard_the_robot_has_room_to_turn_and_the_rest_is_unseen() -> None:
    floor = AreaFloor(AREA)
    floor.begin((1.0, 2.0))
    ways = floor.ways((1.0, 2.0), RADIUS, (), ())
    assert ways.length_to((1.0, 2.0)) == 0.0
    assert ways.route_to((2.0, 2.0)) is None
    assert floor.area_of(floor.unseen(RADIUS, ())) == pytest.approx(24.0 - math.pi / 4, abs=0.1)


def test_of_what_has_no_name_there_may_be_more_than_was_found(floor: AreaFloor) -> None:
    """A table of which one leg was found: what echoes is kept off as far as its top may reach."""
    leg = shapely.Point(*POLE).buffer(0.05)
    named = floor.ways((1.0, 2.0), RADIUS, (KeptOff(leg, 0.0),), ())
    unnamed = floor.ways((1.0, 2.0), RADIUS, (KeptOff(leg, 0.0, known=False),), ())
    off = floor.lattice.away(POLE)
    assert off[named.open].min() < RADIUS + 0.3
    assert off[unnamed.open].min() >= RADIUS + OVERHANG - 0.2
    assert floor.echoes(RADIUS, (KeptOff(leg, 0.0, known=False),)) == ()


def test_where_a_thing_stands_no_floor_is_missing() -> None:
    floor = AreaFloor(AREA)
    thing = KeptOff(shapely.box(1.0, 1.0, 2.0, 2.0), 0.0)
    assert floor.area_of(floor.unseen(RADIUS, (thing,))) < floor.area_of(floor.unseen(RADIUS, ()))


def test_what_was_heard_long_ago_gives_way_to_what_is_heard_now(floor: AreaFloor) -> None:
    for x in np.arange(0.0, 40.0, 0.5).tolist():
        floor.moved(Pose2(x % 6.0, 3.9))
    for _ in range(4):
        floor.add([Beam(1.0, 2.0, 0.0, 5.0, False)])
    assert floor.echoes(0.1, ()) == ()


def test_what_echoed_from_afar_alone_is_worth_a_look_though_no_floor_is_missing() -> None:
    floor = AreaFloor(AREA)
    floor.begin((0.5, 2.0))
    before = floor.worth(RADIUS, ())
    floor.add(_beams(0.5, 2.0))
    assert floor.echoes(RADIUS, ()) == ()
    gained = floor.worth(RADIUS, ()) - before
    assert gained.max() > 10.0
    assert np.linalg.norm(floor.lattice.middles[gained > 1.0] - POLE, axis=1).max() < 0.8
    floor.given_up |= gained > 1.0
    assert floor.worth(RADIUS, ()).max() <= 1.0


def test_by_the_way_it_came_a_robot_goes_back_though_something_may_overhang_it_by_now() -> None:
    """What is heard on both sides 0.7 m away, after it passed, closed the way behind it."""
    floor = AreaFloor(AREA)
    floor.begin((1.0, 2.0))
    for _ in range(4):
        floor.add([Beam(1.0, 2.0, h, 4.0, False) for h in np.arange(0.0, math.tau, 0.2).tolist()])
    for x in np.arange(1.0, 4.0, 0.06).tolist():
        floor.moved(Pose2(x, 2.0))
    sides = (math.pi / 2, -math.pi / 2)
    for x in np.arange(1.8, 3.2, 0.1).tolist():
        floor.add([Beam(x, 2.0, side, 0.7, True) for side in sides] * 8)
    between = floor.lattice.cell((2.5, 2.0))
    back = floor.ways((3.95, 2.0), RADIUS, (), ())
    assert back.open[between]
    assert back.route_to((1.0, 2.0)) is not None
    # What it passed ten metres ago may be a cell off by now.
    for y in np.arange(2.0, 2.2, 0.01).tolist() * 60:
        floor.moved(Pose2(4.0, y))
    assert not floor.ways((4.0, 2.0), RADIUS, (), ()).open[between]


def test_what_echoes_where_the_robot_was_long_ago_has_come_there_since() -> None:
    floor = AreaFloor(AREA)
    floor.begin((1.0, 1.0))
    where = floor.lattice.cell((3.05, 1.05))
    towards = [Beam(1.5, 1.05, 0.0, 1.55, True)] * 8
    for x in np.arange(1.0, 4.0, 0.06).tolist():
        floor.moved(Pose2(x, 1.0))
    floor.add(towards)
    assert not floor.echoed(RADIUS)[where]
    for x in np.arange(0.0, 13.0, 0.06).tolist():
        floor.moved(Pose2(4.0 - x % 0.5, 3.0))
    floor.add(towards)
    assert floor.echoed(RADIUS)[where]
    assert floor.passed(RADIUS)[where]  # Until something is heard there, nothing is.
