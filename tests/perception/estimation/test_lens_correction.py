"""Views corrected by what their lenses were found to be off by, and what is said of it."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.estimation.lens_correction import (
    combine_lens_errors,
    corrected,
    explain_lens_errors,
)
from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.types import LensError, StoredPicture
from tests.rendered import tour

LONGER = LensError(1.05, 0.0, 0.001, 0.002)


def test_a_longer_lens_leaves_the_picture_as_it_is() -> None:
    view = tour("block", 0)[0]
    better = corrected(view, LONGER)
    assert better.camera == view.camera.zoomed(1.05)
    assert (better.image == view.image).all()


def test_a_bent_picture_becomes_the_one_that_its_lens_undistorts() -> None:
    view = tour("block", 0)[0]
    lens = Lens(view.camera, Distortion.POLYNOMIAL, (-0.1, 0.0, 0.0, 0.0))
    better = corrected(view, LensError(1.0, -0.1, 0.001, 0.002))
    assert better.camera == lens.pinhole
    assert (better.image == lens.undistort(view.image)).all()


def test_the_stored_picture_is_corrected_when_it_is_read() -> None:
    view = tour("block", 0)[0]
    width, height = 2 * view.camera.width, 2 * view.camera.height
    large = np.full((height, width), 7, dtype=np.uint8)
    stored = StoredPicture(view.camera.resized(width, height), lambda: large)
    better = corrected(replace(view, stored=stored), LensError(1.1, -0.1, 0.001, 0.002))
    assert better.stored is not None
    assert better.stored.read().shape == large.shape
    assert better.stored_size == (width, height)
    assert better.stored.camera.fx == pytest.approx(2 * better.camera.fx, rel=1e-3)


def test_what_is_found_in_corrected_views_comes_on_top() -> None:
    both = combine_lens_errors(LensError(1.05, -0.1, 0.1, 0.1), LensError(0.99, 0.01, 0.001, 0.002))
    assert both.focal == pytest.approx(1.05 * 0.99)
    assert both.radial == pytest.approx(-0.09)
    assert both.focal_sd == pytest.approx(1.05 * 0.001)


def test_a_wrong_focal_length_is_named_with_the_right_one() -> None:
    view = tour("block", 0)[0]
    view = replace(view, camera=replace(view.camera, fx=500.0))
    (said,) = explain_lens_errors([view, view], [LONGER, LONGER])
    assert "525.00 ± 0.50 px (500.00 px is given)" in said
    assert "k1" not in said


def test_of_two_cameras_the_wrong_one_is_named() -> None:
    views = tour("block", 0)[:6]
    mixed = [replace(v, camera=v.camera.zoomed(1.5)) if k > 3 else v for k, v in enumerate(views)]
    right = LensError(1.0005, 0.001, 0.001, 0.002)
    (said,) = explain_lens_errors(mixed, [right] * 4 + [LONGER] * 2)
    assert f"of {views[4].name}, {views[5].name} is not as stated" in said
    one, other = explain_lens_errors(mixed, [LONGER] * 4 + [replace(LONGER, focal=0.9)] * 2)
    assert f"of {views[0].name}, {views[1].name}, {views[2].name} and 1 more is" in one
    assert f"of {views[4].name}" in other
