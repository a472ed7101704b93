"""Regions of one grey beside 3-D faces: the same, merged, mixed up, none."""

import numpy as np
import pytest

from facetlog.perception.surfaces.drawing.hidden_surface import hidden_surface
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.grey_agreement import grey_agreement
from facetlog.perception.types import Camera, View
from facetlog.robot.tour import make_pose_looking_at

SCENE = cuboid(0.3, 0.2, 0.1)
VIEW = View(
    "a.png",
    np.zeros((240, 320), np.uint8),
    Camera(320, 240, 300, 300, 160, 120),
    make_pose_looking_at([0.7, 0.6, 0.5], [0.0, 0.0, 0.05]),
)
FACES = hidden_surface(VIEW, SCENE).face


def test_regions_that_are_the_faces_agree_wholly():
    labels = (FACES + 1).astype(np.int32)
    found = grey_agreement(labels, SCENE, VIEW)
    assert found.rand == 1.0
    assert len(found.faces) == 3
    assert all(found.own)
    np.testing.assert_allclose(found.overlap, 1.0)


def test_two_faces_of_one_grey_leave_at_most_one_its_own():
    first, second, third = np.unique(FACES[FACES >= 0])
    labels = np.where(np.isin(FACES, (first, second)), 1, np.where(third == FACES, 2, 0))
    found = grey_agreement(labels.astype(np.int32), SCENE, VIEW)
    assert sum(found.own) <= 2
    assert found.own[found.faces.index(third)]
    assert 0.0 < found.rand < 1.0


def test_regions_by_chance_agree_as_chance_does_and_none_not_at_all():
    rng = np.random.default_rng(2)
    labels = np.where(FACES >= 0, rng.integers(1, 4, FACES.shape), 0).astype(np.int32)
    found = grey_agreement(labels, SCENE, VIEW)
    assert found.rand == pytest.approx(0.0, abs=0.01)
    assert not any(found.own)
    assert grey_agreement(np.zeros(FACES.shape, np.int32), SCENE, VIEW).rand is None
