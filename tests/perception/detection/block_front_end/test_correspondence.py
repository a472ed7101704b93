"""Vertices distinguished by their junctions, and paired by epipolar geometry."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.block_front_end.correspondence import (
    compute_epipolar_chi_square,
    compute_fundamental_matrix,
    track_vertices,
    triangulate_pairs,
)
from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.image_vertices import ImageVertex
from facetlog.perception.detection.block_front_end.position_labels import (
    LabelledVertex,
    draw_picture_lines,
    mark_junctions,
)
from facetlog.perception.line_drawing import Junction
from facetlog.perception.types import Camera, PositionLabel, View
from tests.drawn_scenes import looking

# Three corners in a row, joined: an arrow of lines 0 to 2, an L of 2 and 3, and a T on line 3.
ENDS = [((0, 0), (100, 100)), ((100, 0), (100, 100)), ((200, 0), (100, 100)), ((200, 0), (400, 0)),
        ((300, 0), (300, 90))]  # fmt: skip
LINES = tuple(EdgeLine(np.array(a, float), np.array(b, float), 1e-6 * np.eye(2), 50.0)
              for a, b in ENDS)  # fmt: skip


def vertex(u: float, v: float, *lines: int, label: PositionLabel | None = None) -> LabelledVertex:
    at = ImageVertex(np.array([u, v], dtype=float), 0.01 * np.eye(2), lines)
    return LabelledVertex(at, label, label, "front_?_top")


ARROW, BEND, TEE = vertex(100, 100, 0, 1, 2), vertex(200, 0, 2, 3), vertex(300, 0, 3, 4)


def test_edges_are_cut_at_their_vertices_and_end_in_points_of_their_own() -> None:
    drawing, edges = draw_picture_lines(tuple(v.vertex for v in (ARROW, BEND, TEE)), LINES)
    types = [rays.type for rays in drawing.rays if rays is not None]
    assert types == [Junction.ARROW, Junction.L, Junction.T, *[Junction.END] * 4]
    assert sorted(edges) == [0, 1, 2, 3, 3, 4]


def test_vertices_of_one_position_are_distinguished_by_their_junctions() -> None:
    marked = mark_junctions((ARROW, BEND, TEE), LINES, 1)
    assert [v.mark for v in marked] == [
        ("front_?_top@1", "arrow"),
        ("front_?_top@1", "l"),
        ("front_?_top@1", "t"),
    ]


def test_what_has_a_label_or_a_twin_or_an_unknown_side_has_no_mark() -> None:
    known = vertex(100, 100, 0, 1, 2, label=PositionLabel.FRONT_LEFT_TOP)
    # as BEND is, at the other end of lines 0 and 1
    twin = vertex(50, 50, 0)
    other = vertex(150, 50, 2)
    assert [v.mark for v in mark_junctions((known,), LINES, 0)] == [None]
    assert [v.mark for v in mark_junctions((twin, other), LINES, 0)] == [None, None]
    assert [v.mark for v in mark_junctions((ARROW,), LINES, None)] == [None]


CAMERA = Camera(320, 240, 400.0, 400.0, 159.5, 119.5)
POINT = np.array([0.1, -0.05, 0.2])


def sighted(turn: float, *marks: tuple[str, str] | None) -> tuple[View, list[LabelledVertex]]:
    """A view of the point, and the vertices that it might be, each with a mark."""
    centre = np.array([5 * np.cos(turn), 5 * np.sin(turn), 2.0])
    view = View("v", np.zeros((240, 320), np.uint8), CAMERA, looking(centre, np.zeros(3)))
    h = view.projection @ np.append(POINT, 1.0)
    found = [vertex(h[0] / h[2] + 40 * i, h[1] / h[2], 0) for i in range(len(marks))]
    return view, [replace(v, mark=mark) for v, mark in zip(found, marks, strict=True)]


@pytest.mark.parametrize(
    ("first", "second", "stands"),
    [
        (("front_?_top@0", "arrow"), ("front_?_top@0", "arrow"), True),
        (("front_?_top@0", "arrow"), ("front_?_top@0", "l"), False),
        (("front_?_top@0", "arrow"), ("front_?_top@1", "arrow"), False),
        (("front_?_top@0", "arrow"), None, False),
        (None, None, False),
    ],
)
def test_of_two_views_a_pair_of_one_mark_stands(
    first: tuple[str, str] | None, second: tuple[str, str] | None, stands: bool
) -> None:
    one, seen_by_one = sighted(0.0, first)
    two, seen_by_two = sighted(0.4, second)
    tracks = track_vertices((tuple(seen_by_one), tuple(seen_by_two)), (one, two))
    assert len(tracks) == stands
    assert all(track.label is None for track in tracks)


coordinate = st.floats(-3.0, 3.0)


def pixel(projection, point):
    x = projection @ np.append(point, 1.0)
    return x[:2] / x[2]


@settings(max_examples=40)
@given(st.tuples(coordinate, coordinate, st.floats(0.0, 6.0)), st.integers(1, 7))
def test_a_projected_point_comes_back(tour, point, other):
    first, second = tour.views[0].projection, tour.views[other].projection
    uv1, uv2 = pixel(first, point), pixel(second, point)
    back = triangulate_pairs(first, second, uv1[None], uv2[None])[0]
    assert np.allclose(back, point, atol=1e-3)


def test_corresponding_pixels_lie_on_each_others_epipolar_lines(tour):
    first, second = tour.views[0].projection, tour.views[2].projection
    points = tour.corners
    uv1 = np.array([pixel(first, p) for p in points])
    uv2 = np.array([pixel(second, p) for p in points])
    covs = np.tile(0.01 * np.eye(2), (8, 1, 1))
    off = compute_epipolar_chi_square(
        compute_fundamental_matrix(first, second), uv1, covs, uv2, covs
    )
    assert np.diag(off).max() < 1e-6
    assert np.median(off[~np.eye(8, dtype=bool)]) > 100


def test_the_epipolar_chi_square_has_one_degree_of_freedom(tour):
    rng = np.random.default_rng(0)
    first, second = tour.views[0].projection, tour.views[2].projection
    uv1 = np.tile(pixel(first, tour.corners[6]), (4000, 1)) + rng.normal(0, 0.3, (4000, 2))
    uv2 = pixel(second, tour.corners[6])[None] + rng.normal(0, 0.3, (1, 2)) * 0
    off = compute_epipolar_chi_square(
        compute_fundamental_matrix(first, second),
        uv1,
        np.tile(0.09 * np.eye(2), (4000, 1, 1)),
        uv2,
        np.zeros((1, 2, 2)),
    )
    assert off.mean() == pytest.approx(1.0, abs=0.1)
