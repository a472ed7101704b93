"""Cameras, lenses and poses from a mat's corners: the most probable ones, with their covariance.

A flat target seen from few places says little of some parameters: pictures that all look straight
down leave focal length and distance open, and corners in the middle say nothing of the lens further
out. So each parameter has a prior as wide as cameras differ; what pictures do not show stays there,
and how far it may be off is in the covariance of the poses. A phone exposes row after row while the
hand rotates it; that rotation is fitted, too, for most of it looks like another pose. So is by how
much the print is longer one way than the other, which the slant of other views would else explain.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from facetlog.perception.reading.exif import USUAL_FOCAL
from facetlog.perception.types import FloatArray, Pose

# Parameters of a camera: log of the focal length, principal point, k1, k2, p1, p2, k3 (OpenCV's).
OF_CAMERA = 8
# Of a picture: place, rotation vector, and the rotation vector from the first row to the last.
OF_PICTURE, OF_POSE = 9, 6
# Standard deviations of the prior: of the principal point as a share of the picture's diagonal, of
# the lens's parameters in the order of OpenCV.
CENTRE_SD = 0.02
LENS_SD = (0.3, 0.3, 0.003, 0.003, 0.3)
# Of the log of the focal length, where EXIF has it and where it has not.
FOCAL_SD, UNKNOWN_FOCAL_SD = 0.1, 0.5
ROLLING_SD = 5e-4
"""Radians about each axis from first row to last: a hand's 1 to 2 degrees a second, over the 15 to
30 ms in which phones read their rows."""
STRETCH_SD, NO_STRETCH_SD = 0.05, 1e-6
"""Standard deviations of the log of how much longer a print is away from the reader than across:
where it was fitted to a page that is not of its shape, and where it was not."""
LEAST_STRETCH, SURE_SDS = 0.005, 5.0
"""A print is taken as stretched by half a millimetre of its bar, which a ruler shows, if that is
sure: what pictures hardly tell would make the focal length less sure."""
FOCAL_STEPS = 9
ROUNDS = 60
ENOUGH = 1e-10
"""Relative decrease of the cost at which the fit is done."""
OUTLIER_SDS = 5.0
AVERAGE_WEIGHT = 20
"""The noise of a picture is drawn towards that of all, which counts as so many residuals."""
NOISE_ROUNDS = 4


_Inside = list[NDArray[np.bool_]]
"""Which corners (n,) of each picture are inliers."""


@dataclass(frozen=True, eq=False, slots=True)
class Corners:
    """Corners of a picture: places (n, 3) in the mat's frame and pixels (n, 2).

    `camera` is the index of its camera, `height` how many rows it has.
    """

    points: FloatArray
    pixels: FloatArray
    camera: int
    height: int

    @property
    def times(self) -> FloatArray:
        """Time at which the corners' rows were exposed (n,), from -1/2 to 1/2."""
        return np.asarray(self.pixels[:, 1] / self.height - 0.5)


@dataclass(frozen=True, eq=False, slots=True)
class FittedCamera:
    """A camera: focal length, principal point (2,), px, and k1, k2, p1, p2, k3; `cov` (8, 8) of the
    log of the focal length and the rest in this order.
    """

    focal: float
    centre: FloatArray
    lens: FloatArray
    cov: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class FittedPose:
    """The pose of a picture's middle row, with its covariance (6, 6) of place and rotation vector.

    Both are in the mat's axes. `noise_px` is the standard deviation of its corners' residuals,
    `inliers` (n,) says which of these fit.
    """

    pose: Pose
    cov: FloatArray
    noise_px: float
    inliers: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class MatFit:
    """All cameras and poses of a set of pictures.

    `stretch` is the log of how much longer the print is away from the reader (y) than across (x), 0
    where that is not sure.
    `cost` is the negative log of the likelihood and the prior, but for a constant: of two fits to
    the same corners that with the lower one is the more probable.
    """

    cameras: tuple[FittedCamera, ...]
    poses: tuple[FittedPose, ...]
    stretch: float
    cost: float


