"""The mat in a picture: its corners to a fraction of a pixel, and how blurred the picture is."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from facetlog.errors import InputError
from facetlog.perception.reading.mat.mats import Mat, dictionary, find_mat_of_marker
from facetlog.perception.types import FloatArray, Image

__all__ = ["LEAST_CORNERS", "MirroredError", "OtherBoardError", "Sighting", "sighting"]

LEAST_CORNERS = 8
"""Least number for a pose: half of their coordinates is more than its six parameters."""
LEAST_MARKERS = 3
"""Least number that shows a mat: a single marker may be misread anywhere."""
MISREAD_SQUARES = 0.5
"""Farther off than a lens bends the mat; a corner of another marker is at least one off."""
# A marker's outline is found along its outermost black pixels: its side comes out too short, in
# simulated pictures by half a pixel and the blur's standard deviation, and is never too long by
# half a pixel. The limit below allows half as much more.
LONGEST_SIDE_PX, SHORTER_PX, SHORTER_BY_BLUR = 0.5, 1.0, 1.5
MIRRORED_DIAGONAL_PX = 1600.0
"""Size at which a picture without a mat is looked at in a mirror."""
RIM_SQUARES = 0.125
"""Width of the white rim round a marker."""
PROFILE_SQUARES = 0.11
"""Half the length of a profile across an edge: within the rim."""
BLURS = np.linspace(0.01, 2.0, 200)
"""Standard deviations of blur in widths of the rim; beyond them no marker is read."""
PROFILE_SAMPLES = 41
NOTHING: tuple[NDArray[np.intp], FloatArray] = np.zeros(0, dtype=np.intp), np.zeros((0, 2))


_Marker = cv2.typing.MatLike
"""The corners of a marker in a picture, (1, 4, 2), clockwise as it is printed."""


class OtherBoardError(InputError):
    """The picture shows markers of a mat, but on another board than the mat."""


class MirroredError(InputError):
    """The picture shows the mat mirrored."""


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """A mat as a picture shows it: corners by number (n,), their pixels (n, 2).

    `blur_px` is the standard deviation of the blur in its worse direction, of nothing measured nan;
    `square_px` how long the squares' sides are, the median.
    """

    mat: Mat
    numbers: NDArray[np.intp]
    pixels: FloatArray
    blur_px: float
    square_px: float


def sighting(image: Image) -> Sighting | None:
    """Find the mat that a picture (H, W) shows; None where it shows none, or hardly anything of it.

    Raise InputError where it shows two, OtherBoardError where the markers are laid out otherwise
    than on the mat, MirroredError where they are so in a mirror.
    """
    markers, ids = _read_markers(image)
    of_mats = Counter(mat for n in set(ids) if (mat := find_mat_of_marker(n)) is not None)
    seen = [mat for mat, count in of_mats.items() if count >= LEAST_MARKERS]
    if not seen:
        _check_mirror(_reduce_size(image), None)
        return None
    twice = Counter(find_mat_of_marker(n) for n, count in Counter(ids).items() if count > 1)
    for mat in seen:
        if twice[mat] >= LEAST_MARKERS:
            raise InputError(f"two mats {mat.paper} are seen")
    laid_out = [mat for mat in seen if _is_laid_out(mat, markers, ids)]
    if not laid_out:
        for mat in seen:
            _check_mirror(image, mat)
        raise OtherBoardError(_describe_other_board(seen))
    if len(laid_out) > 1:
        raise InputError(f"two mats are seen, {' and '.join(sorted(m.paper for m in laid_out))}")
    (mat,) = laid_out
    own = [k for k, n in enumerate(ids) if n in mat.markers]
    markers, ids = [markers[k] for k in own], [ids[k] for k in own]
    agreeing = np.flatnonzero(_agreeing(mat, markers, ids)).tolist()
    markers, ids = [markers[k] for k in agreeing], [ids[k] for k in agreeing]
    numbers, pixels = _find_corners(image, mat, markers, ids)
    if len(numbers) < LEAST_CORNERS:
        return None
    blur_px, square_px = _measure_sharpness(image, mat, numbers, pixels)
    excess_px = _measure_side_excess(mat, markers, ids, numbers, pixels)
    shortest_px = -SHORTER_PX - SHORTER_BY_BLUR * blur_px
    if excess_px is not None and not shortest_px <= excess_px <= LONGEST_SIDE_PX:
        raise OtherBoardError(_describe_other_board([mat]))
    return Sighting(mat, numbers, pixels, blur_px, square_px)


def _read_markers(image: Image) -> tuple[list[_Marker], list[int]]:
    corners, found, _ = cv2.aruco.ArucoDetector(dictionary()).detectMarkers(image)
    return list(corners), [] if found is None else [int(n) for n in np.ravel(found)]


def _describe_other_board(mats: Sequence[Mat]) -> str:
    names = " or ".join(mat.name for mat in mats)
    return (
        f"shows another board than facetlog's {names}, with markers of other places or sizes: "
        "print ours (facetlog mat -o mat.pdf)"
    )


def _is_laid_out(mat: Mat, markers: Sequence[_Marker], ids: Sequence[int]) -> bool:
    """Return whether most of the markers of a mat that were read are where the mat has them.

    Of another board a few always are: those of one row. A marker of the mat is hardly ever misread.
    """
    own = [k for k, n in enumerate(ids) if n in mat.markers]
    agreeing = int(_agreeing(mat, [markers[k] for k in own], [ids[k] for k in own]).sum())
    return agreeing >= LEAST_MARKERS and 2 * agreeing > len(own)


def _agreeing(mat: Mat, markers: Sequence[_Marker], ids: Sequence[int]) -> NDArray[np.bool_]:
    """Return which markers (n,) lie, with all four corners, where one homography of the mat has
    them.
    """
    pixels = np.concatenate([np.reshape(marker, (4, 2)) for marker in markers]).astype(np.float64)
    flat = np.concatenate([mat.compute_marker_corners(n) for n in ids])
    _, inliers = cv2.findHomography(pixels, flat, cv2.RANSAC, MISREAD_SQUARES)
    if inliers is None:  # where all lie on one line
        return np.zeros(len(ids), dtype=np.bool_)  # type: ignore[unreachable] # the stubs: never
    return np.asarray(np.reshape(inliers, (-1, 4)).all(axis=1))


def _check_mirror(image: Image, mat: Mat | None) -> None:
    """Raise MirroredError if the picture in a mirror shows this mat, or any."""
    markers, ids = _read_markers(np.ascontiguousarray(image[:, ::-1]))
    mats = {found for n in ids if (found := find_mat_of_marker(n)) is not None}
    if any(_is_laid_out(each, markers, ids) for each in mats if mat in (None, each)):
        raise MirroredError(
            "is mirrored: switch the camera's mirroring off (selfie cameras have it), or mirror "
            "the picture back"
        )


def _reduce_size(image: Image) -> Image:
    share = MIRRORED_DIAGONAL_PX / float(np.hypot(*image.shape))
    if share >= 1.0:
        return image
    return np.asarray(
        cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA), dtype=np.uint8
    )


def _find_corners(
    image: Image, mat: Mat, markers: Sequence[_Marker], ids: Sequence[int]
) -> tuple[NDArray[np.intp], FloatArray]:
    """Return numbers (n,) and pixels (n, 2) of the corners beside these markers."""
    # One marker beside a corner is enough: the other one is often hidden. OpenCV's own check
    # refuses whole pictures.
    parameters = cv2.aruco.CharucoParameters()
    parameters.minMarkers, parameters.checkMarkers = 1, False
    detector = cv2.aruco.CharucoDetector(mat.board, parameters)
    which = np.array(ids, dtype=np.int32)[:, None]
    pixels, found, _, _ = detector.detectBoard(image, None, None, markers, which)
    if found is None or len(found) < LEAST_CORNERS:
        return NOTHING
    numbers = np.asarray(found, dtype=np.intp).ravel()
    return numbers, np.asarray(pixels, dtype=np.float64).reshape(-1, 2)


def _measure_side_excess(
    mat: Mat,
    markers: Sequence[_Marker],
    ids: Sequence[int],
    numbers: NDArray[np.intp],
    pixels: FloatArray,
) -> float | None:
    """Return by how many pixels the markers' sides are longer than the mat's in squares of that
    size: the median; None where no marker has all corners of its square.
    """
    at = {int(n): p for n, p in zip(numbers, pixels, strict=True)}
    flat = {int(n): p for n, p in zip(numbers, mat.corners(numbers, 1.0)[:, :2], strict=True)}
    found = []
    for marker, n in zip(markers, ids, strict=True):
        middle = mat.compute_marker_corners(n).mean(axis=0)
        of_square = [k for k, p in flat.items() if np.abs(p - middle).max() < 0.75]
        if len(of_square) < 4:
            continue
        to_flat = cv2.getPerspectiveTransform(
            np.array([at[k] for k in of_square], dtype=np.float32),
            np.array([flat[k] for k in of_square], dtype=np.float32),
        )
        read = np.asarray(marker, dtype=np.float32).reshape(1, 4, 2)
        side = _compute_mean_side(cv2.perspectiveTransform(read, to_flat)[0])
        square_px = _compute_mean_side(np.reshape(marker, (4, 2))) / side
        found.append((side - mat.marker_mm / mat.square_mm) * square_px)
    return float(np.median(found)) if found else None


def _compute_mean_side(corners: cv2.typing.MatLike) -> float:
    """Return the mean side of a quadrangle (4, 2)."""
    sides = np.asarray(corners, dtype=np.float64) - np.roll(corners, 1, axis=0)
    return float(np.linalg.norm(sides, axis=1).mean())


def _measure_sharpness(
    image: Image, mat: Mat, numbers: NDArray[np.intp], pixels: FloatArray
) -> tuple[float, float]:
    """Return the blur of the edges between neighbouring corners in the worse of both directions,
    and the median length of such an edge, px.
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
    """Return the median blur across edges (n, 2, 2) between a black square and a marker's white
    rim.
    """
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
    return float(np.median(rim * np.interp(widths, _compute_rim_widths(BLURS), BLURS)))


def _compute_rim_widths(sds: FloatArray) -> FloatArray:
    """Return contrast over slope of a white rim of width 1 beside black, blurred by Gaussians (n,).

    Blurred, the rim has the contrast 2 Φ(1 / 2 sd) - 1 in its middle, and at its edge the slope
    (1 - exp(-1 / 2 sd²)) / (sqrt(2 π) sd).
    """
    contrast = 2 * ndtr(0.5 / sds) - 1
    return np.asarray(contrast * np.sqrt(2 * np.pi) * sds / -np.expm1(-0.5 / sds**2))
