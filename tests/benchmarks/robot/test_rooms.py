"""The rooms of accuracy_map: what stands in them, and that it is told apart from what is found."""

import math
from itertools import combinations

import numpy as np
import pytest
import shapely

from benchmarks.knowledge.calibration_scenes import get_world_truth
from benchmarks.robot.accuracy_map import compute_shared_plan, measure_pose_error
from benchmarks.robot.rooms import APART, FEWEST, MOST, make_room
from facetlog.mapping.same_thing import merged
from tests.mapping.rooms import box_thing


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.slow
def test_a_room_has_four_to_eight_things_between_which_a_robot_passes(seed: int) -> None:
    room = make_room(seed)
    assert FEWEST <= len(room.things) <= MOST
    for one, other in combinations(room.things, 2):
        assert shapely.distance(one.plan, other.plan) >= APART
    x, y, width, height = room.area
    inside = shapely.box(x, y, x + width, y + height)
    assert all(inside.contains(thing.plan) for thing in room.things)
    assert all(get_world_truth(thing.kind, "pyramid") is not None for thing in room.things)
    again = make_room(seed)
    assert [t.box.values.tolist() for t in again.things] == [
        t.box.values.tolist() for t in room.things
    ]


@pytest.mark.slow
def test_a_pose_is_compared_with_the_true_one_as_often_as_it_looks_the_same() -> None:
    true = make_room(0).things[0]
    x, y, heading, length, width = true.box.values.tolist()
    for turn in (0.0, math.pi):
        (found,), _ = merged([box_thing(x, y, heading + turn, (length, width, true.height))])
        distance, (off, turned) = measure_pose_error(true, found)
        assert distance == pytest.approx(0.0, abs=1e-3)
        assert (off, turned) == (pytest.approx(0.0, abs=1e-6), pytest.approx(0.0, abs=1e-6))
        assert compute_shared_plan(found, true) == pytest.approx(1.0, abs=0.1)
    (aside,), _ = merged([box_thing(x + 3.0, y, heading)])
    assert compute_shared_plan(aside, true) == 0.0
    assert np.isfinite(measure_pose_error(true, aside)[0])
