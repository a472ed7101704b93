"""The mats: what is printed is the board that OpenCV looks for, at the place that is said."""

from itertools import combinations

import cv2
import numpy as np
import pytest

from facetlog.perception.reading.mat.mats import MATS, Mat, mat_named, mat_of_marker

PX_PER_MM = 8
of_each_paper = pytest.mark.parametrize("mat", MATS, ids=lambda mat: mat.paper)


def drawn(mat: Mat) -> np.ndarray:
    """The sheet at 8 px to a millimetre, (H, W)."""
    height, width = round(mat.height_mm * PX_PER_MM), round(mat.width_mm * PX_PER_MM)
    sheet = np.full((height, width), 255, dtype=np.uint8)
    for x, y, w, h in mat.black():
        left, right = round(x * PX_PER_MM), round((x + w) * PX_PER_MM)
        top, bottom = height - round((y + h) * PX_PER_MM), height - round(y * PX_PER_MM)
        sheet[top:bottom, left:right] = 0
    return sheet


@of_each_paper
def test_opencv_finds_every_corner_where_the_mat_says_that_it_is(mat: Mat) -> None:
    corners, numbers, _, _ = cv2.aruco.CharucoDetector(mat.board).detectBoard(drawn(mat))
    assert len(numbers) == (mat.columns - 1) * (mat.rows - 1)
    places = 1000 * mat.corners(np.ravel(numbers), mat.square_mm / 1000)
    x, y = (places[:, 0] + mat.width_mm / 2), (mat.height_mm / 2 - places[:, 1])
    expected = np.column_stack([x, y]) * PX_PER_MM - 0.5
    assert np.abs(np.reshape(corners, (-1, 2)) - expected).max() < 1.0
    assert np.ptp(places[:, 0]) == pytest.approx((mat.columns - 2) * mat.square_mm)
    assert not places[:, 2].any()


@of_each_paper
def test_all_that_is_black_leaves_the_margin_of_a_printer(mat: Mat) -> None:
    for x, y, width, height in mat.black():
        assert 6 < x < x + width < mat.width_mm - 6
        assert 6 < y < y + height < mat.height_mm - 6


def test_no_marker_belongs_to_two_mats() -> None:
    for one, other in combinations(MATS, 2):
        assert not set(one.markers) & set(other.markers)
    assert mat_of_marker(MATS[1].markers[-1]) is MATS[1]
    assert mat_of_marker(249) is None


def test_paper_is_named_in_any_case() -> None:
    assert mat_named("letter") is mat_named("Letter") is not None
    assert mat_named("A5") is None
