"""The mount calibrated from pictures of a board: the eleven numbers that fit its corners best.

Bundle adjustment: least squares of the corners' reprojection errors over the mount, the board's
pose and the robot's poses, for which odometry gives priors. Every number of the mount has a wide
prior; what the motions do not determine stays at its prior, and numbers whose standard deviation
the pictures did not make much smaller are named.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.types import Camera, FloatArray, Pose
from facetlog.robot.mount.board import Corners
from facetlog.robot.mount.kinematics import Gaze, camera_pose, compute_camera_frames
from facetlog.robot.mount.mount import LENGTHS, PARAMETERS, Mount
from facetlog.robot.pose2 import Pose2

# Prior standard deviations of a mount: wide enough that the pictures decide what they can.
PRIOR_LENGTH_SD, PRIOR_ANGLE_SD = 0.05, math.radians(5.0)
# Standard deviation of a detected corner, px (OpenCV refines to about a tenth; lens and print add).
CORNER_SD_PX = 0.3
# Neither the floor nor the printed board is perfectly flat: no pose of the robot is better known
# than this, metres and radians.
PLACE_SD, HEADING_SD = 0.001, math.radians(0.1)
# A number that keeps this share of its prior standard deviation is not determined.
UNDETERMINED = 0.5
BOARD_HEIGHT_SD = 0.002
# For derivatives, metres and radians: the root of the precision of a double.
STEP = 1.5e-8
LEAST_SIGHTINGS = 6


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """The board seen from one place at one pan and tilt.

    `station` counts the places where the robot stood: sightings of one station share its error.
    `robot` is the pose by odometry, with covariance (3, 3); corners are undistorted pixels.
    """

    station: int
    robot: Pose2
    covariance: FloatArray
    gaze: Gaze
    corners: Corners


@dataclass(frozen=True, slots=True)
class MountFit:
    """The mount with its deviations; what is undetermined; rms reprojection error, pixels."""

    mount: Mount
    undetermined: tuple[str, ...]
    rms_px: float
    sightings: int


def find_board_pose(corners: Corners, camera: Camera, seen_from: Pose) -> Pose | None:
    """Return the board's pose in the world from one picture (its frame is that of `Board`)."""
    done, turn, shift = cv2.solvePnP(
        corners.points, corners.pixels, camera.matrix, None, flags=cv2.SOLVEPNP_IPPE
    )
    if not done:
        return None
    rotation = Rotation.from_rotvec(np.asarray(turn).ravel()).as_matrix()
    centre = seen_from.centre + seen_from.rotation @ np.asarray(shift).ravel()
    return Pose(seen_from.rotation @ rotation, centre)


def fit_mount(
    sightings: Sequence[Sighting],
    camera: Camera,
    prior: Mount,
    *,
    board_height: float | None = None,
) -> MountFit:
    """Return the mount that fits the sightings best, from the prior `prior`.

    `board_height` is that of the board's upper left corner over the floor, metres: without it the
    mount's height stays at its prior. InputError for too few sightings.
    """
    if len(sightings) < LEAST_SIGHTINGS:
        raise InputError(
            f"the board was seen in {len(sightings)} pictures, {LEAST_SIGHTINGS} are needed: put "
            "it where the camera sees it from several places, in good light"
        )
    problem = _Problem(sightings, camera, prior, board_height)
    # Robust against outliers: a corner mistaken for another one would bias all numbers.
    found = least_squares(problem.residuals, problem.start, problem.jacobian, loss="soft_l1")
    plain = problem.residuals(found.x)
    jacobian = np.asarray(found.jac)
    pixels = plain[: problem.pixel_count].reshape(-1, 2)
    rms = float(np.sqrt(np.mean(np.sum(pixels**2, axis=1)))) * CORNER_SD_PX
    # Residuals larger than their standard deviations mean unmodelled errors.
    worse = max(1.0, 2 * float(np.median(pixels**2)) / MEDIAN_CHI2_1 / 2)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * worse
    sds = np.sqrt(np.diag(covariance))[: len(PARAMETERS)]
    open_ones = tuple(
        name
        for name, sd in zip(PARAMETERS, sds, strict=True)
        if sd > UNDETERMINED * _find_prior_sd(name)
    )
    values = np.array(prior.values) + found.x[: len(PARAMETERS)]
    kept = [name in open_ones for name in PARAMETERS]
    mount = prior.replace_values(tuple(np.where(kept, prior.values, values).tolist()))
    deviations = tuple(np.where(kept, prior.sds, sds).tolist())
    return MountFit(replace(mount, sds=deviations), open_ones, rms, len(sightings))


