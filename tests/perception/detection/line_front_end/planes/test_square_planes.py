"""Normals that are square to what is known, and outlines brought onto such planes."""

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.detection.line_front_end.planes.square_planes import (
    seen_on_plane,
    square_normals,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.ideal_lines import exact_ends

UP, EAST, NORTH = np.eye(3)[[2, 0, 1]]


def tilted(normal: FloatArray, towards: FloatArray, degrees: float) -> FloatArray:
    angle = np.radians(degrees)
    return np.asarray(np.cos(angle) * normal + np.sin(angle) * towards)


def test_an_almost_upright_normal_becomes_upright_and_keeps_its_direction() -> None:
    (found,) = square_normals(tilted(tilted(EAST, NORTH, 30.0), UP, 8.0), [UP])
    np.testing.assert_allclose(found, tilted(EAST, NORTH, 30.0), atol=1e-12)


def test_what_two_known_faces_bind_comes_first() -> None:
    near = tilted(tilted(-EAST, UP, 5.0), NORTH, 5.0)
    both, one = square_normals(near, [UP, NORTH])
    np.testing.assert_allclose(both, -EAST, atol=1e-12)
    assert one @ UP == pytest.approx(0.0)
    assert one @ NORTH > 0.05


def test_an_outline_looks_the_same_on_the_turned_plane_through_its_lines() -> None:
    leaning = tilted(EAST, UP, 6.0)
    segments = np.array([[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]])
    cloud = LineCloud(segments, exact_ends(segments), np.ones(1), np.zeros(1), 0.01)
    plane = PlaneHypothesis(leaning, 0.0, np.array([0]))
    high = np.array([-np.sin(np.radians(6.0)), 0.0, np.cos(np.radians(6.0))])
    ring = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], high + NORTH, high - NORTH])
    centre = np.array([5.0, 0.0, 2.0])
    found = seen_on_plane(ring, plane, EAST, cloud, centre)
    np.testing.assert_allclose(found[:, 0], 0.0, atol=1e-9)
    before, after = ring - centre, found - centre
    np.testing.assert_allclose(np.cross(before, after), 0.0, atol=1e-9)
    free = PlaneHypothesis(leaning, 0.0, np.zeros(0, dtype=np.intp))
    middle = ring.mean(axis=0)
    np.testing.assert_allclose(
        seen_on_plane(ring, free, EAST, cloud, centre) @ EAST, middle @ EAST, atol=1e-9
    )
