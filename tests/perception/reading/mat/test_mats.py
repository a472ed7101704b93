"""The mats: what is printed is the board that OpenCV looks for, at the place that is said."""

import cv2
import numpy as np
import pytest

from facetlog.perception.reading.mat.mats import MATS, Mat, find_mat, find_mat_of_marker
from tests.perception.reading.mat.mat_photos import sheet

PX_PER_MM = 8
of_each_paper = pytest.mark.parametrize("mat", MATS, ids=lambda mat: mat.paper)


@of_each_paper
def test_opencv_finds_every_corner_where_the_mat_says_that_it_is(mat: Mat) -> None:
    page = sheet(mat, PX_PER_MM)
    corners, numbers, _, _ = cv2.aruco.CharucoDetector(mat.board).detectBoard(page)
    assert len(numbers) == (mat.columns - 1) * (mat.rows - 1)
    places = 1000 * mat.corners(np.ravel(numbers), mat.square_mm / 1000)
    x, y = (places[:, 0] + mat.width_mm / 2), (mat.height_mm / 2 - places[:, 1])
    expected = np.column_stack([x, y]) * PX_PER_MM - 0.5
    assert np.abs(np.reshape(corners, (-1, 2)) - expected).max() < 1.0
    assert np.ptp(places[:, 0]) == pytest.approx((mat.columns - 2) * mat.square_mm)
    assert not places[:, 2].any()
    assert find_mat_of_marker(mat.markers[0]) is find_mat_of_marker(mat.markers[-1]) is mat
    assert find_mat(mat.paper.lower()) is mat


@of_each_paper
def test_all_that_is_black_leaves_the_margin_of_a_printer(mat: Mat) -> None:
    for x, y, width, height in mat.black():
        assert 6 < x < x + width < mat.width_mm - 6
        assert 6 < y < y + height < mat.height_mm - 6
