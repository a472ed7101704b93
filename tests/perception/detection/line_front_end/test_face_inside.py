"""Whether the inside of an outline is surface, by all the views that face it."""

from collections.abc import Sequence

import numpy as np
import shapely

from facetlog.perception.detection.line_front_end.face_inside import (
    INNER_POINTS,
    InsideJudge,
    inner_points,
)
from facetlog.perception.detection.line_front_end.plane_hypotheses import plane_basis
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig


def judge(rig: Rig) -> InsideJudge:
    return InsideJudge(rig.views, rig.maps, np.ones(len(rig.views)))


def outward(rig: Rig, loop: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Corners (k, 3) of a true face and its outward normal."""
    corners = rig.points[list(loop)]
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    return corners, normal / np.linalg.norm(normal)


def test_faces_that_views_see_are_surface_all_over() -> None:
    rig = block_rig()
    for loop, shown in zip(rig.solid.faces, rig.shown_faces, strict=True):
        share = judge(rig).surface_share(*outward(rig, loop))
        assert share > 0.95 if shown.sum() >= 3 else share == 0.0


def test_what_views_see_through_is_not() -> None:
    rig = block_rig()
    top, normal = outward(rig, max(rig.solid.faces, key=lambda f: rig.points[list(f), 2].mean()))
    middle = top.mean(axis=0)
    # A lid held over the block, half as large again: the floor and the block are seen through it.
    lid = middle + 1.5 * (top - middle) + np.array([0.0, 0.0, 3.0])
    assert judge(rig).surface_share(lid, normal) < 0.5


def test_an_outline_beyond_the_true_border_is_surface_in_part() -> None:
    rig = block_rig()
    top, normal = outward(rig, max(rig.solid.faces, key=lambda f: rig.points[list(f), 2].mean()))
    a, b, c, d = top
    twice = np.array([a, b + (b - a), c + (c - d), d])
    assert 0.3 < judge(rig).surface_share(twice, normal) < 0.75


def test_no_view_and_no_area_are_no_surface() -> None:
    rig = block_rig()
    top, normal = outward(rig, max(rig.solid.faces, key=lambda f: rig.points[list(f), 2].mean()))
    assert judge(rig).surface_share(top[::-1], -normal) == 0.0
    assert judge(rig).surface_share(np.repeat(top[:1], 4, axis=0), normal) == 0.0


def test_points_lie_inside_flat_and_thin_and_hollow_outlines() -> None:
    normal = np.array([0.0, 0.6, 0.8])
    basis = plane_basis(normal)
    for flat in (
        [[0, 0], [4, 0], [4, 3], [0, 3]],
        [[0, 0], [100, 0], [100, 1], [0, 1]],
        [[0, 0], [9, 0], [9, 9], [8, 9], [8, 1], [0, 1]],
    ):
        corners = np.array(flat, dtype=float) @ basis.T + 2.0 * normal
        points = inner_points(corners, normal)
        assert 8 <= len(points) <= INNER_POINTS
        np.testing.assert_allclose(points @ normal, 2.0)
        assert shapely.contains_xy(shapely.Polygon(flat), points @ basis).all()
