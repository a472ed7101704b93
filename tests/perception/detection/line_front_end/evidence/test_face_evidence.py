"""What the views say of an outline: its inside, its sides, and the ground behind it."""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.evidence.face_evidence import (
    FaceEvidence,
    FaceJudge,
    inner_points,
)
from facetlog.perception.detection.line_front_end.evidence.joined_sides import (
    joined_sides,
    on_segments,
)
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.line_front_end.selected_face import SelectedFace
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

UP = np.array([0.0, 0.0, 1.0])


def judge(rig: Rig, maps: Sequence[EdgeMap] | None = None) -> FaceJudge:
    weight = np.ones(len(rig.views))
    sides = SideJudge(rig.views, maps or rig.maps, weight)
    centres = np.array([v.pose.centre for v in rig.views])
    ground = Ground(UP, 0.0, 4 * rig.pixel, centres, 30.0)
    photos = PhotometricViews(rig.views, GreyLevels(rig.views, rig.maps), weight)
    return FaceJudge(photos, sides, ground)


def without_edge(rig: Rig, side: FloatArray) -> list[EdgeMap]:
    """The views' edges but for those along a side (2, 3)."""
    maps = []
    for view, edges in zip(rig.views, rig.maps, strict=True):
        uv, _ = project_points(view.projection, side)
        a, b = np.rint(uv).astype(int).tolist()
        along = cv2.line(np.zeros(view.image.shape, np.uint8), a, b, 1, 25)
        maps.append(replace(edges, mask=np.where(along > 0, 0, edges.mask).astype(np.uint16)))
    return maps


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


def test_one_side_too_faint_for_any_view_costs_a_fixed_price_and_no_more() -> None:
    rig = block_rig()
    top, normal = rig.top
    right = judge(rig).judge(top, normal, rig.untaken)
    faint = judge(rig, without_edge(rig, top[:2])).judge(top, normal, rig.untaken)
    assert right is not None
    assert faint is not None
    assert 0.5 * right.sides < faint.sides < right.sides
    assert faint.coverage < 0.8


def test_a_faint_side_that_a_found_face_has_too_costs_nothing_and_one_in_the_air_does() -> None:
    rig = block_rig()
    top, normal = rig.top
    maps = without_edge(rig, top[:2])
    side = SelectedFace(
        np.array([top[1], top[0], top[0] - 6.0 * UP, top[1] - 6.0 * UP]),
        np.cross(UP, top[1] - top[0]) / np.linalg.norm(top[1] - top[0]),
        np.ones(len(rig.views), np.bool_),
        1.0,
        top[:1],
    )

    def joins(points: FloatArray, across: FloatArray) -> NDArray[np.bool_]:
        return on_segments(points, joined_sides(across, [side]), 3 * rig.pixel)

    faint = judge(rig, maps).judge(top, normal, rig.untaken)
    known = judge(rig, maps).judge(top, normal, rig.untaken, joins=joins)
    assert faint is not None
    assert known is not None
    assert known.coverage > faint.coverage + 0.05
    assert known.sides > faint.sides
    # where the edge is found, a face beside it changes nothing
    seen = judge(rig).judge(top, normal, rig.untaken)
    same = judge(rig).judge(top, normal, rig.untaken, joins=joins)
    assert seen is not None
    assert same is not None
    assert same.sides >= seen.sides


def test_the_sides_of_a_parallel_face_are_not_joined() -> None:
    top, normal = block_rig().top
    below = SelectedFace(top, -normal, np.ones(1, np.bool_), 1.0, top[:1])
    assert joined_sides(normal, [below]).shape == (0, 2, 3)
    assert joined_sides(normal, []).shape == (0, 2, 3)
    assert not on_segments(top, np.zeros((0, 2, 3)), 1.0).any()


def test_a_missing_side_within_a_surface_is_no_faint_one() -> None:
    # Half of the top: its fourth side runs where the same surface goes on.
    rig = block_rig()
    top, normal = rig.top
    half = np.array([top[0], top[1], (top[1] + top[2]) / 2, (top[0] + top[3]) / 2])
    whole = judge(rig).judge(top, normal, rig.untaken)
    found = judge(rig).judge(half, normal, rig.untaken)
    assert whole is not None
    assert found is None or found.sides < 0.5 * whole.sides


