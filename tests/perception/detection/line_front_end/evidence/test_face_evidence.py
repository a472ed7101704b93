"""Evidence of the views for an outline, and faces that cannot both be."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    back_to_back,
    blocked,
    overlap,
)
from facetlog.perception.detection.line_front_end.evidence.face_evidence import (
    FaceEvidence,
    FaceJudge,
    inner_points,
)
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

UP = np.array([0.0, 0.0, 1.0])


def judge(rig: Rig, maps: Sequence[EdgeMap] | None = None) -> FaceJudge:
    weight = np.ones(len(rig.views))
    sides = SideJudge(rig.views, maps or rig.maps, weight)
    centres = np.array([v.pose.centre for v in rig.views])
    ground = Ground(UP, 0.0, 4 * rig.pixel, centres, 30.0)
    photos = PhotometricViews(rig.views, GreyLevels(rig.views, rig.maps), weight)
    return FaceJudge(photos, sides, ground)


def test_nothing_in_the_air_and_nothing_inside_is_a_face() -> None:
    rig = block_rig()
    top, normal = rig.top
    judged = judge(rig)
    assert judged.judge(top, normal, rig.untaken) is not None
    above = judged.judge(top + 4.0 * UP, normal, rig.untaken)
    assert above is None or above.sides < 0
    assert judged.judge(top[::-1], -normal, rig.untaken) is None


def test_sides_on_edges_speak_for_an_outline_and_sides_beside_them_against_it() -> None:
    rig = block_rig()
    top, normal = rig.top
    right = judge(rig).judge(top, normal, rig.untaken)
    middle = top.mean(axis=0)
    smaller = judge(rig).judge(middle + 0.7 * (top - middle), normal, rig.untaken)
    assert right is not None
    assert right.sides > 100
    assert smaller is None or smaller.sides < 0
    assert right.coverage > 0.9


def tiled(rig: Rig) -> Rig:
    """Return the views of a floor alone, its tiles each of another grey."""
    greys = np.random.default_rng(0).integers(40, 220, (40, 40))
    views = []
    for view in rig.views:
        height, width = view.image.shape
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(view.projection[:, :3]).T
        far = -view.pose.centre[2] / np.minimum(rays[..., 2], -1e-6)
        at = view.pose.centre + far[..., None] * rays
        tile = np.clip(np.floor(at[..., :2] / 2.0) + 20, 0, 39).astype(int)
        views.append(replace(view, image=greys[tile[..., 0], tile[..., 1]].astype(np.uint8)))
    return Rig(rig.solid, tuple(views))


def test_a_patch_that_shows_the_floor_behind_it_is_the_ground_and_a_face_is_not() -> None:
    rig = block_rig()
    top, normal = rig.top
    found = judge(rig).judge(top, normal, rig.untaken)
    assert found is not None
    assert not judge(rig).shows_ground(top, normal, found, rig.untaken)
    weak = replace(found, ratio=np.full(len(found.points), 6.0))
    assert judge(tiled(rig)).shows_ground(top, normal, weak, rig.untaken)


def test_a_broad_patch_just_above_the_floor_is_the_ground_though_no_view_sees_past_it() -> None:
    rig = tiled(block_rig())
    patch = np.array([[-4.0, -4, 0.2], [4, -4, 0.2], [4, 4, 0.2], [-4, 4, 0.2]])
    points, shown = inner_points(patch, UP), np.ones(len(rig.views), np.bool_)
    weak = FaceEvidence(np.full(len(points), 4.0), 1.0, 69.0, 0.8, shown, 1.0, points)
    assert judge(rig).shows_ground(patch, UP, weak, rig.untaken)


UP = np.array([0.0, 0.0, 1.0])
SQUARE = np.array([[0.0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]])


def test_a_face_hides_what_lies_behind_it_and_not_its_own_plane() -> None:
    centres = np.array([[5.0, 5.0, 30.0]])
    inside = SQUARE.mean(axis=0, keepdims=True)
    assert blocked(SQUARE, UP, inside - 3.0 * UP, centres, 0.1).all()
    assert not blocked(SQUARE, UP, inside, centres, 0.1).any()
    assert not blocked(SQUARE, UP, inside + 3.0 * UP, centres, 0.1).any()


@pytest.mark.parametrize(
    ("move", "both"),
    [([0, 0, 0], False), ([9.5, 0, 0], True), ([5, 0, 0], False), ([5, 0, 2], True)],
)
def test_two_faces_share_no_part_of_one_plane(move: list[float], both: bool) -> None:
    other = SQUARE + np.array(move, dtype=float)
    assert overlap(other, UP, SQUARE, UP, 1.0) is not both


def test_a_small_face_on_a_large_one_is_an_overlap_and_a_steep_one_is_none() -> None:
    small = 0.2 * SQUARE + np.array([4.0, 4.0, 0.0])
    assert overlap(small, UP, SQUARE, UP, 1.0)
    steep = small[:, [2, 1, 0]] + np.array([5.0, 0.0, 0.0])
    assert not overlap(steep, np.array([1.0, 0.0, 0.0]), SQUARE, UP, 1.0)


@pytest.mark.parametrize(("above", "both"), [(-0.9, True), (0.0, True), (0.9, False)])
def test_of_the_two_sides_of_a_board_neither_is_before_the_other(above: float, both: bool) -> None:
    lower = SQUARE[::-1] + above * UP
    assert overlap(lower, -UP, SQUARE, UP, 1.0)
    assert back_to_back(lower, -UP, SQUARE, UP, 0.3) is both
    assert back_to_back(SQUARE, UP, lower, -UP, 0.3) is both
    assert not back_to_back(lower[::-1], UP, SQUARE, UP, 0.3)
