"""Hidden lines go, visible ones stay: against a depth buffer, at the border, behind the camera."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.part_facts import find_flat_edges
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.line_drawing import Junction
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    boxes,
    cuboid,
    l_block,
    moved,
    pyramid,
    table,
)
from facetlog.perception.surfaces.visible_lines import VisibleLines, visible_lines
from facetlog.perception.types import Camera, FloatArray, Pose
from tests.drawn_scenes import CAMERA, looking, viewed


def drawn(scene: Scene, view: int = 0) -> VisibleLines:
    memo = SceneMemo.of(scene)
    camera, pose = scene.cameras[view], scene.poses[view]
    return visible_lines(memo.table, memo.edges, memo.bounds, find_flat_edges(memo), camera, pose)


def in_sight(scene: Scene, points: FloatArray, eye: FloatArray) -> NDArray[np.bool_]:
    """Which points (n, 3) of the scene's surface nothing stands before: face by face, by Jordan."""
    seen = np.ones(len(points), dtype=bool)
    for face in scene.faces:
        n, corners = face.plane.normal, scene.points[list(face.outline)]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = face.plane.distance(eye) / (
                face.plane.distance(eye) - face.plane.distance(points)
            )
        met = eye + share[:, None] * (points - eye)
        keep = [k for k in range(3) if k != np.abs(n).argmax()]
        (x, y), ring = met[:, keep].T, corners[:, keep]
        inside = np.zeros(len(points), dtype=bool)
        for (x1, y1), (x2, y2) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            with np.errstate(divide="ignore", invalid="ignore"):
                inside ^= ((y1 > y) != (y2 > y)) & (x < (x2 - x1) * (y - y1) / (y2 - y1) + x1)
        seen &= ~(inside & (share > 0) & (share < 1 - 1e-9))
    return seen


def types(found: VisibleLines) -> Counter[Junction]:
    return Counter(rays.type for rays in found.drawing.rays if rays is not None)


@pytest.mark.parametrize("build", [cuboid, l_block, pyramid, table])
def test_what_is_drawn_is_what_nothing_stands_before(build: object) -> None:
    scene = viewed(build(), 5)  # type: ignore[operator]
    memo = SceneMemo.of(scene)
    share = np.linspace(0.02, 0.98, 49)[:, None]
    for k, (camera, pose) in enumerate(zip(scene.cameras, scene.poses, strict=True)):
        found = drawn(scene, k)
        wrong = 0
        for edge, (a, b) in enumerate(memo.edges.tolist()):
            points = scene.points[a] + share * (scene.points[b] - scene.points[a])
            ahead = (points - pose.centre) @ pose.rotation
            uv = ahead[:, :2] / ahead[:, 2:] * camera.fx + [camera.cx, camera.cy]
            on = np.zeros(49, dtype=bool)
            for line in found.drawing.lines[found.edge == edge]:
                p, q = found.drawing.points[line]
                along = (uv - p) @ (q - p) / ((q - p) @ (q - p))
                on |= (along >= 0) & (along <= 1)
            wrong += int((in_sight(scene, points, pose.centre) != on).sum())
        # a point beside a crossing may be taken for it
        assert wrong <= 0.005 * 49 * len(memo.edges)


def test_lines_end_at_the_border_of_the_picture() -> None:
    scene = viewed(cuboid(), 1, distance=1.2)
    close = replace(scene, cameras=(Camera(320, 240, 450.0, 450.0, 159.5, 119.5),))
    found = drawn(close)
    points = found.drawing.points
    assert ((points >= -0.5 - 1e-9) & (points <= [319.5 + 1e-9, 239.5 + 1e-9])).all()
    ends = [i for i, r in enumerate(found.drawing.rays) if r and r.type is Junction.END]
    assert ends
    at_border = np.minimum(points[ends] + 0.5, [319.5, 239.5] - points[ends]).min(axis=1)
    assert np.allclose(at_border, 0.0)
    assert (found.vertex[ends] == -1).all()


def test_what_lies_behind_the_camera_is_not_drawn() -> None:
    scene = viewed(cuboid(), 1)
    pose = scene.poses[0]
    away = looking(pose.centre, 2 * pose.centre - scene.points.mean(axis=0))
    assert not len(drawn(replace(scene, poses=(away,))).drawing.lines)


def test_a_block_before_another_hides_it_and_pieces_stay_in_line() -> None:
    blocks = boxes([((0, 0, 0), (1, 1, 1)), ((0.3, -3, 0), (0.6, -2.8, 2))], sd=0.0, name="two")
    middle = np.array([0.5, 0.5, 0.5])
    seen = replace(
        blocks, views=("v",), poses=(looking(middle - [0.2, 9.0, -2.0], middle),), cameras=(CAMERA,)
    )
    found = drawn(seen)
    pieces = Counter(found.edge.tolist())
    # the first block's edges are the first twelve: what stands before them leaves two pieces
    assert sorted(n for edge, n in pieces.items() if edge < 12)[-3:] == [2, 2, 2]
    assert types(found)[Junction.T] >= 6


def test_faces_that_go_on_in_one_plane_have_no_line_between_them() -> None:
    two = boxes([((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 1))], sd=0.001, name="two")
    found = fact_rows(viewed(two, 3), {"junction"})["junction"]
    one = fact_rows(viewed(cuboid(2.0, 1.0, 1.0), 3), {"junction"})["junction"]
    assert Counter(row[2] for row in found if row[2] != "straight") == Counter(
        row[2] for row in one
    )


def test_turned_and_moved_with_its_cameras_a_scene_is_drawn_alike() -> None:
    scene = viewed(l_block(), 1)
    (pose,), turn = scene.poses, looking(np.zeros(3), np.array([0.3, 0.5, 0.2])).rotation
    shift = np.array([5.0, -2.0, 1.0])
    placed = Pose(turn @ pose.rotation, turn @ pose.centre + shift)
    other = replace(moved(scene, turn, shift), cameras=scene.cameras, poses=(placed,))
    before, after = drawn(scene).drawing, drawn(other).drawing
    assert after.lines.tolist() == before.lines.tolist()
    assert np.allclose(after.points, before.points)
