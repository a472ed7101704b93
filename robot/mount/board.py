"""A printed ChArUco board (squares with coded markers), and where a picture shows its corners.

The board is identified by any visible part.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray, Image
from facetlog.robot.camera.optics import Optics

# Fewer corners hardly determine a pose; four are the minimum.
LEAST_CORNERS = 6
MARKERS = cv2.aruco.DICT_4X4_250
# Pixels of the printed picture to a square.
SQUARE_PX = 120


@dataclass(frozen=True, eq=False, slots=True)
class Corners:
    """Corners that a picture shows: on the board (n, 3) in metres, z = 0; pixels (n, 2)."""

    points: FloatArray
    pixels: FloatArray


@dataclass(frozen=True, slots=True)
class Board:
    """Squares across and down, their side and that of the markers in metres.

    The board's frame: x to the right, y down, z into the board, from its upper left corner.
    """

    across: int
    down: int
    square: float
    marker: float

    def __post_init__(self) -> None:
        if self.across < 3 or self.down < 3:
            raise InputError(f"a board of {self.across} x {self.down} squares is too small: 3 x 3")
        if not 0 < self.marker < self.square:
            raise InputError("a board's markers are smaller than its squares, and both above 0")

    def picture(self) -> Image:
        """Return the board to be printed, grey; its squares are 120 pixels wide."""
        size = (self.across * SQUARE_PX, self.down * SQUARE_PX)
        return np.asarray(self._make_charuco_board().generateImage(size), dtype=np.uint8)

    def corners(self, image: Image) -> Corners | None:
        """Return the inner corners that a picture shows, to a tenth of a pixel; None if too few."""
        grey = image
        if image.ndim == 3:
            grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        found, numbers, _, _ = cv2.aruco.CharucoDetector(self._make_charuco_board()).detectBoard(
            grey
        )
        if found is None or numbers is None or len(numbers) < LEAST_CORNERS:
            return None
        index = np.asarray(numbers).ravel()
        columns = self.across - 1
        places = np.column_stack([index % columns + 1, index // columns + 1, 0 * index])
        points = self.square * places.astype(np.float64)
        return Corners(points, np.asarray(found, dtype=np.float64).reshape(-1, 2))

    def _make_charuco_board(self) -> cv2.aruco.CharucoBoard:
        return cv2.aruco.CharucoBoard(
            (self.across, self.down),
            self.square,
            self.marker,
            cv2.aruco.getPredefinedDictionary(MARKERS),
        )


def undistort_pixels(optics: Optics, pixels: FloatArray) -> FloatArray:
    """Return pixels (n, 2) as the pinhole without its lens's distortion would have shown them."""
    if optics.model == "PINHOLE":
        return pixels
    names = ("k1", "k2", "k3", "k4") if optics.model == "OPENCV_FISHEYE" else ()
    matrix = optics.camera.matrix
    points = pixels.reshape(-1, 1, 2)
    if names:
        bent = np.array([optics.coefficient(name) for name in names])
        straight = cv2.fisheye.undistortPoints(points, matrix, bent, P=matrix)
    else:
        if optics.coefficient("k4"):
            raise InputError("a camera with k4 cannot be used here: calibrate it with k1 to k3")
        order = ("k1", "k2", "p1", "p2", "k3")
        bent = np.array([optics.coefficient(name) for name in order])
        straight = cv2.undistortPoints(points, matrix, bent, P=matrix)
    return np.asarray(straight, dtype=np.float64).reshape(-1, 2)
