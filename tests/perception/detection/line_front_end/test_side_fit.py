"""Sides are fitted at working size, and more exactly in the picture as stored."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.side_fit import SideFits, fit_sides
from facetlog.perception.types import Camera, FloatArray, Image, Pose, StoredPicture, View

LARGE = Camera(1600, 1200, 2000.0, 2000.0, 799.5, 599.5)
KEPT = LARGE.resized(400, 300)
# A side through the middle, a little off the grid, seen from the front at a distance of 10.
SIDE = np.array([[[-2.0, -1.03, 10.0], [2.2, 1.1, 10.0]]])
SEEN = np.ones((1, 1), np.bool_)


def large_picture(contrast: float, noise: float, seed: int, bend_px: float = 0.0) -> Image:
    """One half brighter than the other along the side, blurred by 1.5 px."""
    start, end = (LARGE.matrix @ SIDE[0].T / 10.0)[:2].T
    unit = (end - start) / np.linalg.norm(end - start)
    v, u = np.mgrid[: LARGE.height, : LARGE.width].astype(np.float64)
    off = (u - start[0]) * -unit[1] + (v - start[1]) * unit[0] - bend_px
    soft = np.clip(off + 0.5, 0.0, 1.0)
    grey = cv2.GaussianBlur(100.0 + contrast * soft, (0, 0), 1.5)
    random = np.random.default_rng(seed)
    return np.clip(grey + random.normal(0, noise, grey.shape) + 0.5, 0, 255).astype(np.uint8)


def kept_view(large: Image) -> View:
    image = cv2.resize(large, (KEPT.width, KEPT.height), interpolation=cv2.INTER_AREA)
    pose = Pose(np.eye(3), np.zeros(3))
    stored = StoredPicture(LARGE, lambda: large)
    return View("a", np.asarray(image, dtype=np.uint8), KEPT, pose, stored)


def fitted(view: View) -> SideFits:
    (fits,) = fit_sides(SIDE, SEEN, [view], [edge_map(view.image)])
    return fits


def offsets(contrast: float, noise: float) -> tuple[FloatArray, FloatArray]:
    """Errors at both ends over six seeds in px of the kept picture: as kept, and as stored."""
    kept, stored = [], []
    for seed in range(6):
        view = kept_view(large_picture(contrast, noise, seed))
        kept.append(fitted(replace(view, stored=None)).offset[0])
        stored.append(fitted(view).offset[0])
    return np.array(kept), np.array(stored)


@pytest.mark.parametrize(("contrast", "noise"), [(80.0, 4.0), (20.0, 8.0)])
def test_the_stored_picture_is_more_accurate_than_the_kept_one(
    contrast: float, noise: float
) -> None:
    kept, stored = offsets(contrast, noise)
    assert np.sqrt((stored**2).mean()) < 0.6 * np.sqrt((kept**2).mean())
    assert np.sqrt((stored**2).mean()) < 0.02


def test_its_covariance_is_honest() -> None:
    squares = []
    for seed in range(12):
        fits = fitted(kept_view(large_picture(40.0, 6.0, seed)))
        squares.append(fits.offset[0] ** 2 / fits.variance[0])
    assert 0.2 < np.mean(squares) < 2.5


def test_where_the_stored_picture_shows_no_edge_the_first_fit_stays() -> None:
    view = kept_view(large_picture(80.0, 2.0, 0))
    other = np.full((LARGE.height, LARGE.width), 100, np.uint8)
    told = fitted(replace(view, stored=StoredPicture(LARGE, lambda: other)))
    alone = fitted(replace(view, stored=None))
    assert told.good.all()
    np.testing.assert_array_equal(told.offset, alone.offset)
