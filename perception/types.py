"""Cameras, poses and views, and tracks of vertices through them; scenes are in `scene.py`.

World frame: right-handed, any unit of length (metres where the unit is known).
Camera frame: OpenCV's, x right, y down, z forward. Pixels: the centre of the top-left pixel is
(0, 0), u to the right, v down. Arrays are float64 and not writeable, and copied on entry unless
they cannot be written to anyway.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.errors import CalibrationError
from facetlog.plain_text import plain_text

__all__ = [
    "Camera",
    "FloatArray",
    "Image",
    "LensError",
    "Observation",
    "Pose",
    "PoseErrorKind",
    "PoseErrors",
    "PositionLabel",
    "StoredPicture",
    "Track",
    "View",
    "frozen",
]

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]

# A rotation read from text keeps some 5 digits; more than this off orthogonal is another thing.
ROTATION_TOLERANCE = 1e-3

# numpy has one object for it: `is` takes a tenth of the time of `==`. What fails that is copied.
DOUBLE = np.dtype(np.float64)


def frozen(values: ArrayLike, *shape: int) -> FloatArray:
    """Return the values as an array of this shape that nobody can write to; ValueError for another
    shape.

    They are copied unless nobody can write to them anyway.
    """
    if isinstance(values, np.ndarray) and _is_frozen(values):
        array = values
    else:
        array = np.array(values, dtype=np.float64)
        array.setflags(write=False)
    if array.shape != shape:
        raise ValueError(f"expected shape {shape}, got {array.shape}")
    return array


def _is_frozen(array: NDArray[np.generic]) -> bool:
    """Return whether nobody can write to an array of float64, so that it need not be copied."""
    if array.dtype is not DOUBLE or array.flags.writeable:
        return False
    return array.base is None or (
        isinstance(array.base, np.ndarray) and not array.base.flags.writeable
    )


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera without distortion: size and intrinsics in pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        if self.width <= 0 or self.height <= 0:
            raise CalibrationError(f"picture size {self.width} x {self.height} is not positive")
        if not (self.fx > 0 and self.fy > 0 and np.isfinite([self.cx, self.cy]).all()):
            raise CalibrationError("focal lengths must be positive and the centre finite")

    @property
    def matrix(self) -> FloatArray:
        """Intrinsic matrix K, (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def zoomed(self, factor: float) -> "Camera":
        """Return the camera with so many times the focal length."""
        return replace(self, fx=factor * self.fx, fy=factor * self.fy)

    def resized(self, width: int, height: int) -> "Camera":
        """Return the camera of the same picture brought to another size."""
        across, down = width / self.width, height / self.height
        # Pixel centres: u' + 1/2 = across · (u + 1/2).
        return Camera(
            width,
            height,
            self.fx * across,
            self.fy * down,
            (self.cx + 0.5) * across - 0.5,
            (self.cy + 0.5) * down - 0.5,
        )


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a camera stands: `rotation` (3, 3) is world_from_camera, `centre` (3,) in the world."""

    rotation: FloatArray
    centre: FloatArray

    def __post_init__(self) -> None:
        rotation = np.array(self.rotation, dtype=np.float64)
        if rotation.shape != (3, 3) or not np.isfinite(rotation).all():
            raise CalibrationError("the rotation is not a finite 3 x 3 matrix")
        off = np.abs(rotation @ rotation.T - np.eye(3)).max()
        if not (off <= ROTATION_TOLERANCE and np.linalg.det(rotation) > 0):
            mirrored = off <= ROTATION_TOLERANCE
            fault = "mirrors" if mirrored else f"scales or shears (off by {off:.2g})"
            raise CalibrationError(
                f"the rotation is not one, it {fault}: give right-handed, orthogonal unit axes"
            )
        u, _, vt = np.linalg.svd(rotation)  # the nearest true rotation
        object.__setattr__(self, "rotation", frozen(u @ vt, 3, 3))
        centre = frozen(self.centre, 3)
        if not np.isfinite(centre).all():
            raise CalibrationError("the camera centre is not finite")
        object.__setattr__(self, "centre", centre)


@dataclass(frozen=True, eq=False, slots=True)
class StoredPicture:
    """A picture too large to be kept: its pinhole camera, and how to read it (H, W) uint8 anew."""

    camera: Camera
    read: Callable[[], Image]


class PoseErrorKind(StrEnum):
    """How the errors of poses hang together: not at all, or added up on the way."""

    INDEPENDENT = "independent"
    ODOMETRY = "odometry"


@dataclass(frozen=True, eq=False, slots=True)
class PoseErrors:
    """How far poses may be off, as whoever measured them states it.

    `poses` (V) are those that were measured, `covariances` (V, 6, 6) of each camera's place (world
    units) and of a rotation vector (radians), both in the world's axes. `scale_sd` is the relative
    standard deviation of the world's unit: an error that all poses, and all lengths, have alike.
    """

    poses: tuple[Pose, ...]
    covariances: FloatArray
    kind: PoseErrorKind = PoseErrorKind.ODOMETRY
    scale_sd: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "covariances", frozen(self.covariances, len(self.poses), 6, 6))

    def of(self, chosen: Sequence[int]) -> "PoseErrors":
        """Return the errors of the chosen poses (indices)."""
        poses = tuple(self.poses[k] for k in chosen)
        return PoseErrors(poses, self.covariances[list(chosen)], self.kind, self.scale_sd)


@dataclass(frozen=True, slots=True)
class LensError:
    """Correction that was found for a lens beyond what is stated of it, with standard deviations.

    It has `focal` times the focal length, and bends rays outwards by `radial` r² (OpenCV's k1).
    """

    focal: float
    radial: float
    focal_sd: float
    radial_sd: float


@dataclass(frozen=True, eq=False)
class View:
    """One grey picture with its camera and pose."""

    name: str
    """Name of the view in messages."""
    image: Image
    """Grey levels (H, W), uint8, of a pinhole's picture."""
    camera: Camera
    """The intrinsics, in pixels of `image`."""
    pose: Pose
    """Where the camera stands."""
    stored: StoredPicture | None = None
    """The picture itself where `image` is a reduced copy of it."""
    pose_cov: FloatArray | None = None
    """How far the pose may be off, (6, 6) as in `PoseErrors`, where its source states it."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", plain_text(self.name))
        if self.image.shape != (self.camera.height, self.camera.width):
            raise CalibrationError(
                f"{self.name}: the picture is {self.image.shape[1]} x {self.image.shape[0]}, "
                f"its camera says {self.camera.width} x {self.camera.height}"
            )

    @cached_property
    def projection(self) -> FloatArray:
        """P = K [R | -R c] with R camera_from_world, (3, 4): world (homogeneous) to pixels."""
        r = self.pose.rotation.T
        return self.camera.matrix @ np.column_stack([r, -r @ self.pose.centre])

    @property
    def stored_size(self) -> tuple[int, int]:
        """Width and height of the picture itself."""
        camera = self.camera if self.stored is None else self.stored.camera
        return camera.width, camera.height

    @property
    def enlargement(self) -> FloatArray:
        """Pixels of the picture itself, across and down, for one of `image`, (2,)."""
        return np.array(self.stored_size) / [self.camera.width, self.camera.height]


@dataclass(frozen=True, eq=False, slots=True)
class Observation:
    """A vertex seen in one view: index of the view, pixel (2,), covariance (2, 2) in px²."""

    view: int
    uv: FloatArray
    cov: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "uv", frozen(self.uv, 2))
        object.__setattr__(self, "cov", frozen(self.cov, 2, 2))

    def resized(self, factor: FloatArray) -> "Observation":
        """Return the observation in a picture so many times the size, across and down (2,)."""
        if (factor == 1.0).all():
            return self
        return Observation(
            self.view, (self.uv + 0.5) * factor - 0.5, self.cov * np.outer(factor, factor)
        )


class PositionLabel(StrEnum):
    """Position of a vertex on its block, as the paper labels them (section 5.3)."""

    FRONT_LEFT_TOP = "front_left_top"
    FRONT_RIGHT_TOP = "front_right_top"
    BACK_LEFT_TOP = "back_left_top"
    BACK_RIGHT_TOP = "back_right_top"
    FRONT_LEFT_BOTTOM = "front_left_bottom"
    FRONT_RIGHT_BOTTOM = "front_right_bottom"
    BACK_LEFT_BOTTOM = "back_left_bottom"
    BACK_RIGHT_BOTTOM = "back_right_bottom"


@dataclass(frozen=True, slots=True)
class Track:
    """One vertex in several views; at most one observation a view."""

    observations: tuple[Observation, ...]
    label: PositionLabel | None = None
