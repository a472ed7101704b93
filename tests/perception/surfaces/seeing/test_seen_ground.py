"""Nine views from above see all of the ground beside a plate, and nothing beneath it."""

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from facetlog.perception.detection.coarse_pictures import gradient
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.scene import SeenLattice
from facetlog.perception.surfaces.seeing.seen_ground import GroundLattice, GroundViews, seen_ground
from facetlog.perception.types import FloatArray, Image, Pose, View
from tests.perception.detection.drawings import CAMERA, HEIGHT, WIDTH, with_noise

UP = np.array([0.0, 0.0, 1.0])
DOWNWARDS = np.diag([1.0, -1.0, -1.0])
# Cameras 6 above the floor see 6.4 x 4.8 of it, a pixel .02.
PLACES = [np.array([x, y, 6.0]) for x in (-1.0, 0.0, 1.0) for y in (-0.8, 0.0, 0.8)]
PLATE = np.array([[-0.7, -0.6, 1.5], [0.7, -0.6, 1.5], [0.7, 0.6, 1.5], [-0.7, 0.6, 1.5]])
# Texels of what is drawn on a plane, side by side across the middle of it.
TEXEL, TEXELS = 0.02, 600
FLOOR_GREY, PLATE_GREY, NOISE = 90.0, 150.0, 2.0


@cache
def pattern(grey: float, contrast: float, seed: int) -> Image:
    """Blurred noise, as much as `contrast` (sd) about a grey level."""
    noise = np.random.default_rng(seed).normal(size=(TEXELS, TEXELS))
    smooth = cv2.GaussianBlur(noise, (0, 0), 1.0)
    return np.rint(grey + contrast * smooth / smooth.std()).clip(0, 255).astype(np.uint8)


def picture(
    place: FloatArray, floor: Image, plate: Image | None, rings: Sequence[FloatArray] = (PLATE,)
) -> View:
    """The view straight down from a place, of the floor and the plate above it, or parts of it."""
    seen = View("x.png", np.zeros((HEIGHT, WIDTH), np.uint8), CAMERA, Pose(DOWNWARDS, place))

    def drawn(texture: Image, height: float) -> Image:
        half = TEXEL * (TEXELS - 1) / 2
        plane = np.array([[TEXEL, 0, -half], [0, TEXEL, -half], [0, 0, height], [0, 0, 1]])
        return cv2.warpPerspective(texture, seen.projection @ plane, (WIDTH, HEIGHT))

    image = drawn(floor, 0.0)
    if plate is not None:
        mask = np.zeros_like(image)
        for ring in rings:
            seen_from = (ring - place) @ DOWNWARDS.T
            corners = CAMERA.fx * seen_from[:, :2] / seen_from[:, 2:] + [CAMERA.cx, CAMERA.cy]
            mask = cv2.fillPoly(mask, [np.rint(corners).astype(np.int32)], 1)
        image = np.where(mask > 0, drawn(plate, 1.5), image)
    seed = int(10 * place.sum() + 100)
    return View("x.png", with_noise(image, NOISE, seed), CAMERA, Pose(DOWNWARDS, place))


def seen(
    floor: Image,
    plate: Image | None,
    faces: Sequence[Sequence[FloatArray]] = (),
    rings: Sequence[FloatArray] = (PLATE,),
) -> tuple[SeenLattice, ...]:
    views = [picture(place, floor, plate, rings) for place in PLACES]
    levels = GreyLevels(views, [gradient(view.image) for view in views])
    return seen_ground(views, levels, np.ones(len(views)), faces, (UP, 0.0))


