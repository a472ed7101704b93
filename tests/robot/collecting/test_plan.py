"""Stops for a tour: reachable, looking at the same, with little turning."""

import math
from dataclasses import replace

import numpy as np
import pytest

from facetlog.robot.collecting.plan import Reach, plan_stops, shows
from facetlog.robot.collecting.route import Circle, measure_distance_to
from facetlog.robot.collecting.tour_file import Tour, TourView, make_paper_tour
from facetlog.robot.mount.kinematics import camera_pose
from facetlog.robot.mount.mount import DEFAULT_MOUNT, Mount
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import make_pose_looking_at, tour_camera
from tests.robot.collecting.fakes import SONY

TOUR, CAMERA = make_paper_tour(), tour_camera()
TARGET = TOUR.target
assert TARGET is not None
CLOSED = (Circle(float(TARGET[0]), float(TARGET[1]), 0.8),)
REACH = Reach(DEFAULT_MOUNT, SONY, CAMERA, CLOSED)


def test_the_papers_views_are_taken_from_their_places() -> None:
    plan = plan_stops(TOUR, Pose2(), REACH)
    assert [stop.number for stop in plan.stops] == list(range(1, 25))
    assert plan.skipped == ()
    for stop in plan.stops:
        pose = camera_pose(stop.robot, DEFAULT_MOUNT, stop.gaze)
        np.testing.assert_allclose(pose.centre[:2], stop.view.pose.centre[:2], atol=1e-9)
        if abs(stop.view.pose.centre[2] - DEFAULT_MOUNT.z) < 1e-9:
            np.testing.assert_allclose(pose.rotation, stop.view.pose.rotation, atol=1e-6)
        assert SONY.pan_min <= stop.gaze.pan <= SONY.pan_max
        assert SONY.tilt_min <= stop.gaze.tilt <= SONY.tilt_max
        assert measure_distance_to(CLOSED, (stop.robot.x, stop.robot.y)) >= 0


def test_a_tilt_beyond_the_heads_is_reported_and_the_nearest_taken() -> None:
    mount = Mount(z=0.85)
    plan = plan_stops(TOUR, Pose2(), replace(REACH, mount=mount))
    assert plan.stops
    tilted = [r for r in plan.remarks if "more tilt than the head has" in r]
    assert len(tilted) == 1
    assert min(stop.gaze.tilt for stop in plan.stops) == pytest.approx(SONY.tilt_min)
    for stop in plan.stops:
        assert shows(CAMERA, camera_pose(stop.robot, mount, stop.gaze), TARGET)


def test_a_view_that_would_lose_the_object_is_left_out() -> None:
    point = np.array([2.0, 0.0, 0.0])
    low = TourView("low.png", make_pose_looking_at((0.5, 0.3, 0.5), point))
    steep = TourView("steep.png", make_pose_looking_at((1.8, 0.0, 2.5), point))
    reach = Reach(Mount(z=2.5), SONY, CAMERA)
    plan = plan_stops(Tour("t", (low, steep)), Pose2(), reach)
    assert [each.name for each in plan.skipped] == ["low.png", "steep.png"]
    assert "the head cannot tilt to" in plan.skipped[1].reason


def test_a_view_within_a_circle_is_left_out() -> None:
    reach = replace(REACH, closed=(CLOSED[0].grown(0.1),))
    plan = plan_stops(TOUR, Pose2(), reach)
    assert 0 < len(plan.skipped) < 24
    assert all("keep-out" in each.reason for each in plan.skipped)
    assert len(plan.stops) + len(plan.skipped) == 24


def test_a_view_behind_circles_that_leave_no_way_is_left_out_of_the_plan() -> None:
    """The third stop is free itself, but fenced in; the robot would not get to it."""
    fenced = TOUR.views[2].pose.centre
    fence = tuple(
        Circle(float(fenced[0] + math.cos(a)), float(fenced[1] + math.sin(a)), 0.6)
        for a in np.linspace(0, math.tau, 6, endpoint=False)
    )
    reach = replace(REACH, closed=fence)
    assert measure_distance_to(fence, (float(fenced[0]), float(fenced[1]))) > 0
    plan = plan_stops(TOUR, Pose2(5.0, 5.0, 0.0), reach, order=[2, 12])
    assert [stop.number for stop in plan.stops] == [13]
    assert [each.number for each in plan.skipped] == [3]
    assert "no route leads there" in plan.skipped[0].reason