def fitted(
    pictures: Sequence[Corners],
    sizes: Sequence[tuple[int, int]],
    focals: Sequence[float | None],
) -> MatFit:
    """Fit cameras and poses to pictures; `sizes` are width and height, `focals` what EXIF says of
    each camera, in pixels.
    """
    fit = _Fit(pictures, sizes, focals)
    noise, inside = fit.settle(np.full(len(pictures), 1.0))
    if len(pictures) > 1:  # one picture shows it as another focal length
        fit, noise, inside = _try_stretch(fit, noise, inside)
    cov = fit.covariance(noise, inside)
    cameras = tuple(fit.camera(c, cov) for c in range(len(sizes)))
    return MatFit(
        cameras,
        tuple(fit.pose(k, cov, float(noise[k]), inside[k]) for k in range(len(pictures))),
        fit.stretch if fit.stretch_sd > NO_STRETCH_SD else 0.0,
        fit.cost(noise),
    )


def _try_stretch(
    fit: "_Fit", noise: FloatArray, inside: _Inside
) -> "tuple[_Fit, FloatArray, _Inside]":
    """Return the fit with the stretch of the print where the corners show one; else as it is."""
    free = copy(fit)
    free.stretch_sd = STRETCH_SD
    free.start()
    noise_then, inside_then = free.settle(np.full(len(noise), 1.0))
    sd = float(np.sqrt(free.covariance(noise_then, inside_then)[-1, -1]))
    is_sure = abs(free.stretch) > max(LEAST_STRETCH, SURE_SDS * sd)
    if is_sure and free.cost(noise_then) < fit.cost(noise):
        return free, noise_then, inside_then
    return fit, noise, inside


def _estimate_noise(
    residuals: Sequence[FloatArray], inside: Sequence[NDArray[np.bool_]], cameras: int
) -> FloatArray:
    """Return the standard deviation of each picture's residuals, (V,), px."""
    squares = np.array([(r[i] ** 2).sum() for r, i in zip(residuals, inside, strict=True)])
    # The parameters of the cameras are shared among all pictures.
    counts = np.array([2 * i.sum() - OF_PICTURE for i in inside]) - OF_CAMERA * cameras / len(
        inside
    )
    counts = np.maximum(counts, 1.0)
    average = squares.sum() / counts.sum()
    pooled = (squares + AVERAGE_WEIGHT * average) / (counts + AVERAGE_WEIGHT)
    return np.asarray(np.sqrt(pooled), dtype=np.float64)


def _estimate_robust_noise(residuals: Sequence[FloatArray], noise: FloatArray) -> FloatArray:
    # The median length of a residual of two normal parts is 1.177 of their standard deviation.
    medians = [float(np.median(np.linalg.norm(r, axis=1))) / 1.177 for r in residuals]
    return np.maximum(np.minimum(medians, noise), 1e-3)


