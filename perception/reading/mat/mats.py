"""The mats that `facetlog mat` prints, and the mat in a picture: its corners, how blurred it is.

A mat is a ChArUco board on a size of paper. Its frame, which is the world's of pictures of it:
origin in the middle of the board, x to the right and y away from who reads the print, z up out of
the paper; metres. In a picture its corners are found to a fraction of a pixel.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray, Image

DICTIONARY = "DICT_4X4_250"
BAR_MM = 100.0
"""The bar that is printed beside the board, for a ruler to check the printer by."""
MODULES = 6
"""Modules along a side of a marker: four of its code, and one of black on either side."""
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


@dataclass(frozen=True)
class Mat:
    """A mat: its paper and lengths in millimetres, squares across and away, and its first marker.

    Black squares alternate with white ones, that nearest the reader's far left is black; each white
    one holds a marker, numbered from `first_marker` row by row.
    """

    paper: str
    width_mm: float
    height_mm: float
    columns: int
    rows: int
    square_mm: float
    marker_mm: float
    first_marker: int

    @property
    def markers(self) -> range:
        """The numbers of its markers in the dictionary."""
        return range(self.first_marker, self.first_marker + self.columns * self.rows // 2)

    @property
    def name(self) -> str:
        """Name for people."""
        return f"mat {self.paper}"

    @cached_property
    def board(self) -> cv2.aruco.CharucoBoard:
        """The board for OpenCV, whose frame is another one; lengths in squares."""
        size, share = (self.columns, self.rows), self.marker_mm / self.square_mm
        numbers = np.array(self.markers, dtype=np.int32)
        return cv2.aruco.CharucoBoard(size, 1.0, share, dictionary(), numbers)

    def corners(self, numbers: NDArray[np.intp], square: float) -> FloatArray:
        """Return where the inner corners (n,) of OpenCV's numbers lie in the mat's frame (n, 3).

        `square` is the side of a square as printed, in metres.
        """
        row, column = np.divmod(numbers, self.columns - 1)
        x = (column + 1 - self.columns / 2) * square
        y = (self.rows / 2 - (row + 1)) * square
        return np.column_stack([x, y, np.zeros_like(x)])

    def compute_marker_corners(self, number: int) -> FloatArray:
        """Return the corners of a marker in the mat's frame, in squares (4, 2), clockwise as
        printed.
        """
        points = np.asarray(self.board.getObjPoints()[number - self.first_marker])[:, :2]
        # OpenCV's frame begins at the far left corner, and its y runs towards the reader.
        return np.asarray((points - [self.columns / 2, self.rows / 2]) * [1.0, -1.0])

    def black(self) -> Iterator[tuple[float, float, float, float]]:
        """Yield all that is black of the board: left, low, width and height of rectangles, in
        millimetres from the paper's lower left corner.
        """
        left = (self.width_mm - self.columns * self.square_mm) / 2
        top = (self.height_mm + self.rows * self.square_mm) / 2
        rim = (self.square_mm - self.marker_mm) / 2
        module = self.marker_mm / MODULES
        numbers = iter(self.markers)
        for row in range(self.rows):
            low = top - (row + 1) * self.square_mm
            for column in range(self.columns):
                x = left + column * self.square_mm
                if (row + column) % 2 == 0:
                    yield x, low, self.square_mm, self.square_mm
                    continue
                for line, cells in enumerate(_cells(next(numbers))):
                    y = low + rim + self.marker_mm - (line + 1) * module
                    for start, end in _runs(cells):
                        yield x + rim + start * module, y, (end - start) * module, module


# Squares as wide as leaves a printer the margins that it cannot print, and room for the words.
MATS = (
    Mat("A4", 297.0, 210.0, 15, 10, 18.0, 13.5, first_marker=0),
    Mat("A3", 420.0, 297.0, 16, 11, 24.0, 18.0, first_marker=75),
    Mat("Letter", 279.4, 215.9, 14, 10, 18.0, 13.5, first_marker=163),
)


def find_mat(paper: str) -> Mat | None:
    """Return the mat on that paper, in any case of letters; None if there is none."""
    return next((mat for mat in MATS if mat.paper.lower() == paper.lower()), None)


def find_mat_of_marker(number: int) -> Mat | None:
    """Return the mat that has this marker; None if none has."""
    return next((mat for mat in MATS if number in mat.markers), None)


def dictionary() -> cv2.aruco.Dictionary:
    """Return OpenCV's dictionary of all mats' markers."""
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, DICTIONARY))


def _cells(number: int) -> NDArray[np.bool_]:
    """Return which modules of a marker are black, (6, 6)."""
    drawn = cv2.aruco.generateImageMarker(dictionary(), number, MODULES)
    return np.asarray(np.asarray(drawn) == 0, dtype=np.bool_)


def _runs(cells: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Yield first and last but one of the runs of black modules in a row."""
    change = np.flatnonzero(np.diff(np.concatenate([[False], cells, [False]]).astype(np.int8)))
    yield from zip(change[::2].tolist(), change[1::2].tolist(), strict=True)


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
