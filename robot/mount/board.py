"""A printed board with known corners, and where a picture shows them.

A ChArUco board (squares with coded markers) is identified by any visible part; a plain chessboard
only if all of it is visible, and only if it is not symmetric under half a turn.
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
    """Squares across and down, their side and that of the markers in metres (0: a chessboard).

    The board's frame: x to the right, y down, z into the board, from its upper left corner.
    """

    across: int
    down: int
    square: float
    marker: float = 0.0

    def __post_init__(self) -> None:
        if self.across < 3 or self.down < 3:
            raise InputError(f"a board of {self.across} x {self.down} squares is too small: 3 x 3")
        if not 0 <= self.marker < self.square:
            raise InputError("a board's markers are smaller than its squares, and both above 0")
        if not self.marker and (self.across + self.down) % 2 == 0:
            raise InputError(
                f"a chessboard of {self.across} x {self.down} squares looks the same turned round: "
                "use an even and an odd number, or a board with markers"
            )

    def picture(self) -> Image:
        """The board to be printed, grey; its squares are 120 pixels wide."""
        size = (self.across * SQUARE_PX, self.down * SQUARE_PX)
        if self.marker:
            return np.asarray(self._charuco().generateImage(size), dtype=np.uint8)
        squares = np.indices((self.down, self.across)).sum(axis=0) % 2 * 255
        return np.kron(squares, np.ones((SQUARE_PX, SQUARE_PX))).astype(np.uint8)

    def corners(self, image: Image) -> Corners | None:
        """The inner corners that a picture shows, to a tenth of a pixel; None if too few."""
        grey = image
        if image.ndim == 3:
            grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        return self._coded(grey) if self.marker else self._plain(grey)

    def _charuco(self) -> cv2.aruco.CharucoBoard:
        return cv2.aruco.CharucoBoard(
            (self.across, self.down),
            self.square,
            self.marker,
            cv2.aruco.getPredefinedDictionary(MARKERS),
        )

    def _coded(self, grey: Image) -> Corners | None:
        found, numbers, _, _ = cv2.aruco.CharucoDetector(self._charuco()).detectBoard(grey)
        if found is None or numbers is None or len(numbers) < LEAST_CORNERS:
            return None
        index = np.asarray(numbers).ravel()
        columns = self.across - 1
        places = np.column_stack([index % columns + 1, index // columns + 1, 0 * index])
        points = self.square * places.astype(np.float64)
        return Corners(points, np.asarray(found, dtype=np.float64).reshape(-1, 2))

    def _plain(self, grey: Image) -> Corners | None:
        size = (self.across - 1, self.down - 1)
        done, found = cv2.findChessboardCornersSB(grey, size, flags=cv2.CALIB_CB_ACCURACY)
        if not done:
            return None
        pixels = np.asarray(found, dtype=np.float64).reshape(-1, 2)
        # OpenCV may list them from either end: the square beyond the first is the black one.
        inward = self.across  # of the second corner of the second row
        first = _grey_at(grey, 1.5 * pixels[0] - 0.5 * pixels[inward])
        last = _grey_at(grey, 1.5 * pixels[-1] - 0.5 * pixels[-1 - inward])
        if first > last:
            pixels = pixels[::-1]
        rows, columns = np.mgrid[1 : self.down, 1 : self.across]
        places = np.column_stack([columns.ravel(), rows.ravel(), 0 * rows.ravel()])
        return Corners(self.square * places.astype(np.float64), pixels)


def _grey_at(grey: Image, pixel: FloatArray) -> float:
    """The mean of the pixels next to a place; that of the rim if it is outside."""
    height, width = grey.shape
    u = min(max(round(float(pixel[0])), 1), width - 2)
    v = min(max(round(float(pixel[1])), 1), height - 2)
    return float(grey[v - 1 : v + 2, u - 1 : u + 2].mean())


def straight_pixels(optics: Optics, pixels: FloatArray) -> FloatArray:
    """Pixels (n, 2) as the pinhole without its lens's distortion would have shown them."""
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
