"""Faces as lattices of points, and what views see of them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.perception.scene import Face, Plane, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved
from facetlog.perception.surfaces.seeing.seen_faces import (
    MOST_POINTS,
    MOST_VIEWS,
    make_surfaces,
)


def plate(hole: tuple[float, float] = (1.0, 2.0), side: float = 3.0) -> Scene:
    """A square with a square hole."""
    low, high = hole
    corners = [(0, 0), (side, 0), (side, side), (0, side)]
    corners += [(low, low), (low, high), (high, high), (high, low)]
    vertices = tuple(Vertex(np.array([x, y, 0.0]), np.eye(3)) for x, y in corners)
    plane = Plane(np.array([0.0, 0.0, 1.0]), 0.0, np.eye(4))
    face = Face((0, 1, 2, 3), plane, holes=((4, 5, 6, 7),))
    return Scene("plate", vertices=vertices, faces=(face,))


def test_points_lie_on_the_face_and_not_in_its_holes() -> None:
    (surface,) = make_surfaces(plate())
    x, y, z = surface.points.T
    assert not z.any()
    assert ((x > 0) & (x < 3) & (y > 0) & (y < 3)).all()
    assert not ((x > 1) & (x < 2) & (y > 1) & (y < 2)).any()
    assert len(surface.points) == pytest.approx(MOST_POINTS * 8 / 9, rel=0.05)


def test_points_move_with_the_frame() -> None:
    block, turn = cuboid(3.0, 2.0, 1.0), Rotation.from_rotvec([0.3, -0.4, 0.9]).as_matrix()
    there = moved(block, turn, np.array([1.0, 2.0, 3.0]))
    for one, other in zip(make_surfaces(block), make_surfaces(there), strict=True):
        np.testing.assert_allclose(one.points @ turn.T + [1.0, 2.0, 3.0], other.points, atol=1e-9)


def test_of_many_views_some_are_kept_evenly() -> None:
    (surface,) = make_surfaces(plate())
    origins = np.arange(300.0).reshape(100, 3)
    lattice = surface.seen(origins, np.ones((100, len(surface.points)), dtype=np.bool_))
    assert lattice is not None
    assert len(lattice.views) == MOST_VIEWS
    assert lattice.views[0] == 0
    assert lattice.views[-1] == 99
    assert max(np.diff(lattice.views)) <= 4
