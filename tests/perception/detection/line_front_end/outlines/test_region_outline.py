"""Regions of a plane on which the pictures agree, and their borders as polygons."""

import cv2
import numpy as np
import pytest
import shapely

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.outlines.plane_regions import RegionFinder
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    border,
    fit_outline_polygon,
    iter_rough_polygons,
    remove_short_sides,
    remove_straight_corners,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

SIZE = 120


def filled(corners: FloatArray) -> FloatArray:
    """The border of the cells whose middles lie in a polygon (k, 2)."""
    x, y = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5)
    inside = shapely.contains_xy(shapely.Polygon(corners), x, y)
    return border(inside.astype(np.uint8))


def sides(corners: FloatArray) -> FloatArray:
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


SHAPES = {
    "square": [[20, 20], [100, 25], [95, 100], [15, 95]],
    "triangle": [[20, 20], [100, 30], [50, 100]],
    "ell": [[20, 20], [100, 20], [100, 60], [60, 60], [60, 100], [20, 100]],
    "thin": [[10, 50], [110, 58], [110, 66], [10, 58]],
    "frame with legs": [
        [10, 90],
        [110, 90],
        [110, 20],
        [95, 20],
        [95, 75],
        [25, 75],
        [25, 20],
        [10, 20],
    ],
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_region_between_lines_has_its_corners_where_they_cross(name: str) -> None:
    true = np.array(SHAPES[name], dtype=float)
    if shapely.Polygon(true).exterior.is_ccw is False:
        true = true[::-1]
    found = fit_outline_polygon(filled(true), sides(true))
    assert found is not None
    assert len(found) == len(true)
    away = np.linalg.norm(found[:, None] - true[None], axis=-1).min(axis=0)
    assert away.max() < 0.1


@pytest.mark.parametrize("lines", [[], [0, 1, 2]])
def test_a_side_without_a_line_follows_the_region(lines: list[int]) -> None:
    true = np.array(SHAPES["square"], dtype=float)
    found = fit_outline_polygon(filled(true), sides(true)[lines].reshape(-1, 2, 2))
    assert found is not None
    overlap = shapely.Polygon(found).symmetric_difference(shapely.Polygon(true)).area
    assert overlap < 0.06 * shapely.Polygon(true).area


def test_a_frayed_border_has_a_rough_polygon_of_few_sides() -> None:
    true = np.array(SHAPES["square"], dtype=float)
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5)
    inside = shapely.contains_xy(shapely.Polygon(true), x, y).astype(np.uint8)
    for at in np.argwhere(cv2.morphologyEx(inside, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))):
        if rng.uniform() < 0.15:
            cv2.circle(inside, (int(at[1]), int(at[0])), 2, int(rng.integers(2)), cv2.FILLED)
    ring = border(inside)
    rough = list(iter_rough_polygons(ring, 40))
    assert min(len(corners) for corners in rough) <= 5
    sizes = [len(corners) for corners in rough]
    assert sizes == sorted(set(sizes), reverse=True)
    for corners in rough:
        polygon = shapely.Polygon(corners)
        both = polygon.intersection(shapely.Polygon(true)).area
        assert both / polygon.union(shapely.Polygon(true)).area > 0.85


def test_a_blunt_corner_becomes_the_crossing_of_its_sides() -> None:
    blunt = np.array([[0.0, 0], [97, 0], [100, 3], [100, 100], [0, 100]])
    sharp = remove_short_sides(blunt, 5.0)
    assert len(sharp) == 4
    true = np.array([[0.0, 0], [100, 0], [100, 100], [0, 100]])
    assert np.linalg.norm(sharp[:, None] - true[None], axis=-1).min(axis=1).max() < 1e-9
    np.testing.assert_array_equal(remove_short_sides(blunt, 4.0), blunt)


def test_a_corner_within_a_straight_side_is_none() -> None:
    true = np.array(SHAPES["square"], dtype=float)
    split = np.insert(true, 1, (true[0] + 2 * true[1]) / 3 + [0.0, 0.3], axis=0)
    np.testing.assert_array_equal(remove_straight_corners(split, 1.0), true)
    np.testing.assert_array_equal(remove_straight_corners(split, 0.1), split)


UP = np.array([0.0, 0.0, 1.0])


def finder(rig: Rig, segments: FloatArray) -> RegionFinder:
    levels = GreyLevels(rig.views, rig.maps)
    return RegionFinder(rig.views, levels, np.ones(len(rig.views)), segments, None, rig.pixel)


def plane_of(rig: Rig, lines: FloatArray) -> PlaneHypothesis:
    top, normal = rig.top
    return PlaneHypothesis(normal, float(normal @ top[0]), np.arange(len(lines)))


def overlap(one: FloatArray, other: FloatArray, normal: FloatArray) -> float:
    a, b = (shapely.Polygon(c @ plane_basis(normal)).buffer(0) for c in (one, other))
    return float(a.intersection(b).area / a.union(b).area)


def best(rig: Rig, lines: FloatArray) -> float:
    top, normal = rig.top
    found = finder(rig, lines).outlines(plane_of(rig, lines), lines, 1.0, rig.untaken)
    return max((overlap(corners, top, normal) for corners, _ in found), default=0.0)


def test_a_face_between_its_lines_is_a_region_with_their_corners() -> None:
    rig = block_rig()
    assert best(rig, sides(rig.top[0])) > 0.99


@pytest.mark.parametrize("kept", [[0], [0, 1], [1, 2, 3]])
def test_a_face_of_which_few_lines_are_known_is_a_region_all_the_same(kept: list[int]) -> None:
    rig = block_rig()
    lines = sides(rig.top[0])[kept]
    # One side tells nothing of how far the plane goes on across it.
    assert best(rig, lines) > (0.9 if len(kept) > 1 else 0.0)


def test_no_view_looks_at_a_plane_from_below_the_floor() -> None:
    rig = block_rig()
    lines = sides(rig.top[0]) - 20.0 * UP
    plane = PlaneHypothesis(UP, float(lines[0, 0, 2]), np.arange(4))
    assert not list(finder(rig, lines).outlines(plane, lines, -1.0, rig.untaken))