def points_of(lattice: SeenLattice) -> FloatArray:
    _, rows, columns = lattice.shown.shape
    index = np.stack(np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"), axis=-1)
    return lattice.corner + index @ lattice.steps


def crossed_by(points: FloatArray, place: FloatArray) -> FloatArray:
    """Where (..., 2) the ways to points cross the plate's height, a quarter of the way up."""
    return (0.75 * points + 0.25 * place)[..., :2]


def beside_and_beneath(lattice: SeenLattice) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which points (v, rows, columns) a view sees surely past the plate, by some pixels and well
    inside its picture, and which the plate hides.
    """
    points = points_of(lattice)
    beside, beneath = [], []
    for place in lattice.origins:
        crossed = np.abs(crossed_by(points, place))
        beneath.append((crossed < [0.62, 0.52]).all(axis=-1))
        near = (crossed < [0.85, 0.75]).all(axis=-1)
        away = np.abs(points - place)[..., :2]
        beside.append(~near & (away < [3.0, 2.2]).all(axis=-1))
    # Of what three views see at least, as more are wanted than one.
    sure = np.array(beside)
    return sure & (sure.sum(axis=0) >= 4), np.array(beneath)


FLOOR = pattern(FLOOR_GREY, 15.0, 0)
KNOWN = [[PLATE]]


@pytest.mark.parametrize("grey", [FLOOR_GREY, PLATE_GREY])
def test_a_printed_floor_is_seen_beside_a_plain_plate_that_nobody_found_and_not_beneath(
    grey: float,
) -> None:
    (lattice,) = seen(FLOOR, pattern(grey, 0.0, 1))
    beside, beneath = beside_and_beneath(lattice)
    assert lattice.wrong is None
    assert lattice.shown[beside].mean() > 0.95
    assert not lattice.shown[beneath].any()


def test_nothing_that_a_known_face_hides_is_seen_and_how_often_it_would_be_is_known() -> None:
    by_print, by_level = seen(FLOOR, pattern(PLATE_GREY, 15.0, 1), KNOWN)
    for lattice in (by_print, by_level):
        beside, beneath = beside_and_beneath(lattice)
        assert lattice.wrong is not None
        # Along the rim of the shadow windows reach over it; of levels one in 20 is let pass.
        assert lattice.wrong < 0.055
        assert lattice.shown[beside].mean() > 0.9
        assert not lattice.shown[beneath].any()


def test_a_plain_floor_is_seen_by_its_grey_where_a_face_says_how_often_that_is_wrong() -> None:
    plain, plate = pattern(FLOOR_GREY, 0.0, 0), pattern(PLATE_GREY, 0.0, 1)
    # The rims of the plate are all that is no plain grey, and some lie on a line.
    for lattice in seen(plain, plate):
        beside, beneath = beside_and_beneath(lattice)
        assert lattice.shown[beside].mean() < 0.05
        assert not lattice.shown[beneath].any()
    lattice = seen(plain, plate, KNOWN)[-1]
    beside, beneath = beside_and_beneath(lattice)
    assert lattice.wrong is not None
    assert lattice.wrong < 0.01
    assert lattice.shown[beside].mean() > 0.95
    assert not lattice.shown[beneath].any()


@pytest.mark.parametrize(("off", "lean"), [(0.06, 0.0), (-0.1, 0.0), (0.04, 0.02)])
def test_the_ground_is_put_where_its_print_agrees(off: float, lean: float) -> None:
    # far enough apart that a pixel up or down makes a difference
    apart = [place * [2.0, 2.0, 1.0] for place in PLACES]
    views = [picture(place, FLOOR, pattern(PLATE_GREY, 15.0, 1)) for place in apart]
    levels = GreyLevels(views, [gradient(view.image) for view in views])
    tilted = np.array([lean, 0.0, np.sqrt(1.0 - lean**2)])
    seeing = GroundViews(views, levels, np.arange(9), np.ones(9, np.float32))
    normal, height = seeing.aligned((tilted, off), UP)
    np.testing.assert_allclose(normal, UP)
    # a pixel is .02
    assert height == pytest.approx(0.0, abs=0.025)
    near = seeing.aligned((tilted, off))[1]
    assert abs(near) <= abs(off)


def test_fewer_views_than_agree_see_nothing() -> None:
    views = [picture(place, FLOOR, None) for place in PLACES[:2]]
    levels = GreyLevels(views, [gradient(view.image) for view in views])
    assert seen_ground(views, levels, np.ones(2), (), (UP, 0.0)) == ()
    # The same three times is no more than one by weight.
    same = [views[0]] * 3
    levels = GreyLevels(same, [gradient(view.image) for view in same])
    assert seen_ground(same, levels, np.full(3, 1 / 3), (), (UP, 0.0)) == ()


def test_the_shadow_of_a_face_is_where_the_ways_to_the_ground_cross_it() -> None:
    view = picture(PLACES[0], FLOOR, None)
    lattice = GroundLattice.under([view], UP, 0.0)
    assert lattice is not None
    hole = 0.5 * PLATE + [0.0, 0.0, 0.75]
    shadow = lattice.shadow([[PLATE, hole]], view)
    pitch = float(np.linalg.norm(lattice.steps[0]))
    # At 3/4 of the way to the camera's height: 4/3 as large, without the hole's quarter; what is
    # drawn has its rim, of outline and hole.
    rim = 4 / 3 * 1.5 * 2 * (1.4 + 1.2) / 2 * pitch
    assert abs(shadow.sum() * pitch**2 - 16 / 9 * 1.4 * 1.2 * 0.75) < rim
    assert not lattice.shadow([[PLATE * [1, 1, 0.01]]], view).any()
    # What reaches past the camera hides all that lies beyond.
    wall = np.array([[0.0, -9, -1], [0, 9, -1], [0, 9, 20], [0, -9, 20]])
    rows, columns = np.nonzero(lattice.shadow([[wall]], view))
    x = lattice.corner[0] + np.column_stack([rows, columns]) @ lattice.steps[:, 0]
    assert x.min() == pytest.approx(0.0, abs=2 * pitch)
    assert len(x) * pitch**2 > 0.9 * 2.2 * 6.4


def test_a_plain_floor_as_grey_as_what_hides_it_is_not_seen() -> None:
    assert seen(pattern(FLOOR_GREY, 0.0, 0), pattern(FLOOR_GREY, 0.0, 1), KNOWN) == ()
