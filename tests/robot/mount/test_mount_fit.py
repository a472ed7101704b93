"""Calibration of the mount on synthetic corners, against the truth."""

import math
from dataclasses import replace

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.types import Pose
from facetlog.robot.mount.board import Corners
from facetlog.robot.mount.fit import Sighting, fit_mount
from facetlog.robot.mount.kinematics import Gaze, camera_pose, find_gaze
from facetlog.robot.mount.mount import DEFAULT_MOUNT, PARAMETERS, Mount
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera

CAMERA = tour_camera()
NOISE_PX = 0.2
ODOMETRY = np.diag([0.003**2, 0.003**2, math.radians(0.3) ** 2])
# Upright, its face to the robot at the origin: x to the robot's right, y down, z away from it.
FACING = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
BOARD = Pose(FACING, np.array([1.4, 0.13, 0.82]))
GRID = np.stack(np.meshgrid(np.arange(1, 7), np.arange(1, 5), [0]), axis=-1).reshape(-1, 3) * 0.04
TRUE = Mount(
    x=0.08, y=-0.012, z=0.73, yaw=math.radians(1.5), pitch=math.radians(-0.8),
    roll=math.radians(0.6), tilt_zero=math.radians(1.0), skew=math.radians(-0.7),
    pinhole_ahead=0.04, pinhole_left=0.006, pinhole_up=0.015,
)  # fmt: skip
BELIEVED = replace(DEFAULT_MOUNT, x=0.07)
STATIONS = (
    Pose2(0.0, 0.0, 0.0), Pose2(0.0, 0.0, 0.5), Pose2(0.0, 0.0, -0.5), Pose2(0.4, 0.2, -0.3),
    Pose2(0.4, 0.2, 0.3), Pose2(0.2, -0.3, 0.2), Pose2(0.2, -0.3, -0.4),
)  # fmt: skip


def _sightings(
    seed: int, stations: tuple[Pose2, ...] = STATIONS, *, aims: int = 5
) -> list[Sighting]:
    rng = np.random.default_rng(seed)
    found = []
    for number, true in enumerate(stations):
        off = rng.multivariate_normal(np.zeros(3), ODOMETRY if number else 0 * ODOMETRY)
        told = Pose2(true.x + off[0], true.y + off[1], true.heading + off[2])
        middle = BOARD.centre + BOARD.rotation @ GRID.mean(axis=0)
        at = find_gaze(true, TRUE, middle)
        for pan, tilt in ((0, 0), (0.2, 0.1), (-0.2, 0.1), (0.2, -0.1), (-0.2, -0.1))[:aims]:
            gaze = Gaze(at.pan + pan, at.tilt + tilt)
            pose = camera_pose(true, TRUE, gaze)
            points = BOARD.rotation @ GRID.T + BOARD.centre[:, None]
            x, y, z = pose.rotation.T @ (points - pose.centre[:, None])
            uv = np.stack([CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy], axis=1)
            uv += rng.normal(0, NOISE_PX, uv.shape)
            covariance = ODOMETRY if number else 0 * ODOMETRY
            found.append(Sighting(number, told, covariance, gaze, Corners(GRID, uv)))
    return found


def _off(mount: Mount, names: tuple[str, ...] = PARAMETERS) -> np.ndarray:
    """Errors in the fit's own standard deviations."""
    return np.array(
        [
            (value - true) / sd
            for name, value, true, sd in zip(
                PARAMETERS, mount.values, TRUE.values, mount.sds, strict=True
            )
            if name in names
        ]
    )


def test_the_mount_is_found_within_its_deviations() -> None:
    fit = fit_mount(_sightings(1), CAMERA, BELIEVED, board_height=float(BOARD.centre[2]))
    assert fit.undetermined == ()
    assert np.abs(_off(fit.mount)).max() < 4
    assert fit.rms_px == pytest.approx(NOISE_PX * math.sqrt(2), rel=0.3)
    sds = dict(zip(PARAMETERS, fit.mount.sds, strict=True))
    for name in ("pitch", "roll", "tilt_zero", "skew"):
        assert sds[name] < math.radians(0.25), name
    for name in ("pinhole_ahead", "pinhole_left", "pinhole_up"):
        assert sds[name] < 0.004, name


@pytest.mark.slow
def test_deviations_are_honest_over_many_calibrations() -> None:
    """Mean squared error in sds per number: 1 for honest ones, of 30 runs within .6 and 1.5."""
    squared = np.mean(
        [
            _off(fit_mount(_sightings(s), CAMERA, BELIEVED, board_height=0.82).mount) ** 2
            for s in range(30)
        ]
    )
    assert 0.4 < squared < 1.5


def test_without_the_boards_height_the_masts_stays_as_believed() -> None:
    fit = fit_mount(_sightings(2), CAMERA, BELIEVED)
    assert fit.undetermined == ("z",)
    assert (fit.mount.z, fit.mount.sds[2]) == (BELIEVED.z, BELIEVED.sds[2])
    others = tuple(name for name in PARAMETERS if name != "z")
    assert np.abs(_off(fit.mount, others)).max() < 4


def test_a_robot_that_never_moves_determines_no_place_of_the_axes() -> None:
    fit = fit_mount(_sightings(3, STATIONS[:1] * 2), CAMERA, BELIEVED)
    assert {"x", "y", "z", "yaw", "pitch", "roll"} <= set(fit.undetermined)
    assert "pinhole_ahead" not in fit.undetermined
    for name in fit.undetermined:
        assert getattr(fit.mount, name) == getattr(BELIEVED, name)


def test_too_few_sightings_are_refused() -> None:
    with pytest.raises(InputError, match="seen in 5 pictures, 6 are needed"):
        fit_mount(_sightings(0)[:5], CAMERA, BELIEVED)


def test_a_corner_taken_for_another_does_not_spoil_the_fit() -> None:
    sightings = _sightings(4)
    bad = sightings[7]
    pixels = bad.corners.pixels.copy()
    pixels[[3, 9]] = pixels[[9, 3]]
    sightings[7] = replace(bad, corners=Corners(bad.corners.points, pixels))
    fit = fit_mount(sightings, CAMERA, BELIEVED, board_height=float(BOARD.centre[2]))
    assert np.abs(_off(fit.mount)).max() < 5
