"""A mat in a picture: its corners, how blurred it is, and what is no single mat."""

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.mat.mats import sighting
from tests.perception.reading.mat.mat_photos import A3, A4, SMALL, around, photo

POSE = around(6)[1]
FINE = SMALL.resized(1280, 960)


def test_corners_lie_where_the_pose_projects_them() -> None:
    found = sighting(photo(A4, POSE))
    assert found is not None
    assert found.mat is A4
    assert len(found.numbers) > 100
    points = A4.corners(found.numbers, A4.square_mm / 1000)
    rays = (points - POSE.centre) @ POSE.rotation
    pixels = (rays / rays[:, 2:]) @ SMALL.matrix.T
    off = np.linalg.norm(found.pixels - pixels[:, :2], axis=1)
    assert np.median(off) < 0.15
    assert (off < 1.0).mean() > 0.95


@pytest.mark.parametrize("blur_px", [0.8, 1.6, 2.4])
def test_blur_is_measured_to_a_quarter(blur_px: float) -> None:
    found = sighting(photo(A4, POSE, FINE, blur_px=blur_px))
    assert found is not None
    # A pixel's own square has a standard deviation of 0.29 px, at either resolution.
    assert found.blur_px == pytest.approx(np.hypot(blur_px, 0.33), rel=0.25)


def test_two_mats_in_one_picture_are_refused() -> None:
    other = np.hstack([photo(A4, POSE), photo(A3, around(6, 0.45)[1])])
    with pytest.raises(InputError, match="two mats are seen, A3 and A4"):
        sighting(other)
    with pytest.raises(InputError, match="two mats A4 are seen"):
        sighting(np.hstack([photo(A4, POSE)] * 2))
