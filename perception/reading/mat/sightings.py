"""The mat in a picture: its corners to a fraction of a pixel, and how blurred the picture is."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from facetlog.errors import InputError
from facetlog.perception.reading.mat.mats import Mat, dictionary, mat_of_marker
from facetlog.perception.types import FloatArray, Image

__all__ = ["LEAST_CORNERS", "Sighting", "sighting"]

LEAST_CORNERS = 8
"""Half of the coordinates that they have is more than the six of a pose."""
LEAST_MARKERS = 3
"""Of a mat, to say that it is there: a single one may be read into anything."""
MISREAD_SQUARES = 0.5
"""Farther off than a lens bends the mat; a corner of another marker is at least one off."""
RIM_SQUARES = 0.125
"""Width of the white rim round a marker."""
PROFILE_SQUARES = 0.11
"""Half the length of a profile across an edge: within the rim."""
BLURS = np.linspace(0.01, 2.0, 200)
"""Standard deviations of blur in widths of the rim; beyond them no marker is read."""
PROFILE_SAMPLES = 41
NOTHING: tuple[NDArray[np.intp], FloatArray] = np.zeros(0, dtype=np.intp), np.zeros((0, 2))


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """What a picture shows of a mat: corners by number (n,), their pixels (n, 2).

    `blur_px` is the standard deviation of the blur in its worse direction, of nothing measured nan;
    `square_px` how long the squares' sides are, the median.
    """

    mat: Mat
    numbers: NDArray[np.intp]
    pixels: FloatArray
    blur_px: float
    square_px: float


def sighting(image: Image) -> Sighting | None:
    """The mat that a picture (H, W) shows; None where it shows none, or hardly anything of one.

    InputError where it shows two.
    """
    corners, found, _ = cv2.aruco.ArucoDetector(dictionary()).detectMarkers(image)
    ids = [] if found is None else [int(n) for n in np.ravel(found)]
    of_mats = Counter(mat for n in set(ids) if (mat := mat_of_marker(n)) is not None)
    seen = [mat for mat, count in of_mats.items() if count >= LEAST_MARKERS]
    if len(seen) > 1:
        raise InputError(f"two mats are seen, {' and '.join(sorted(m.paper for m in seen))}")
    if not seen:
        return None
    (mat,) = seen
    own = [k for k, n in enumerate(ids) if n in mat.markers]
    twice = sum(count > 1 for count in Counter(ids[k] for k in own).values())
    if twice >= LEAST_MARKERS:
        raise InputError(f"two mats {mat.paper} are seen")
    markers = np.array([[ids[k]] for k in own], dtype=np.int32)
    numbers, pixels = _corners(image, mat, [corners[k] for k in own], markers)
    if len(numbers) < LEAST_CORNERS:
        return None
    return Sighting(mat, numbers, pixels, *_sharpness(image, mat, numbers, pixels))


def _corners(
    image: Image,
    mat: Mat,
    markers: Sequence[cv2.typing.MatLike],
    which: NDArray[np.int32],
) -> tuple[NDArray[np.intp], FloatArray]:
    """Numbers (n,) and pixels (n, 2) of the corners beside markers that were found."""
    # One marker beside a corner is enough: the other one is often hidden. OpenCV's own check
    # refuses whole pictures.
    parameters = cv2.aruco.CharucoParameters()
    parameters.minMarkers, parameters.checkMarkers = 1, False
    detector = cv2.aruco.CharucoDetector(mat.board, parameters)
    pixels, found, _, _ = detector.detectBoard(image, None, None, markers, which)
    if found is None or len(found) < LEAST_CORNERS:
        return NOTHING
    numbers = np.asarray(found, dtype=np.intp).ravel()
    at = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    # A marker that was misread puts corners squares away from where all others have them.
    flat = mat.corners(numbers, 1.0)[:, :2]
    _, inliers = cv2.findHomography(at, flat, cv2.RANSAC, MISREAD_SQUARES)
    if inliers is None:  # where all lie on one line
        return NOTHING  # type: ignore[unreachable] # OpenCV's stubs say that it is always there
    fits = np.asarray(inliers).ravel() > 0
    return numbers[fits], at[fits]


def _sharpness(
    image: Image, mat: Mat, numbers: NDArray[np.intp], pixels: FloatArray
) -> tuple[float, float]:
    """Blur of the edges between neighbouring corners in the worse of both directions, and the
    median length of such an edge, px.
    """
    at = {int(n): p for n, p in zip(numbers, pixels, strict=True)}
    across = [(n, n + 1) for n in at if (n + 1) % (mat.columns - 1) and n + 1 in at]
    away = [(n, n + mat.columns - 1) for n in at if n + mat.columns - 1 in at]
    found, sides = [], []
    for family in (across, away):
        if family:
            ends = np.array([[at[a], at[b]] for a, b in family])
            found.append(_blur(image, ends))
            sides.append(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    if not found:
        return float("nan"), float("nan")
    return float(np.max(found)), float(np.median(np.concatenate(sides)))


def _blur(image: Image, ends: FloatArray) -> float:
    """The median blur across edges (n, 2, 2) between a black square and a marker's white rim."""
    middle, along = ends.mean(axis=1), ends[:, 1] - ends[:, 0]
    half = PROFILE_SQUARES * np.stack([-along[:, 1], along[:, 0]], axis=1)
    steps = np.linspace(-1.0, 1.0, PROFILE_SAMPLES)
    at = (middle[:, None] + steps[:, None] * half[:, None]).astype(np.float32)
    profiles = cv2.remap(image, at[..., 0], at[..., 1], cv2.INTER_LINEAR).astype(np.float64)
    step_px = np.linalg.norm(half, axis=1) * 2 / (PROFILE_SAMPLES - 1)
    slope = np.abs(np.gradient(profiles, axis=1)).max(axis=1) / step_px
    usable = slope > 0
    if not usable.any():
        return float("nan")
    rim = RIM_SQUARES * np.linalg.norm(along, axis=1)[usable]
    widths = np.ptp(profiles, axis=1)[usable] / slope[usable] / rim
    return float(np.median(rim * np.interp(widths, _widths_of_rims(BLURS), BLURS)))


def _widths_of_rims(sds: FloatArray) -> FloatArray:
    """Contrast over slope of a white rim of width 1 beside black, blurred by Gaussians (n,).

    Blurred, the rim has the contrast 2 Φ(1 / 2 sd) - 1 in its middle, and at its edge the slope
    (1 - exp(-1 / 2 sd²)) / (sqrt(2 π) sd).
    """
    contrast = 2 * ndtr(0.5 / sds) - 1
    return np.asarray(contrast * np.sqrt(2 * np.pi) * sds / -np.expm1(-0.5 / sds**2))
