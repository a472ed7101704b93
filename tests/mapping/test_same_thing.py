"""Each thing once: over scenes and visits, and whatever part of it was seen."""

import numpy as np
import pytest

from facetlog.mapping.same_thing import distance, fused, merged
from tests.mapping.rooms import box_thing


def test_two_visits_of_one_box_are_one_thing_and_two_boxes_are_two() -> None:
    here = box_thing(1.0, 0.0, 0.3, visit="monday", pose_sd=0.02)
    again = box_thing(1.02, -0.01, 0.302, visit="tuesday", pose_sd=0.03)
    other = box_thing(2.0, 0.0, 0.3, visit="tuesday", pose_sd=0.03)
    things, clashes = merged([here, again, other])
    assert [(thing.name, len(thing.seen)) for thing in things] == [("m1", 2), ("m2", 1)]
    assert not clashes
    assert np.linalg.norm(things[0].best.pose[:2] - [1.0, 0.0]) < 0.02


def test_the_order_of_visits_does_not_matter() -> None:
    seen = [box_thing(1.0, 0.0, visit=v, pose_sd=0.02) for v in ("a", "b")]
    seen.append(box_thing(3.0, 0.0, visit="b"))
    one, two = merged(seen)[0], merged(seen[::-1])[0]
    assert [t.best.pose.tolist() for t in one] == [t.best.pose.tolist() for t in two]


def test_a_square_box_may_be_turned_by_a_quarter_and_a_long_one_by_a_half() -> None:
    square = (0.4, 0.4, 0.2)
    one, two = box_thing(0, 0, 0.7, square), box_thing(0, 0, 0.7 - np.pi / 2, square)
    assert distance(one, two) < 0.1
    assert distance(box_thing(0, 0, 1.5), box_thing(0, 0, 1.5 - np.pi)) < 0.1
    assert distance(box_thing(0, 0, 0.0), box_thing(0, 0, 0.5)) > 10


def test_what_stands_in_another_thing_is_a_part_of_it() -> None:
    """A drawer block of a desk, a leg of a table, a top without its legs."""
    desk = box_thing(0.0, 0.0, 0.0, (1.4, 0.7, 0.75), model="desk")
    block = box_thing(0.45, 0.0, 0.0, (0.4, 0.6, 0.7))
    leg = box_thing(-0.65, 0.3, 0.0, (0.05, 0.05, 0.7), model="")
    things, _ = merged([block, leg, desk])
    assert [(thing.model, len(thing.seen)) for thing in things] == [("desk", 3)]
    assert things[0].best.pose == pytest.approx(desk.pose)


def test_a_thing_that_visits_place_differently_is_where_the_surer_one_has_it() -> None:
    vague = box_thing(1.0, 0.0, 0.3, visit="monday", pose_sd=0.03)
    sure = box_thing(1.2, 0.0, 0.3, visit="tuesday", pose_sd=0.001)
    for things in ([vague, sure], [sure, vague]):
        (thing,), clashes = merged(things)
        assert len(clashes) == 1
        assert thing.best.pose[0] == pytest.approx(1.2, abs=1e-6)
        assert thing.best.outline.mean(axis=0) == pytest.approx(thing.best.pose[:2], abs=1e-9)


def test_the_fused_pose_is_consistent_whatever_errors_both_share() -> None:
    """Fully shared errors: the fused estimate is as far off as either, and says so."""
    rng = np.random.default_rng(4)
    nees = []
    for _ in range(60):
        off = rng.normal(0.0, 0.02, 2)
        one = box_thing(off[0], off[1], visit="a", pose_sd=0.02)
        two = box_thing(off[0], off[1], visit="b", pose_sd=0.02)
        both = fused(one, two)
        nees.append(float(both.pose[:2] @ np.linalg.solve(both.cov[:2, :2], both.pose[:2])))
    assert np.mean(nees) < 3.0


def test_the_name_of_a_fragment_is_not_that_of_the_thing() -> None:
    """A model may fit an end panel of which one visit saw nothing more, as a door."""
    whole = box_thing(0.0, 0.0, 0.0, (1.4, 0.7, 0.75), visit="monday", model="")
    panel = box_thing(0.6, 0.0, 0.0, (0.02, 0.7, 0.7), visit="tuesday", model="door")
    (thing,), _ = merged([panel, whole])
    assert thing.model == ""
    assert thing.best.lengths[0].value == pytest.approx(1.4)


def test_within_a_visit_what_the_robot_was_off_by_before_is_off_for_both() -> None:
    """Two boxes half a metre apart, at the end of a way on which odometry drifted by a metre."""
    one, other = (box_thing(x, 0.0, pose_sd=1.0) for x in (0.0, 0.5))
    assert distance(one, other) > 10
    assert len(merged([one, other])[0]) == 2
    # Of another visit it may well be the same one.
    again = box_thing(0.5, 0.0, visit="two", pose_sd=1.0)
    assert len(merged([one, again])[0]) == 1
