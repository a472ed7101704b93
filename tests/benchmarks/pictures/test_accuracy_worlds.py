"""Areas of found faces against a world's: exact faces have all, faults are told apart."""

import numpy as np
import pytest

from benchmarks.pictures.accuracy_worlds import Surface, areas, true_surface
from benchmarks.pictures.polygons import Polygon
from facetlog.perception.types import FloatArray, View
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses

CAMERA = tour_camera()
SQUARE = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]])


def surface_of(world: World) -> Surface:
    image = np.zeros((CAMERA.height, CAMERA.width), np.uint8)
    return true_surface(world, [View("", image, CAMERA, pose) for pose in tour_poses()])


@pytest.fixture(scope="module")
def block() -> Surface:
    return surface_of(make_world("block"))


def corners_of(name: str) -> list[FloatArray]:
    return [facet.corners for facet in make_world(name).facets]


def test_samples_are_even_and_the_face_covers_them() -> None:
    square = Polygon(SQUARE + 3.0)
    points = square.samples()
    assert square.area == pytest.approx(4.0)
    np.testing.assert_allclose(points.mean(axis=0), [4.0, 4.0, 3.0])
    np.testing.assert_allclose(np.ptp(points, axis=0), [1.9, 1.9, 0.0], atol=1e-9)
    normals = np.broadcast_to(square.normal, points.shape)
    assert square.covers(points, normals, offset=0.1, margin=0.0, turn=0.1).all()
    assert not square.covers(
        points + 0.2 * square.normal, normals, offset=0.1, margin=0, turn=0.1
    ).any()


def test_all_of_the_block_but_its_bottom_counts(block: Surface) -> None:
    assert len(np.unique(block.owners)) == 5
    assert block.areas.sum() == pytest.approx(10 * 8 + 2 * 6 * (10 + 8))


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


def test_nothing_found_is_nothing_covered(block: Surface) -> None:
    found = areas(block, [])
    assert (found.covered, found.true, found.wrong, found.ground) == (0.0, 0.0, 0.0, 0.0)
