"""Areas of found faces against a world's: exact faces have all, faults are told apart."""

import numpy as np
import pytest

from benchmarks.pictures.accuracy_worlds import Surface, areas, sample_true_surface
from facetlog.perception.types import FloatArray, View
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses

CAMERA = tour_camera()
SQUARE = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]])


def surface_of(world: World) -> Surface:
    image = np.zeros((CAMERA.height, CAMERA.width), np.uint8)
    return sample_true_surface(world, [View("", image, CAMERA, pose) for pose in tour_poses()])


@pytest.fixture(scope="module")
def block() -> Surface:
    return surface_of(make_world("block"))


def corners_of(name: str) -> list[FloatArray]:
    return [facet.corners for facet in make_world(name).facets]


@pytest.mark.parametrize("name", ["block", "table", "shelf"])
def test_exact_faces_are_all_found_and_true(name: str) -> None:
    found = areas(surface_of(make_world(name)), corners_of(name))
    assert found.covered == pytest.approx(1.0)
    assert found.wrong == pytest.approx(0.0)


def test_what_a_top_hides_does_not_count() -> None:
    world = make_world("table")
    surface = surface_of(world)
    undersides = [i for i, facet in enumerate(world.facets) if facet.normal[2] < -0.9]
    assert not np.isin(surface.owners, undersides).any()


@pytest.mark.parametrize(("lift", "true"), [(0.05, True), (0.5, False)])
def test_a_face_off_its_plane_is_wrong(block: Surface, lift: float, true: bool) -> None:
    top = max(corners_of("block"), key=lambda c: c[:, 2].min())
    found = areas(block, [top + lift * np.eye(3)[2]])
    share = 80 / block.areas.sum()
    assert (found.covered, found.true) == pytest.approx((share, share) if true else (0.0, 0.0))
    assert found.precision == (1.0 if true else 0.0)


def test_a_patch_of_the_floor_is_ground_and_nothing_else(block: Surface) -> None:
    found = areas(block, [SQUARE])
    assert found.ground == pytest.approx(4.0 / block.areas.sum())
    assert (found.true, found.wrong) == (0.0, 0.0)
    assert np.isnan(found.precision)
