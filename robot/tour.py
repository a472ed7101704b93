"""Where the pictures are taken from: the paper's tour of 24 views, and rings round any object."""

import csv
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.perception.types import Camera, FloatArray, Pose

TOUR_WIDTH_PX = 640
TOUR_HEIGHT_PX = 480
# SET-IV stands 33-37 in away: a lens of 48.8 degrees cuts a corner or two off, 65 shows all.
TOUR_ANGLE_ACROSS_DEG = 65.0


def tour_camera() -> Camera:
    """Return the camera of the tour: 640 x 480 pixels, 65 degrees across, principal point in the
    middle.

    >>> round(tour_camera().fx, 2)
    502.3
    """
    focal = float(TOUR_WIDTH_PX / 2 / np.tan(np.deg2rad(TOUR_ANGLE_ACROSS_DEG / 2)))
    # The middle of the picture, where the middle of the first pixel is (0, 0).
    cx, cy = (TOUR_WIDTH_PX - 1) / 2, (TOUR_HEIGHT_PX - 1) / 2
    return Camera(TOUR_WIDTH_PX, TOUR_HEIGHT_PX, focal, focal, cx, cy)


def tour_poses() -> tuple[Pose, ...]:
    """Return the 24 poses of the paper's figure 8, in inches, with its three misprinted pans put
    right.

    Figures from robot/tour.csv, which keeps the printed angles beside the ones used: pans of
    set 1 map 1 and set 4 maps 5 and 6 look away from the block as printed, and the printed tilts
    (90 degrees is level) would miss it, so all views have the tilt of the paper's worked example.

    >>> len(tour_poses())
    24
    """
    text = files("facetlog.robot").joinpath("tour.csv").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return tuple(
        pan_tilt_pose(
            float(row["x_in"]),
            float(row["y_in"]),
            float(row["z_in"]),
            np.deg2rad(float(row["pan_deg"])),
            np.deg2rad(float(row["tilt_deg"])),
        )
        for row in csv.DictReader(lines)
    )


def make_pose_looking_at(centre: ArrayLike, target: ArrayLike) -> Pose:
    """Return pose of an upright camera at `centre` (3,) that looks at `target` (3,); z is up.

    ValueError if it would look straight up or down, where upright means nothing.
    """
    eye = np.asarray(centre, dtype=np.float64)
    forward = np.asarray(target, dtype=np.float64) - eye
    right = np.cross(forward, [0.0, 0.0, 1.0])
    if not np.linalg.norm(right) > 1e-9 * np.linalg.norm(forward):
        raise ValueError("the view is straight up or down, or has no direction")
    forward /= np.linalg.norm(forward)
    right /= np.linalg.norm(right)
    return Pose(np.column_stack([right, np.cross(forward, right), forward]), eye)


def make_ring_poses(
    target: ArrayLike,
    distance: float,
    heights: tuple[float, ...],
    count: int,
    *,
    jitter: float = 0.0,
    rng: np.random.Generator | None = None,
) -> tuple[Pose, ...]:
    """Return `count` cameras evenly round `target` (3,), all looking at it, in the world's unit.

    `distance` is measured over the ground, `heights` above the target are taken in turn. With
    `jitter` (a share of the distance) place and aim are shifted at random.
    """
    middle = np.asarray(target, dtype=np.float64)
    random = np.random.default_rng(0) if rng is None else rng
    poses = []
    for i in range(count):
        angle = 2 * np.pi * i / count
        level: FloatArray = distance * np.array([np.cos(angle), np.sin(angle), 0.0])
        shift = jitter * distance * random.uniform(-1.0, 1.0, (2, 3))
        eye = middle + level + [0.0, 0.0, heights[i % len(heights)]] + shift[0]
        poses.append(make_pose_looking_at(eye, middle + shift[1]))
    return tuple(poses)