# Median of a squared standard normal variable.
MEDIAN_CHI2_1 = 0.4549


def _find_prior_sd(name: str) -> float:
    return PRIOR_LENGTH_SD if name in LENGTHS else PRIOR_ANGLE_SD


def _compute_whitening(sightings: Sequence[Sighting], station: int) -> FloatArray:
    """Return w (3, 3) with Wᵀ W the inverse of the covariance of a station's place."""
    odometry = next(s.covariance for s in sightings if s.station == station)
    covariance = odometry + np.diag([PLACE_SD**2, PLACE_SD**2, HEADING_SD**2])
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


class _Problem:
    """The unknowns as one vector: changes of the mount, the board's pose, changes of stations."""

    def __init__(
        self,
        sightings: Sequence[Sighting],
        camera: Camera,
        prior: Mount,
        board_height: float | None,
    ) -> None:
        self.camera, self.prior, self.height = camera, prior, board_height
        first = sightings[0]
        place = find_board_pose(first.corners, camera, camera_pose(first.robot, prior, first.gaze))
        if place is None:
            raise InputError("the first picture of the board gives no pose: take it from nearer")
        self.board = place
        self.stations = sorted({s.station for s in sightings})
        self.whitening = [_compute_whitening(sightings, station) for station in self.stations]
        self.station = np.array([self.stations.index(s.station) for s in sightings])
        self.places = np.array([(s.robot.x, s.robot.y, s.robot.heading) for s in sightings])
        self.gazes = np.array([(s.gaze.pan, s.gaze.tilt) for s in sightings])
        self.points = np.concatenate([s.corners.points for s in sightings])
        self.pixels = np.concatenate([s.corners.pixels for s in sightings])
        self.picture = np.repeat(
            np.arange(len(sightings)), [len(s.corners.pixels) for s in sightings]
        )
        self.start = np.zeros(len(PARAMETERS) + 6 + 3 * len(self.stations))
        self.pixel_count = self.pixels.size
        self.prior_sds = np.array([_find_prior_sd(name) for name in PARAMETERS])
        self.owners, self.owned = self._owners()

    def _owners(self) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """Return the number of each residual's station, and whether it has one."""
        nobody = np.full(1, -1)
        owners = np.concatenate(
            [
                np.repeat(self.station[self.picture], 2),
                np.repeat(nobody, len(PARAMETERS)),
                np.repeat(np.arange(len(self.stations)), 3),
                np.repeat(nobody, self.height is not None),
            ]
        )
        return np.maximum(owners, 0), owners >= 0

    def residuals(self, x: FloatArray) -> FloatArray:
        """Return pixels, then priors, all in standard deviations."""
        numbers = len(PARAMETERS)
        mount = self.prior.replace_values(
            tuple((np.array(self.prior.values) + x[:numbers]).tolist())
        )
        turn = Rotation.from_rotvec(x[numbers : numbers + 3]).as_matrix() @ self.board.rotation
        origin = self.board.centre + x[numbers + 3 : numbers + 6]
        changes = x[numbers + 6 :].reshape(-1, 3)
        rotations, centres = compute_camera_frames(
            self.places + changes[self.station], mount, self.gazes
        )
        corners = self.points @ turn.T + origin - centres[self.picture]
        seen = np.einsum("nji,nj->ni", rotations[self.picture], corners)
        focal = np.array([self.camera.fx, self.camera.fy])
        pixels = focal * seen[:, :2] / seen[:, 2:] + [self.camera.cx, self.camera.cy]
        parts = [((pixels - self.pixels) / CORNER_SD_PX).ravel()]
        parts.append(x[:numbers] / self.prior_sds)
        parts += [w @ off for w, off in zip(self.whitening, changes, strict=True)]
        if self.height is not None:
            parts.append(np.array([(origin[2] - self.height) / BOARD_HEIGHT_SD]))
        return np.concatenate(parts)

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Return derivatives of the residuals by differences; all stations are moved at once.

        A residual depends only on its own station's pose, so three moves are enough for all.
        """
        shared = len(PARAMETERS) + 6
        base = self.residuals(x)
        jacobian = np.zeros((len(base), len(x)))
        for i in range(shared):
            step = np.zeros_like(x)
            step[i] = STEP
            jacobian[:, i] = (self.residuals(x + step) - base) / STEP
        for axis in range(3):
            step = np.zeros_like(x)
            step[shared + axis :: 3] = STEP
            change = (self.residuals(x + step) - base) / STEP
            jacobian[np.arange(len(base)), shared + axis + 3 * self.owners] = np.where(
                self.owned, change, 0.0
            )
        return jacobian
