"""The choice of the next view: a pure function of what is open and of what can be taken."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.exploring.choice import Promises, beginning, choose
from facetlog.exploring.open_questions import Lack, Needs, Open, SeenThing
from facetlog.exploring.sides import Sides
from facetlog.perception.space.grid import Lattice
from facetlog.perception.space.space import Space, State, UnseenSpace
from facetlog.perception.types import Camera, FloatArray
from facetlog.robot.collecting.next_stop import Around
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.ring_views import PLACES, Candidate, bearing
from facetlog.robot.collecting.route import Circle, measure_distance_to
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.head.sony_models import EVI_D30
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera

CAMERA: Camera = tour_camera()
HEIGHT = DEFAULT_MOUNT.z


def _turned(angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _around(angle: float = 0.0, shift: tuple[float, float] = (0.0, 0.0)) -> Around:
    """A target with its keep-out circle, and a robot 1.5 m before it, in a turned frame."""
    x, y, z = _turned(angle) @ [0.5, 0.2, 0.08] + [*shift, 0.0]
    reach = Reach(DEFAULT_MOUNT, EVI_D30.limits, CAMERA, (Circle(x, y, 0.78),))
    here_x, here_y, _ = _turned(angle) @ [-1.0, 0.2, 0.0] + [*shift, 0.0]
    here = Pose2(here_x, here_y, angle)
    first = bearing(np.array([x, y, z]), (here_x, here_y))
    return Around(np.array([x, y, z]), 0.85, first, reach, Pace(), here)


def _thing(target: FloatArray, angle: float = 0.0) -> SeenThing:
    """A cube of 0.3 m: one wall is full, what lies behind it is unseen."""
    cells = np.full((6, 6, 6), State.UNSEEN, np.uint8)
    cells[0] = State.FULL
    axes = _turned(angle).T
    corner = axes @ target - 0.15
    space = Space(Lattice(0.05, axes, corner, (6, 6, 6)), cells, closed=False)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.15
    facing = np.repeat(np.sign(corners)[:, :1] * [1.0, 0.0, 0.0], 1, axis=0)[:, None]
    return SeenThing(
        "t1",
        target,
        target + corners @ axes,
        np.tile(1e-4 * np.eye(3), (8, 1, 1)),
        facing @ axes,
        np.zeros((0, 3)),
        UnseenSpace.of(space),
    )


def _needs(around: Around, angle: float = 0.0, measured: float = 0.1) -> Needs:
    both = frozenset({Lack.SIDES, Lack.SPACE})
    opened = Open("t1", "table", 0.8, measured, lack=both)
    return Needs((opened,), (_thing(around.target, angle),))


def test_every_candidate_keeps_out_of_the_circle_and_looks_at_the_target() -> None:
    around = _around()
    found = around.candidates(1)
    assert len(found) >= PLACES
    for each in found:
        assert measure_distance_to(around.reach.closed, (each.stop.robot.x, each.stop.robot.y)) >= 0
        ahead = each.pose.rotation[:, 2]
        to_target = around.target - each.pose.centre
        assert ahead @ to_target / np.linalg.norm(to_target) > math.cos(math.radians(25.0))
        assert each.seconds >= each.way / around.pace.speed


def test_the_first_views_are_neighbours_on_a_ring() -> None:
    around = _around()
    places: list[FloatArray] = []
    for _ in range(3):
        chosen = beginning(around.candidates(1), around.target, places)
        assert chosen is not None
        places.append(chosen.pose.centre)
        around = replace(around, here=chosen.stop.robot)
    angles = sorted(math.degrees(bearing(around.target, place)) % 360 for place in places)
    gaps = np.diff([*angles, angles[0] + 360])
    assert sorted(gaps)[:2] == pytest.approx([22.5, 22.5], abs=1e-6)


@settings(max_examples=5)
@given(angle=st.floats(-3.1, 3.1), x=st.floats(-5, 5), y=st.floats(-5, 5))
@pytest.mark.slow
def test_turning_and_moving_the_world_changes_nothing(angle: float, x: float, y: float) -> None:
    def number(around: Around, turn: float) -> tuple[int, float]:
        candidates = around.candidates(1)
        place = candidates[0].pose.centre
        chosen = choose(candidates, _needs(around, turn), CAMERA, [place])
        assert chosen is not None
        return candidates.index(chosen.candidate), chosen.promise.mass

    at, mass = number(_around(), 0.0)
    turned_at, turned_mass = number(_around(angle, (x, y)), angle)
    assert turned_at == at
    assert turned_mass == pytest.approx(mass, abs=1e-6)


def test_a_view_that_shows_nothing_new_is_never_chosen_before_one_that_does() -> None:
    around = _around()
    candidates = around.candidates(1)
    old, *others = candidates
    # As fast as can be, and yet it shows what was seen from there before.
    free = replace(old, way=0.0, turns=0.0, seconds=1e-3)
    for other in others[:6]:
        chosen = choose([free, other], _needs(around), CAMERA, [old.pose.centre])
        assert chosen is not None
        assert chosen.candidate is other
    assert choose([free], _needs(around), CAMERA, [old.pose.centre]) is None


@pytest.mark.parametrize(("axis", "sense"), [(0, 1), (0, -1), (1, 1), (2, 1), (2, -1)])
def test_from_far_away_as_much_shows_as_along_the_axis(axis: int, sense: int) -> None:
    unseen = _thing(np.zeros(3)).space
    assert unseen is not None
    place = np.zeros(3)
    place[axis] = 1e4 * sense
    share = float(unseen.shown_from(place).mean())
    assert share == pytest.approx(unseen.space.measure_visible_unseen(axis, sense), abs=1e-6)


def test_a_poorly_known_pose_promises_less_about_corners() -> None:
    around = _around()
    candidate: Candidate = around.candidates(1)[0]
    needs = _needs(around)
    promises = Promises(needs, CAMERA, [])
    sure = promises.of(candidate.pose, np.zeros((6, 6))).corners
    unsure = promises.of(candidate.pose, 1e-2 * np.eye(6)).corners
    assert 0.0 < unsure < sure < 1.0


def test_a_face_towards_the_floor_is_lacked_by_nobody() -> None:
    ring = [each.pose.centre for each in _around().candidates(1)[:PLACES]]
    down = np.array([[0.0, 0.0, -1.0], [0.1, 0.0, -0.99]])
    assert Sides(_around().target, down, np.array(ring)).lack == 0.0
    aslant = np.array([[0.8, 0.0, -0.6]])
    assert Sides(_around().target, aslant, np.array(ring[:2])).lack > 0.0
