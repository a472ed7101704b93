"""The mats that `facetlog mat` prints: a ChArUco board on each size of paper.

The mat's frame, which is the world's of pictures of it: origin in the middle of the board, x to the
right and y away from who reads the print, z up out of the paper; metres.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

__all__ = ["BAR_MM", "DICTIONARY", "MATS", "Mat", "dictionary", "find_mat", "find_mat_of_marker"]

DICTIONARY = "DICT_4X4_250"
BAR_MM = 100.0
"""The bar that is printed beside the board, for a ruler to check the printer by."""
MODULES = 6
"""Modules along a side of a marker: four of its code, and one of black on either side."""


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
