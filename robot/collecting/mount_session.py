"""Calibrating the mount: the robot looks at a board from several places, headings, pans and tilts.

It turns on the spot to both sides, goes ahead a little, turns again, and comes near enough to the
board to see it large: turns determine where the axes sit beside the axle, driving ahead the yaw,
pans and tilts the rest.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.camera.optics import Optics
from facetlog.robot.camera.source import FrameSource
from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.head.head import HeadState, PanTiltHead
from facetlog.robot.mount.board import Board, Corners, undistort_pixels
from facetlog.robot.mount.fit import Sighting, find_board_pose
from facetlog.robot.mount.kinematics import Gaze, camera_pose, find_gaze
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pioneer.state import RobotState
from facetlog.robot.pose2 import Pose2

SETTLE, HEAD_SETTLE, SHOT_TIMEOUT = 0.6, 0.2, 10.0
# Angles to each side at which the board is searched at first, nearest first.
SEARCH_PANS_DEG, SEARCH_TILTS_DEG = (0, -30, 30, -60, 60), (0, -15, 15)
# The board is put into the middle of the picture, and this far off it to all sides.
ASIDE, UP = math.radians(14.0), math.radians(9.0)
AIMS = ((0.0, 0.0), (ASIDE, UP), (-ASIDE, UP), (ASIDE, -UP), (-ASIDE, -UP))
# Headings to both sides of the one towards the board.
TURN = math.radians(30.0)
# How far the robot goes ahead, and how near to the board it may come by it (its radius besides).
AHEAD, NEAREST = 0.4, 0.5
WORTH_DRIVING = 0.1
FAR = "put it 1 to 2 m before the robot"


@dataclass(frozen=True, eq=False, slots=True)
class BoardRig:
    """Robot, head, camera, board and the mount so far; the world frame is where the robot began."""

    base: MobileBase
    head: PanTiltHead
    camera: FrameSource
    optics: Optics
    mount: Mount
    board: Board
    radius: float


def plan_stations(board: FloatArray, radius: float) -> tuple[Pose2, ...]:
    """Return where the robot stands to see a board at (x, y, …), itself at the origin facing along
    x.

    No part of a robot of this radius comes within half a metre of the board.

    >>> [round(pose.x, 2) for pose in plan_stations(np.array([1.5, 0.0]), 0.25)]
    [0.0, 0.0, 0.0, 0.4, 0.4, 0.4, 0.2]
    """
    far = math.hypot(board[0], board[1])
    bearing = math.atan2(board[1], board[0])
    ahead = min(AHEAD, far - NEAREST - radius)
    stations = [Pose2(0.0, 0.0, bearing + turn) for turn in (0.0, TURN, -TURN)]
    if ahead >= WORTH_DRIVING:
        x, y = ahead * math.cos(bearing), ahead * math.sin(bearing)
        stations += [Pose2(x, y, bearing + turn) for turn in (0.0, -TURN, TURN)]
        stations.append(Pose2(x / 2, y / 2, bearing + TURN))
    return tuple(stations)


def take_sightings(rig: BoardRig, report: Callable[[str], None]) -> Iterator[Sighting]:
    """Yield the board as seen from one station after the other; `report` gets a line for each.

    InputError if the board is not found from where the robot begins.
    """
    state = rig.base.stand(SETTLE)
    first, gaze = _search(rig, report)
    place = _placed(rig, state, first, gaze)
    start = rig.base.place(state)
    report(f"the board is {math.hypot(*_measure_offset(place, start)):.2f} m away")
    stations = plan_stations(np.array(_measure_offset(place, start)), rig.radius)
    for number, station in enumerate(stations):
        at = start.compose(station)
        here = rig.base.place(rig.base.state)
        if math.dist((here.x, here.y), (at.x, at.y)) >= WORTH_DRIVING / 2:
            rig.base.follow(((here.x, here.y), (at.x, at.y)))
        rig.base.turn_to(at.heading)
        state = rig.base.stand(SETTLE)
        seen = 0
        for sighting in _looks(rig, state, number, place):
            seen += 1
            yield sighting
        report(f"place {number + 1} of {len(stations)}: the board was seen {seen} times")


def _looks(rig: BoardRig, state: RobotState, number: int, place: Pose) -> Iterator[Sighting]:
    robot = rig.base.place(state)
    across, down = rig.board.across * rig.board.square, rig.board.down * rig.board.square
    middle = place.centre + place.rotation @ np.array([across / 2, down / 2, 0.0])
    towards = find_gaze(robot, rig.mount, middle)
    limits = rig.head.limits
    for aside, up in AIMS:
        pan = min(max(towards.pan + aside, limits.pan_min), limits.pan_max)
        tilt = min(max(towards.tilt + up, limits.tilt_min), limits.tilt_max)
        looks, corners = _look(rig, pan, tilt)
        if corners is not None:
            gaze = Gaze(looks.pan, looks.tilt)
            yield Sighting(number, robot, state.covariance, gaze, corners)


def _look(rig: BoardRig, pan: float, tilt: float) -> tuple[HeadState, Corners | None]:
    looks = rig.head.look(pan, tilt)
    after = max(looks.at, rig.base.state.at) + HEAD_SETTLE
    image = rig.camera.shot(after, SHOT_TIMEOUT).image
    rig.optics.check(image)
    corners = rig.board.corners(image)
    if corners is None:
        return looks, None
    return looks, Corners(corners.points, undistort_pixels(rig.optics, corners.pixels))


def _search(rig: BoardRig, report: Callable[[str], None]) -> tuple[Corners, Gaze]:
    limits = rig.head.limits
    ways = [(pan, tilt) for tilt in SEARCH_TILTS_DEG for pan in SEARCH_PANS_DEG]
    for number, (pan_deg, tilt_deg) in enumerate(ways, start=1):
        pan = min(max(math.radians(pan_deg), limits.pan_min), limits.pan_max)
        tilt = min(max(math.radians(tilt_deg), limits.tilt_min), limits.tilt_max)
        looks, corners = _look(rig, pan, tilt)
        if corners is not None:
            return corners, Gaze(looks.pan, looks.tilt)
        report(
            f"the board is not in sight at pan {pan_deg:+d}°, tilt {tilt_deg:+d}° "
            f"(look {number} of {len(ways)})"
        )
    raise InputError(
        f"the board is nowhere in sight: {FAR}, upright, lit, and check --board and --square"
    )


def _placed(rig: BoardRig, state: RobotState, corners: Corners, gaze: Gaze) -> Pose:
    seen_from = camera_pose(rig.base.place(state), rig.mount, gaze)
    place = find_board_pose(corners, rig.optics.camera, seen_from)
    if place is None:
        raise InputError(f"the board is seen too flat or too small: {FAR}, facing it")
    return place


def _measure_offset(place: Pose, start: Pose2) -> tuple[float, float]:
    """Return the board's corner on the floor, as seen from a place."""
    there = start.between(Pose2(float(place.centre[0]), float(place.centre[1]), 0.0))
    return there.x, there.y
