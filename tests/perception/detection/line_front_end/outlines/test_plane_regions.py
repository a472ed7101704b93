"""Regions of a plane on which the pictures agree."""

import numpy as np
import pytest
import shapely

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.outlines.plane_regions import RegionFinder
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

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


def lines_of(corners: FloatArray) -> FloatArray:
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def best(rig: Rig, lines: FloatArray) -> float:
    top, normal = rig.top
    found = finder(rig, lines).outlines(plane_of(rig, lines), lines, 1.0, rig.untaken)
    return max((overlap(corners, top, normal) for corners, _ in found), default=0.0)


def test_a_face_between_its_lines_is_a_region_with_their_corners() -> None:
    rig = block_rig()
    assert best(rig, lines_of(rig.top[0])) > 0.99


@pytest.mark.parametrize("kept", [[0], [0, 1], [1, 2, 3]])
def test_a_face_of_which_few_lines_are_known_is_a_region_all_the_same(kept: list[int]) -> None:
    rig = block_rig()
    lines = lines_of(rig.top[0])[kept]
    # One side tells nothing of how far the plane goes on across it.
    assert best(rig, lines) > (0.9 if len(kept) > 1 else 0.0)


def test_no_view_looks_at_a_plane_from_below_the_floor() -> None:
    rig = block_rig()
    lines = lines_of(rig.top[0]) - 20.0 * UP
    plane = PlaneHypothesis(UP, float(lines[0, 0, 2]), np.arange(4))
    assert not list(finder(rig, lines).outlines(plane, lines, -1.0, rig.untaken))
