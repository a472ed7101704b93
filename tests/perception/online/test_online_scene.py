"""Views one at a time: what is known after each, and what all at once come to beside it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from facetlog.perception.online.online_scene import OnlineScene
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import Pose
from facetlog.robot.rendering.worlds import make_world
from tests.rendered import get_solid_truth, tour

UP = np.array([0.0, 0.0, 1.0])
VIEWS = 12


@pytest.fixture(scope="module")
def run():
    """The online scene after twelve views, and the scene and update after each."""
    online = OnlineScene(name="block", up=UP)
    steps = []
    for view in tour("block")[::2]:
        update = online.add(view)
        steps.append((update, online.scene))
    return online, steps


def _off(scene):
    # Distances of the corners of the block's faces from the true ones, in.
    true = np.array(get_solid_truth(make_world("block", 0)).vertices)
    corners = sorted({k for face in scene.faces for k in face.outline})
    apart = np.linalg.norm(scene.points[corners][:, None] - true[None], axis=-1)
    return apart.min(axis=1)


def test_between_searches_each_view_makes_corners_surer(run):
    _, steps = run
    between = [k for k in range(3, VIEWS) if not steps[k][0].searched]
    assert between
    for k in between:
        before, after = (steps[n][1] for n in (k - 1, k))
        assert steps[k][0].corners >= 3
        sds = [[np.trace(v.cov) for v in s.vertices] for s in (before, after)]
        assert all(b <= a + 1e-12 for a, b in zip(*sds, strict=True))
        assert sum(sds[1]) < sum(sds[0])


@pytest.mark.slow
def test_without_polish_corners_are_nearly_as_good_as_of_all_views_at_once(run):
    _, steps = run
    batch = reconstruct(tour("block")[::2], name="block", up=UP)
    rms = [np.sqrt((_off(scene) ** 2).mean()) for scene in (steps[-1][1], batch)]
    assert rms[0] < 1.5 * rms[1]


@pytest.mark.slow
def test_a_view_with_a_wrong_pose_changes_no_corner_and_is_named():
    views = list(tour("block")[::2])
    angle = np.radians(4.0)
    about_up = cv2.Rodrigues(angle * UP)[0]
    pose = views[5].pose
    wrong = replace(views[5], name="wrong.png", pose=Pose(about_up @ pose.rotation, pose.centre))
    online = OnlineScene(name="block", up=UP)
    problems = [online.add(view).problem for view in (*views[:7], wrong)]
    problems.append(online.finish(polish=True))
    (said,) = filter(None, problems)
    assert "wrong.png" in said
    batch = reconstruct(views[:7], name="block", up=UP)
    assert len(online.scene.faces) == len(batch.faces)
    assert np.median(_off(online.scene)) < 0.1


def test_a_view_that_has_the_corners_elsewhere_is_refused(run):
    online, _ = run
    scene, view = online.scene, tour("block")[0]
    camera = replace(view.camera, cx=view.camera.cx + 2.0)
    update = online.add(replace(view, name="shifted.png", camera=camera))
    assert not update.used
    assert update.problem.startswith("shifted.png contradicts")
    assert online.scene is scene


@pytest.mark.slow
def test_edges_without_faces_are_surer_across_by_each_view_that_shows_them():
    online, updated, surer = OnlineScene(name="table", up=UP), 0, 0
    for view in tour("table")[:10]:
        before = online.scene
        update = online.add(view)
        if update.searched or not update.lines:
            continue
        for edge in online.scene.edges:
            old, new = (scene.vertices[edge.start] for scene in (before, online.scene))
            span = online.scene.points[edge.end] - new.point
            along = span / np.linalg.norm(span)
            across = np.eye(3) - np.outer(along, along)
            assert np.trace(across @ new.cov) <= np.trace(across @ old.cov) * 1.01
            surer += np.trace(across @ new.cov) < 0.9 * np.trace(across @ old.cov)
        updated += update.lines
    assert updated >= 3
    assert surer >= updated / 2
