"""Polygons cut into triangles that cover them once, whichever corner they begin with."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.reading.shape_files.meshes.polygons import triangulate, triangulate_rings
from facetlog.perception.types import FloatArray

U_SHAPE = [(0, 0), (5, 0), (5, 4), (4, 4), (4, 1), (1, 1), (1, 4), (0, 4)]
L_SHAPE = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
ARROW = [(0, 0), (2, 1), (0, 2), (0.5, 1)]
STAR = [
    (r * np.cos(t), r * np.sin(t))
    for r, t in zip((1.0, 0.3) * 5, np.linspace(0, 2 * np.pi, 11)[:-1], strict=True)
]
MIDPOINTS = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
ONE_MIDPOINT = [(0, 0), (1, 0), (2, 0), (0, 2)]
REPEATED = [(0, 0), (3, 0), (3, 0), (3, 1), (1, 1), (1, 1), (1, 3), (0, 3), (0, 0)]
SPIKE = [(0, 0), (2, 0), (4, 0), (2, 0), (2, 2), (0, 2)]
# a hole joined to the outline by a bridge that is there twice
KEYHOLE = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
SHAPES = {
    "u": (U_SHAPE, 11.0),
    "l": (L_SHAPE, 5.0),
    "arrow": (ARROW, 1.5),
    "star": (STAR, 5 * 0.3 * np.sin(np.pi / 5)),
    "midpoints": (MIDPOINTS, 4.0),
    "one midpoint": (ONE_MIDPOINT, 2.0),
    "repeated": (REPEATED, 5.0),
    "spike": (SPIKE, 4.0),
    "keyhole": (KEYHOLE, 12.0),
}


def in_space(flat: list[tuple[float, float]], seed: int) -> FloatArray:
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    return np.column_stack((np.array(flat, dtype=float), np.zeros(len(flat)))) @ turn.T + [7, -3, 1]


def area_vectors(points: FloatArray, triangles: np.ndarray) -> FloatArray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * np.cross(b - a, c - a))


def newell(points: FloatArray) -> FloatArray:
    return np.asarray(0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0))


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("turned_over", [False, True])
def test_triangles_cover_a_polygon_once_from_any_corner(shape: str, *, turned_over: bool) -> None:
    flat, area = SHAPES[shape]
    flat = flat[::-1] if turned_over else flat
    for first in range(len(flat)):
        points = in_space(flat[first:] + flat[:first], first)
        cut = triangulate(points, np.arange(len(flat)), np.array([len(flat)]))
        vectors = area_vectors(points, cut.triangles)
        # all face as the polygon does, and none lies over another
        assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(area)
        assert vectors.sum(axis=0) == pytest.approx(newell(points), abs=1e-9)
        assert cut.warnings == ()


def test_triangles_of_a_bent_polygon_do_not_depend_on_its_first_corner() -> None:
    rng = np.random.default_rng(1)
    for flat in (U_SHAPE, L_SHAPE, ARROW, STAR, [(0, 0), (3, 0), (2, 2), (0, 1)]):
        points = in_space(flat, 5) + rng.normal(scale=0.02, size=(len(flat), 3))
        found = set()
        for first in range(len(flat)):
            order = np.roll(np.arange(len(flat)), first)
            cut = triangulate(points, order, np.array([len(flat)]))
            found.add(frozenset(frozenset(row) for row in cut.triangles.tolist()))
        assert len(found) == 1


def test_polygons_of_all_sizes_keep_their_order() -> None:
    points = np.concatenate([in_space(flat, k) for k, (flat, _) in enumerate(SHAPES.values())])
    sizes = np.array([len(flat) for flat, _ in SHAPES.values()])
    cut = triangulate(points, np.arange(len(points)), sizes)
    owner = np.repeat(np.arange(len(sizes)), sizes)[cut.triangles[:, 0]]
    assert (np.diff(owner) >= 0).all()
    areas = np.linalg.norm(area_vectors(points, cut.triangles), axis=1)
    assert np.bincount(owner, areas) == pytest.approx([area for _, area in SHAPES.values()])


def test_holes_stay_open() -> None:
    outline, hole = [(0, 0), (4, 0), (4, 3), (0, 3)], [(1, 1), (2, 1), (2, 2), (1, 2)]
    for turned_over in (False, True):
        points = in_space(outline + (hole[::-1] if turned_over else hole), 2)
        cut = triangulate_rings(points, [np.arange(4), np.arange(4, 8)])
        vectors = area_vectors(points, cut.triangles)
        assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(11.0)
        assert vectors.sum(axis=0) == pytest.approx(newell(points[:4]) * 11 / 12)
        assert cut.warnings == ()


def test_faces_that_are_none_are_counted() -> None:
    points = np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0), (2, 2, 0)], dtype=float)
    cut = triangulate(points, np.array([0, 1, 0, 1, 2, 3, 0, 1, 2]), np.array([2, 4, 3]))
    assert (cut.narrow, cut.crossing) == (1, 1)
    assert len(cut.warnings) == 2
    missing = triangulate(points, np.array([0, 1, 9, 2]), np.array([4]))
    assert (missing.triangles == -1).all()


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_star_shaped_polygons_of_any_number_of_corners(data: st.DataObject) -> None:
    count = data.draw(st.integers(4, 12))
    radii = data.draw(st.lists(st.floats(0.2, 3.0), min_size=count, max_size=count))
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    points = in_space(
        [(r * np.cos(t), r * np.sin(t)) for r, t in zip(radii, angles, strict=True)], count
    )
    cut = triangulate(points, np.arange(count), np.array([count]))
    areas = np.linalg.norm(area_vectors(points, cut.triangles), axis=1)
    assert areas.sum() == pytest.approx(np.linalg.norm(newell(points)))
    assert len(cut.triangles) == count - 2
