"""Faces found by texture alone."""

from dataclasses import replace
from functools import partial

import numpy as np

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.evidence.texture_correlation import (
    find_surface_between,
)
from facetlog.perception.detection.line_front_end.faces_without_edges import texture_faces
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.texture_planes import (
    TexturePlane,
    keep_shown_patches,
    texture_planes,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.surfaces.reconstruct import reconstruct
from tests.perception.detection.line_front_end.printed_disc import (
    RADIUS,
    PrintedRig,
    printed_rig,
    rig_of,
    ring,
    true_height,
)


def patches_of(rig: PrintedRig) -> tuple[TexturePlane, ...]:
    surface = partial(find_surface_between, rig.photos, rig.views, rig.pixel)
    return keep_shown_patches(texture_planes(rig.texture, rig.pixel), rig.texture, surface)


def found(
    rig: PrintedRig,
    faces: tuple[SelectedFace, ...] = (),
    ground: Ground | None = None,
    *,
    taken: bool = False,
) -> tuple[SelectedFace, ...]:
    pixels = [np.full(v.image.shape, int(taken), np.uint8) for v in rig.views]
    cloud = LineCloud(
        np.zeros((0, 2, 3)), np.zeros((0, 2, 3, 3)), np.zeros(0), np.zeros(0), rig.pixel
    )
    return texture_faces(
        patches_of(rig), rig.texture, faces, rig.views, rig.photos, pixels, ground, cloud
    )


def test_texture_without_any_straight_edge_is_a_face_as_far_as_it_goes() -> None:
    (face,) = found(printed_rig())
    assert face.normal[2] > 0.9999
    assert true_height(face.corners).max() < 2 * printed_rig().pixel
    reach = np.linalg.norm(face.corners[:, :2], axis=1)
    assert 0.5 * RADIUS < reach.min() < reach.max() < 1.1 * RADIUS
    assert not face.has_edges
    assert face.shown.all()


def test_what_was_found_is_not_found_again() -> None:
    rig = printed_rig()
    (face,) = found(rig)
    assert found(rig, (replace(face, has_edges=True),)) == ()


def test_pictures_of_different_textures_show_no_face() -> None:
    assert found(rig_of(ring(6, 60.0), range(6))) == ()


def test_a_scene_has_the_face_of_print() -> None:
    scene = reconstruct(printed_rig().views, name="print")
    assert scene.faces
    corners = np.concatenate([scene.points[list(f.outline)] for f in scene.faces])
    assert true_height(corners).max() < 3 * printed_rig().pixel
