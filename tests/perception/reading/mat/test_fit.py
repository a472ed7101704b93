"""The fit to a mat's corners: as near to the truth as its covariance says, also from few views."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from facetlog.perception.estimation.bundle_adjustment.adjusted_points import adjusted_points
from facetlog.perception.estimation.bundle_adjustment.normal_equations import Tracks
from facetlog.perception.reading.mat.fit import Corners, FittedPose, MatFit, fitted
from facetlog.perception.reading.mat.mats import MATS
from facetlog.perception.types import (
    Camera,
    FloatArray,
    Pose,
    PoseErrorKind,
    PoseErrors,
    View,
)
from facetlog.robot.tour import make_pose_looking_at, make_ring_poses

SIZE, FOCAL = (1280, 960), 1050.0
LENS = np.array([0.08, -0.15, 4e-4, -5e-4, 0.05])
NOISE_PX = 0.2
EACH = 40
(MAT, *_) = MATS
# A block in the middle of the mat: corners, and which of them an edge joins.
BLOCK = np.array([[x, y, z] for x in (-0.04, 0.04) for y in (-0.03, 0.03) for z in (0.0, 0.07)])
EDGES = [(a, b) for a in range(8) for b in range(a) if ((BLOCK[a] != BLOCK[b]).sum() == 1)]


def corners(
    pose: Pose, rng: np.random.Generator, centre: FloatArray, rolling: float = 0.0
) -> Corners:
    """Some corners of the mat as a phone sees them whose rows are exposed in turn."""
    numbers = np.sort(rng.choice((MAT.columns - 1) * (MAT.rows - 1), EACH, replace=False))
    points = MAT.corners(numbers, MAT.square_mm / 1000)
    matrix = np.array([[FOCAL, 0, centre[0]], [0, FOCAL, centre[1]], [0, 0, 1]])
    still = (points - pose.centre) @ pose.rotation
    seen = project(still, matrix)
    turn = rng.normal(0.0, rolling, 3)
    moved = still + (seen[:, 1:] / SIZE[1] - 0.5) * np.cross(turn, still)
    pixels = project(moved, matrix) + rng.normal(0.0, NOISE_PX, (EACH, 2))
    return Corners(points, pixels, 0, SIZE[1])


def project(points: FloatArray, matrix: FloatArray) -> FloatArray:
    pixels, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, LENS)
    return np.reshape(pixels, (-1, 2))


def fit_of(seed: int, poses: tuple[Pose, ...], rolling: float = 0.0) -> tuple[MatFit, FloatArray]:
    rng = np.random.default_rng(seed)
    centre = np.array(SIZE) / 2 + rng.normal(0.0, 8.0, 2)
    seen = [corners(pose, rng, centre, rolling) for pose in poses]
    return fitted(seen, [SIZE], [None]), centre


def ring(seed: int, count: int) -> tuple[Pose, ...]:
    rng = np.random.default_rng([seed, 1])
    return make_ring_poses((0, 0, 0), 0.3, (0.2, 0.35), count, jitter=0.1, rng=rng)


def squared(found: FittedPose, true: Pose) -> float:
    """Normalised squared error of a pose, of six degrees of freedom."""
    turn = Rotation.from_matrix(true.rotation @ found.pose.rotation.T).as_rotvec()
    off = np.concatenate([true.centre - found.pose.centre, turn])
    return float(off @ np.linalg.solve(found.cov, off))


@pytest.mark.parametrize("rolling", [0.0, 5e-4])
@pytest.mark.slow
def test_poses_and_cameras_are_off_as_their_covariances_say(rolling: float) -> None:
    runs, of_poses, of_cameras = 12, [], []
    for seed in range(runs):
        poses = ring(seed, 6)
        fit, centre = fit_of(seed, poses, rolling)
        of_poses.append(squared(fit.poses[seed % 6], poses[seed % 6]))
        (camera,) = fit.cameras
        focal = np.log(camera.focal / FOCAL)
        off = np.concatenate([[focal], camera.centre - centre, camera.lens - LENS])
        of_cameras.append(float(off @ np.linalg.solve(camera.cov, off)))
    # The rolling is given a prior, so that without any the error is less than is said.
    least = chi2.ppf(1e-3, 6 * runs) if rolling else 0.0
    assert least < sum(of_poses) < chi2.ppf(1 - 1e-3, 6 * runs)
    assert sum(of_cameras) < chi2.ppf(1 - 1e-3, 8 * runs)


def test_pictures_from_straight_above_leave_the_distance_open() -> None:
    poses = tuple(make_pose_looking_at([x, -1e-3, 0.4], [x, 0, 0]) for x in (-0.02, 0.0, 0.02))
    fit, _ = fit_of(3, poses)
    slanted, _ = fit_of(3, ring(3, 3))
    assert np.sqrt(fit.cameras[0].cov[0, 0]) > 3 * np.sqrt(slanted.cameras[0].cov[0, 0])
    for found, true in zip(fit.poses, poses, strict=True):
        assert squared(found, true) < chi2.ppf(1 - 1e-4, 6)


def test_corners_that_were_mistaken_are_no_inliers() -> None:
    poses, rng = ring(2, 4), np.random.default_rng(2)
    seen = [corners(pose, rng, np.array(SIZE) / 2) for pose in poses]
    moved = seen[1].pixels.copy()
    moved[:3] += [4.0, -3.0]
    seen[1] = Corners(seen[1].points, moved, 0, SIZE[1])
    fit = fitted(seen, [SIZE], [None])
    assert not fit.poses[1].inliers[:3].any()
    assert np.mean([pose.inliers.mean() for pose in fit.poses]) > 0.9
    assert squared(fit.poses[1], poses[1]) < chi2.ppf(1 - 1e-4, 6)
    assert fit.poses[1].noise_px == pytest.approx(NOISE_PX, rel=0.3)


@pytest.mark.parametrize(
    ("count", "heights"), [(12, (0.2, 0.35)), (6, (0.2, 0.35)), (8, (0.35,))], ids=str
)
@pytest.mark.slow
def test_lengths_above_the_mat_are_as_sure_as_they_say(
    count: int, heights: tuple[float, ...]
) -> None:
    off = np.concatenate([squared_lengths(seed, count, heights) for seed in range(4)])
    assert off.mean() < 1.3
    assert off.max() < chi2.ppf(1 - 1e-4, 1)


def squared_lengths(seed: int, count: int, heights: tuple[float, ...]) -> FloatArray:
    """Normalised squared errors (12,) of a block's edges, found with the cameras of the mat."""
    rng = np.random.default_rng([seed, 2])
    poses = make_ring_poses((0, 0, 0), 0.3, heights, count, jitter=0.1, rng=rng)
    fit, centre = fit_of(seed, poses)
    true = np.array([[FOCAL, 0, centre[0]], [0, FOCAL, centre[1]], [0, 0, 1]])
    camera, placed = fit.cameras[0], [found.pose for found in fit.poses]
    f, (cx, cy) = camera.focal, camera.centre.tolist()
    straight = Camera(*SIZE, f, f, cx, cy)
    seen = [
        cv2.undistortPoints(
            project((BLOCK - pose.centre) @ pose.rotation, true)[:, None]
            + rng.normal(0.0, NOISE_PX, (8, 1, 2)),
            straight.matrix,
            camera.lens,
            P=straight.matrix,
        )
        for pose in poses
    ]
    uv = np.concatenate(seen, axis=1)
    noise = np.tile(NOISE_PX**2 * np.eye(2), (8, count, 1, 1))
    tracks = Tracks(uv, noise, np.ones((8, count), dtype=np.bool_), np.ones(count))
    image = np.zeros(SIZE[::-1], dtype=np.uint8)
    views = [View("", image, straight, pose) for pose in placed]
    covs = np.array([found.cov for found in fit.poses])
    stated = PoseErrors(tuple(placed), covs, PoseErrorKind.INDEPENDENT)
    found = adjusted_points(tracks, views, stated)
    one, two = np.array(EDGES).T
    span = found.points[one] - found.points[two]
    length = np.linalg.norm(span, axis=1)
    along = span / length[:, None]
    variance = np.einsum("ni,nij,nj->n", along, found.covs[one] + found.covs[two], along)
    true_length = np.linalg.norm(BLOCK[one] - BLOCK[two], axis=1)
    return np.asarray((length - true_length) ** 2 / variance)


def test_a_single_picture_has_a_pose_within_its_covariance() -> None:
    poses = ring(5, 1)
    fit, _ = fit_of(5, poses)
    assert squared(fit.poses[0], poses[0]) < chi2.ppf(1 - 1e-4, 6)