class _Fit:
    """The parameters: cameras (C, 8), the poses' rotations, centres and rolling, and the stretch of
    the mat.
    """

    def __init__(
        self,
        pictures: Sequence[Corners],
        sizes: Sequence[tuple[int, int]],
        focals: Sequence[float | None],
    ) -> None:
        self.pictures = pictures
        diagonals = np.hypot(*np.array(sizes, dtype=np.float64).T)
        self.prior = np.zeros((len(sizes), OF_CAMERA))
        self.prior_sd = np.zeros((len(sizes), OF_CAMERA))
        for c, ((width, height), focal) in enumerate(zip(sizes, focals, strict=True)):
            usual = USUAL_FOCAL * diagonals[c] if focal is None else focal
            self.prior[c, :3] = np.log(usual), (width - 1) / 2, (height - 1) / 2
            self.prior_sd[c, 0] = UNKNOWN_FOCAL_SD if focal is None else FOCAL_SD
            self.prior_sd[c, 1:3] = CENTRE_SD * diagonals[c]
            self.prior_sd[c, 3:] = LENS_SD
        self.stretch_sd = NO_STRETCH_SD
        self.start()

    def start(self) -> None:
        """Begin anew: pinholes, and a print as it should be."""
        pictures = self.pictures
        self.cameras = self.prior.copy()
        self.rotations = np.zeros((len(pictures), 3, 3))
        self.centres = np.zeros((len(pictures), 3))
        self.rolling = np.zeros((len(pictures), 3))
        self.stretch = 0.0
        for c in range(len(self.cameras)):
            self._start(c)

    def _start(self, camera: int) -> None:
        """Choose the focal length, of several, at which the poses of a pinhole fit best."""
        own = [k for k, p in enumerate(self.pictures) if p.camera == camera]
        middle, sd = self.prior[camera, 0], self.prior_sd[camera, 0]
        least = np.inf
        for log_focal in np.linspace(middle - 2 * sd, middle + 2 * sd, FOCAL_STEPS):
            tried = self.prior[camera].copy()
            tried[0] = log_focal
            poses = [_placed(self.pictures[k], tried) for k in own]
            cost = sum(error for _, _, error in poses)
            if cost < least:
                least, self.cameras[camera] = cost, tried
                for k, (rotation, centre, _) in zip(own, poses, strict=True):
                    self.rotations[k], self.centres[k] = rotation, centre

    def settle(self, noise: FloatArray) -> tuple[FloatArray, _Inside]:
        """Refine from this noise (V,) on, and return the noise and which corners are inliers."""
        inside: _Inside = [np.ones(len(p.pixels), dtype=np.bool_) for p in self.pictures]
        for _ in range(NOISE_ROUNDS):
            self.refine(noise, inside)
            residuals = self.residuals()
            noise = _estimate_noise(residuals, inside, len(self.cameras))
            inside = [
                np.linalg.norm(r, axis=1) < OUTLIER_SDS * sd
                for r, sd in zip(residuals, _estimate_robust_noise(residuals, noise), strict=True)
            ]
        return noise, inside

    def residuals(self) -> list[FloatArray]:
        """Return projected less measured corners of each picture (n, 2), px."""
        return [self._projected(k)[0] - p.pixels for k, p in enumerate(self.pictures)]

    def refine(self, noise: FloatArray, inside: Sequence[NDArray[np.bool_]]) -> None:
        """Minimise the cost at this noise (V,) by Levenberg and Marquardt's steps."""
        damping, (cost, hessian, slope) = 1e-4, self._system(noise, inside)
        for _ in range(ROUNDS):
            before = self.cameras, self.rotations, self.centres, self.rolling, self.stretch
            damped = hessian + damping * np.diag(np.diag(hessian))
            self._move(np.asarray(-np.linalg.solve(damped, slope), dtype=np.float64))
            tried = self._system(noise, inside)
            if tried[0] <= cost:
                done = cost - tried[0] <= ENOUGH * cost
                damping, (cost, hessian, slope) = damping / 10, tried
                if done:
                    return
            else:
                self.cameras, self.rotations, self.centres, self.rolling, self.stretch = before
                damping *= 10
                if damping > 1e8:
                    return

    def covariance(self, noise: FloatArray, inside: Sequence[NDArray[np.bool_]]) -> FloatArray:
        """Return the covariance of all parameters, cameras first: the inverse of the cost's second
        derivative.
        """
        _, hessian, _ = self._system(noise, inside)
        unit = 1.0 / np.sqrt(np.diag(hessian))  # parameters of one size: better conditioned
        return np.asarray(np.linalg.inv(hessian * np.outer(unit, unit)) * np.outer(unit, unit))

    def cost(self, noise: FloatArray) -> float:
        """Return the negative log of likelihood and prior at this noise (V,); outliers count as
        limits.
        """
        total = 0.0
        for residuals, sd in zip(self.residuals(), noise, strict=True):
            squares = (residuals**2).sum(axis=1) / sd**2
            total += float(np.minimum(squares, OUTLIER_SDS**2).sum()) / 2
            total += 2 * len(squares) * float(np.log(sd))
        off, sds = self._from_prior()
        return total + float(np.sum((off / sds) ** 2)) / 2

    def camera(self, c: int, cov: FloatArray) -> FittedCamera:
        own = slice(OF_CAMERA * c, OF_CAMERA * (c + 1))
        p = self.cameras[c]
        return FittedCamera(float(np.exp(p[0])), p[1:3].copy(), p[3:].copy(), cov[own, own])

    def pose(
        self, k: int, cov: FloatArray, noise_px: float, inliers: NDArray[np.bool_]
    ) -> FittedPose:
        start = self._get_first_parameter(k)
        own = slice(start, start + OF_POSE)
        return FittedPose(
            Pose(self.rotations[k], self.centres[k]), cov[own, own], noise_px, inliers
        )

    def _get_first_parameter(self, k: int) -> int:
        """Return the index of a picture's first parameter."""
        return self.cameras.size + OF_PICTURE * k

    def _projected(self, k: int) -> tuple[FloatArray, FloatArray]:
        """Return pixels (n, 2) and their derivatives (n, 2, 18) by the camera's and the picture's
        numbers, and the stretch.

        A point X is in the camera's axes Y + s ω × Y, Y = Rᵀ (X - c), at the time s of its row.
        """
        picture, p = self.pictures[k], self.cameras[self.pictures[k].camera]
        on_mat = picture.points * [1.0, np.exp(self.stretch), 1.0]
        rotation, offset = self.rotations[k], on_mat - self.centres[k]
        still, time = offset @ rotation, picture.times[:, None]
        points = still + time * np.cross(self.rolling[k], still)
        pixels, jacobian = cv2.projectPoints(
            points, np.zeros(3), np.zeros(3), _matrix(p), np.asarray(p[3:])
        )
        J = np.asarray(jacobian, dtype=np.float64).reshape(len(offset), 2, -1)
        by_point, focal = J[:, :, 3:6], np.exp(p[0])
        by_place = by_point @ rotation.T
        columns = [focal * (J[:, :, 6] + J[:, :, 7])[..., None], J[:, :, 8:10], J[:, :, 10:15]]
        # With the centre at c + dc and R turned by w: X - c - dc - w × (X - c) before Rᵀ.
        columns += [-by_place, np.cross(by_place, offset[:, None, :])]
        columns += [time[..., None] * np.cross(still[:, None, :], by_point)]
        columns += [by_place[:, :, 1:2] * on_mat[:, None, 1:2]]
        return np.asarray(pixels, dtype=np.float64).reshape(-1, 2), np.concatenate(columns, axis=2)

    def _system(
        self, noise: FloatArray, inside: Sequence[NDArray[np.bool_]]
    ) -> tuple[float, FloatArray, FloatArray]:
        """Return half the cost at these parameters, its second derivative (Gauss, Newton) and its
        first.
        """
        off, sd = self._from_prior()
        hessian, slope = np.diag(sd**-2), off / sd**2
        cost = float(off @ slope) / 2
        for k, picture in enumerate(self.pictures):
            pixels, J = self._projected(k)
            use = inside[k]
            r = ((pixels - picture.pixels)[use] / noise[k]).ravel()
            J = J[use].reshape(len(r), -1) / noise[k]
            first = OF_CAMERA * picture.camera
            second = self._get_first_parameter(k)
            own = np.r_[first : first + OF_CAMERA, second : second + OF_PICTURE, len(off) - 1]
            hessian[np.ix_(own, own)] += J.T @ J
            slope[own] += J.T @ r
            cost += float(r @ r) / 2
        return cost, hessian, slope

    def _from_prior(self) -> tuple[FloatArray, FloatArray]:
        """Return how far all parameters are off their prior, and its standard deviations."""
        count, size = self.cameras.size, self._get_first_parameter(len(self.pictures)) + 1
        off, sd = np.zeros(size), np.full(size, np.inf)
        off[:count], sd[:count] = (self.cameras - self.prior).ravel(), self.prior_sd.ravel()
        off[count:-1].reshape(-1, OF_PICTURE)[:, OF_POSE:] = self.rolling
        sd[count:-1].reshape(-1, OF_PICTURE)[:, OF_POSE:] = ROLLING_SD
        off[-1], sd[-1] = self.stretch, self.stretch_sd
        return off, sd

    def _move(self, step: FloatArray) -> None:
        count = self.cameras.size
        self.cameras = self.cameras + step[:count].reshape(self.cameras.shape)
        moves = step[count:-1].reshape(-1, OF_PICTURE)
        self.stretch += float(step[-1])
        self.centres = self.centres + moves[:, :3]
        self.rotations = Rotation.from_rotvec(moves[:, 3:6]).as_matrix() @ self.rotations
        self.rolling = self.rolling + moves[:, 6:]


def _matrix(camera: FloatArray) -> FloatArray:
    focal = np.exp(camera[0])
    return np.array([[focal, 0.0, camera[1]], [0.0, focal, camera[2]], [0.0, 0.0, 1.0]])


def _placed(picture: Corners, camera: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return rotation and centre of a pinhole that sees the corners, and its error, px rms."""
    _, turns, shifts, errors = cv2.solvePnPGeneric(
        picture.points, picture.pixels, _matrix(camera), None, flags=cv2.SOLVEPNP_IPPE
    )
    rotation, _ = cv2.Rodrigues(turns[0])
    from_camera = np.asarray(rotation, dtype=np.float64).T
    return from_camera, -from_camera @ np.asarray(shifts[0]).ravel(), float(np.ravel(errors)[0])