def test_what_hides_a_part_of_a_side_says_nothing_against_it() -> None:
    # A post, painted into every picture before the middle of one side of the top.
    rig = block_rig()
    top, normal = rig.top
    middle = (top[0] + top[1]) / 2
    views = []
    for view in rig.views:
        at, _ = project_points(view.projection, middle)
        image = view.image.copy()
        image[:, round(at[0]) - 14 : round(at[0]) + 14] = 100
        views.append(replace(view, image=image))
    hidden = Rig(rig.solid, tuple(views))
    found = judge(hidden).judge(top, normal, rig.untaken)
    assert found is not None
    assert found.coverage > 0.85
    assert found.sides > 50


def test_pixels_that_show_a_face_say_nothing_of_another() -> None:
    rig = block_rig()
    top, normal = rig.top
    taken = [np.ones(v.image.shape, np.uint8) for v in rig.views]
    assert judge(rig).judge(top, normal, taken) is None


def test_an_outline_too_small_for_points_is_none() -> None:
    rig = block_rig()
    top, normal = rig.top
    assert judge(rig).judge(np.repeat(top[:1], 4, axis=0), normal, rig.untaken) is None
    assert inner_points(np.repeat(top[:1], 4, axis=0), normal).shape == (0, 3)


def tiled(rig: Rig) -> Rig:
    """The same views of a floor alone, its tiles each of another grey."""
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


def faint(rig: Rig, share: float) -> Rig:
    """The same views with so much of their contrast, and noise of 5 grey levels."""
    rng = np.random.default_rng(0)
    views = []
    for view in rig.views:
        grey = 128.0 + share * (view.image - 128.0) + rng.normal(0.0, 5.0, view.image.shape)
        views.append(replace(view, image=np.clip(np.rint(grey), 0, 255).astype(np.uint8)))
    return Rig(rig.solid, tuple(views))


def test_no_side_of_a_faint_block_shows_the_ground() -> None:
    rig = faint(block_rig(), 0.25)
    assert shown_and_ground(rig) == (5, 0)


def shown_and_ground(rig: Rig) -> tuple[int, int]:
    """How many true faces the views show, and how many of these are said to show the ground."""
    judged = judge(rig)
    faces = [rig.outward(loop) for loop in rig.solid.faces]
    found = [(face, judged.judge(*face, rig.untaken)) for face in faces]
    shown = [(face, evidence) for face, evidence in found if evidence is not None]
    ground = [judged.shows_ground(*face, evidence, rig.untaken) for face, evidence in shown]
    return len(shown), sum(ground)


def test_faces_that_all_views_see_from_one_side_are_no_ground() -> None:
    # Where the ground would be, all of them show the face.
    assert shown_and_ground(block_rig(45.0)) == (2, 0)


def test_a_low_patch_that_only_near_views_show_is_the_ground_as_well() -> None:
    # Views so near to each other see face and ground in one place alike; others see past it.
    rig = tiled(block_rig())
    patch = np.array([[-1.0, -1, 0.5], [1, -1, 0.5], [1, 1, 0.5], [-1, 1, 0.5]])
    points, shown = inner_points(patch, UP), np.zeros(len(rig.views), np.bool_)
    shown[:2] = True
    weak = FaceEvidence(np.full(len(points), 3.0), 1.0, 69.0, 0.8, shown, 1.0, points)
    assert judge(rig).shows_ground(patch, UP, weak, rig.untaken)


def test_a_broad_patch_just_above_the_floor_is_the_ground_though_no_view_sees_past_it() -> None:
    rig = tiled(block_rig())
    patch = np.array([[-4.0, -4, 0.2], [4, -4, 0.2], [4, 4, 0.2], [-4, 4, 0.2]])
    points, shown = inner_points(patch, UP), np.ones(len(rig.views), np.bool_)
    weak = FaceEvidence(np.full(len(points), 4.0), 1.0, 69.0, 0.8, shown, 1.0, points)
    assert judge(rig).shows_ground(patch, UP, weak, rig.untaken)


@pytest.mark.parametrize("scale", [0.2, 1.0, 30.0])
def test_points_of_an_inside_are_spread_over_all_of_it(scale: float) -> None:
    ell = np.array([[0.0, 0, 1], [2, 0, 1], [2, 0.4, 1], [0.4, 0.4, 1], [0.4, 2, 1], [0, 2, 1]])
    points = inner_points(scale * ell, UP) / scale
    assert 40 <= len(points) <= 90
    np.testing.assert_allclose(points[:, 2], 1.0)
    assert ((points[:, 0] < 0.4) | (points[:, 1] < 0.4)).all()
    assert points[:, 0].max() > 1.7
    assert points[:, 1].max() > 1.7
