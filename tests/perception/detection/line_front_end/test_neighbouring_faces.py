"""Faces proposed beside found ones, where too few views see a face to compare."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.evidence.face_evidence import inner_points
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.faces_without_edges import neighbouring_faces
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.scene import Evidence
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.robot.rendering.worlds import make_world
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig
from tests.rendered import get_solid_truth, tour

UP = np.array([0.0, 0.0, 1.0])


def only(rig: Rig, views: Sequence[int]) -> Rig:
    return Rig(rig.solid, tuple(rig.views[k] for k in views))


def found(rig: Rig, faces: Sequence[int]) -> tuple[SelectedFace, ...]:
    """The true faces, as if they had been selected."""
    selected = []
    for n in faces:
        corners, normal = rig.outward(rig.solid.faces[n])
        shown = rig.shown_faces[n].astype(np.bool_)
        points = inner_points(corners, normal)
        selected.append(SelectedFace(corners, normal, shown, 1.0, points, np.full(4, 0.01)))
    return tuple(selected)


def proposed(
    rig: Rig, faces: Sequence[int], ground: Ground | None = None
) -> tuple[SelectedFace, ...]:
    weight = np.ones(len(rig.views))
    photos = PhotometricViews(rig.views, GreyLevels(rig.views, rig.maps), weight)
    judge = SideJudge(rig.views, rig.maps, weight)
    return neighbouring_faces(found(rig, faces), photos, judge, rig.untaken, ground, rig.pixel)


def sides_of(rig: Rig) -> tuple[int, list[int]]:
    """The number of the top, and those of the upright faces in their order round the block."""
    normals = [rig.outward(face)[1] for face in rig.solid.faces]
    top = int(np.argmax([n[2] for n in normals]))
    upright = [k for k, n in enumerate(normals) if abs(n[2]) < 0.5]
    return top, sorted(upright, key=lambda k: float(np.arctan2(normals[k][1], normals[k][0])))


def is_face(rig: Rig, number: int, face: SelectedFace) -> bool:
    corners, normal = rig.outward(rig.solid.faces[number])
    apart = np.linalg.norm(face.corners[:, None] - corners, axis=-1).min(axis=1)
    return bool(apart.max() < 0.01 and face.normal @ normal > 0.999)


def one_view_of(rig: Rig, number: int) -> int:
    """The view that sees a face most from the front."""
    corners, normal = rig.outward(rig.solid.faces[number])
    rays = np.array([v.pose.centre for v in rig.views]) - corners.mean(axis=0)
    return int(np.argmax(rays @ normal / np.linalg.norm(rays, axis=1)))


def test_a_side_that_one_view_shows_is_a_face_by_its_edges() -> None:
    rig = block_rig()
    top, (front, side, *_) = sides_of(rig)
    lone = only(rig, [one_view_of(rig, side)])
    faces = [f for f in proposed(lone, [top, front]) if is_face(rig, side, f)]
    assert len(faces) == 1
    assert faces[0].shown.tolist() == [True]
    assert faces[0].support > 0.9
    assert faces[0].plane_cov is None


def test_what_is_bounded_above_may_stand_on_the_ground() -> None:
    rig = block_rig()
    top, (front, *_) = sides_of(rig)
    lone = only(rig, [one_view_of(rig, front)])
    centres = np.array([v.pose.centre for v in lone.views])
    ground = Ground(UP, 0.0, 0.1, centres, 26.0)
    assert any(is_face(rig, front, f) for f in proposed(lone, [top], ground))
    high = replace(ground, height=-2.0)
    assert proposed(lone, [top], high) == ()


def test_three_sides_imply_the_fourth_that_is_hidden() -> None:
    rig = block_rig()
    top, (front, side, back, other) = sides_of(rig)
    view = only(rig, [one_view_of(rig, back)])
    weight = np.ones(1)
    photos = PhotometricViews(view.views, GreyLevels(view.views, view.maps), weight)
    judge = SideJudge(view.views, view.maps, weight)
    hidden = [np.ones_like(pixels) for pixels in view.untaken]
    faces = found(view, [top, front, side, other])
    (implied,) = neighbouring_faces(faces, photos, judge, hidden, None, rig.pixel)
    assert is_face(rig, back, implied)
    assert not implied.shown.any()
    assert neighbouring_faces(faces[:2], photos, judge, hidden, None, rig.pixel) == ()


@pytest.mark.slow
def test_a_block_in_four_views_has_its_five_faces() -> None:
    views = tour("block", 0)[::6]
    scene = reconstruct(views, name="four", up=UP)
    assert [f.evidence for f in scene.faces] == [Evidence.MEASURED] * 5
    true = np.array(get_solid_truth(make_world("block", 0)).vertices)
    away = np.linalg.norm(scene.points[:, None] - true, axis=-1).min(axis=1)
    assert away.max() < 0.2
