"""Boards between the sides of shelves, of which pictures show little but a front rim."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.evidence.face_evidence import inner_points
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.with_boards import with_boards
from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.furniture import bench, shelf
from facetlog.robot.rendering.solids import cuboid, placed
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import Floor, Solid, World
from facetlog.robot.tour import make_ring_poses
from tests.perception.detection.line_front_end.block_rig import CAMERA, DISTANCE, Rig
from tests.rendered import get_solid_truth

UP = np.array([0.0, 0.0, 1.0])
YAW = 0.4
WIDTH, DEPTH, HEIGHT, THICKNESS = 10.0, 5.0, 9.0, 0.4


@cache
def rig_of(name: str) -> Rig:
    """A white thing on a dark floor, lit from one side, from a ring of clean pictures."""
    solids: dict[str, Solid] = {
        "shelf": shelf(WIDTH, DEPTH, HEIGHT, boards=3, thickness=THICKNESS, back=True),
        "bench": bench(WIDTH, DEPTH, HEIGHT, thickness=THICKNESS, support=THICKNESS, panels=True),
        "block": cuboid(WIDTH, DEPTH, HEIGHT),
    }
    world = World(
        (placed(solids[name], 0.0, 0.0, yaw=YAW),),
        Floor(0.15),
        np.array([1.0, -0.6, 2.0]),
        ambient=0.5,
        sided=0.3,
        exposure=0.9,
    )
    poses = make_ring_poses([0.0, 0.0, HEIGHT / 2], DISTANCE, (14.0, 20.0), 12)
    return Rig(get_solid_truth(world), views_of(world, poses, CAMERA, noise_sd=0.0, blur_px=1.0))


def panel(centre: FloatArray, along: FloatArray, up: FloatArray, rig: Rig) -> SelectedFace:
    """A found face, seen from where its normal points, along × up."""
    ring = centre + np.array([-along - up, along - up, along + up, up - along])
    turn = np.array([[np.cos(YAW), -np.sin(YAW), 0], [np.sin(YAW), np.cos(YAW), 0], [0, 0, 1]])
    normal = turn @ (np.cross(along, up) / np.linalg.norm(np.cross(along, up)))
    corners = ring @ turn.T
    shown = np.array([(v.pose.centre - corners[0]) @ normal > 0 for v in rig.views])
    return SelectedFace(corners, normal, shown, 1.0, inner_points(corners, normal))


def outside(rig: Rig, *names: str) -> tuple[SelectedFace, ...]:
    """Faces of the box round the thing, as if they had been found."""
    x, y, z = np.diag([WIDTH / 2, DEPTH / 2, HEIGHT / 2])
    faces = {
        "left": (z - x, -y, z),
        "right": (z + x, y, z),
        "rear": (z + y, -x, z),
        "front": (z - y, x, z),
        "top": (2 * z, x, y),
    }
    return tuple(panel(*faces[name], rig) for name in names)


def seen(
    rig: Rig, faces: tuple[SelectedFace, ...], *, ground: bool = True
) -> tuple[SelectedFace, ...]:
    """The faces with boards."""
    weight = np.ones(len(rig.views))
    photos = PhotometricViews(rig.views, GreyLevels(rig.views, rig.maps), weight)
    judge = SideJudge(rig.views, rig.maps, weight)
    centres = np.array([v.pose.centre for v in rig.views])
    floor = Ground(UP, 0.0, 6.0 * rig.pixel, centres, DISTANCE) if ground else None
    behind = LinesBehind(photos, judge, np.zeros((0, 2, 3)), np.zeros((0, 3, 3)), rig.pixel)
    return with_boards(faces, photos, judge, rig.untaken, floor, behind, rig.pixel)


def boards(
    rig: Rig, faces: tuple[SelectedFace, ...], *, ground: bool = True
) -> tuple[SelectedFace, ...]:
    """Return what was found besides, where all of the faces are true."""
    found = seen(rig, faces, ground=ground)
    assert found[: len(faces)] == faces
    return found[len(faces) :]


def heights(found: tuple[SelectedFace, ...]) -> list[float]:
    return sorted(float(face.corners[:, 2].mean()) for face in found)


def test_the_boards_of_a_shelf_are_found_by_their_rims() -> None:
    rig = rig_of("shelf")
    found = boards(rig, outside(rig, "left", "right", "rear", "top"))
    # The middle board, and the lowest just above the floor: white on dark, it is none of it.
    assert heights(found) == pytest.approx([THICKNESS, (HEIGHT + THICKNESS) / 2], abs=3 * rig.pixel)
    for face in found:
        assert face.normal @ UP == pytest.approx(1.0)
        assert face.shown.sum() >= 3
        assert face.plane_cov is not None
        assert np.sqrt(np.diagonal(face.plane_cov)).max() < 4 * rig.pixel
        extents = np.ptp(face.corners @ outside(rig, "left")[0].normal)
        assert extents == pytest.approx(WIDTH, abs=rig.pixel)


def test_nothing_lies_between_the_ends_of_a_bench() -> None:
    rig = rig_of("bench")
    assert boards(rig, outside(rig, "left", "right", "top")) == ()


def test_the_faces_of_a_closed_block_stay() -> None:
    rig = rig_of("block")
    assert boards(rig, outside(rig, "left", "right", "rear", "front", "top")) == ()


def printed(rig: Rig, front: SelectedFace, heights_of_lines: list[float]) -> Rig:
    """Return the pictures with level black lines across a face, as between drawers."""
    low = front.corners[front.corners[:, 2].argsort()[:2]]
    views = []
    for view, shown in zip(rig.views, front.shown, strict=True):
        image = view.image.copy()
        for height in heights_of_lines if shown else ():
            ends = (low + height * UP) @ view.projection[:, :3].T + view.projection[:, 3]
            (a, b), (c, d) = np.rint(ends[:, :2] / ends[:, 2:]).astype(int).tolist()
            cv2.line(image, (a, b), (c, d), 20, 2)
        views.append(replace(view, image=image))
    return Rig(rig.solid, tuple(views))


def test_a_front_with_lines_as_between_drawers_stays() -> None:
    plain = rig_of("block")
    (front,) = outside(plain, "front")
    rig = printed(plain, front, [2.5, 3.3, 5.5, 6.3])
    assert boards(rig, outside(rig, "left", "right", "rear", "front", "top")) == ()
