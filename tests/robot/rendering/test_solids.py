"""Every maker gives an outward-facing solid of the size it was asked for."""

import numpy as np
import pytest

from facetlog.robot.rendering.solids import (
    cuboid,
    cylinder,
    placed,
    printed,
    pyramid,
    room_corner,
    standing_wedge,
    wedge,
)
from facetlog.robot.rendering.world import Solid

CLOSED = {
    "cuboid": (cuboid(10, 8, 6), 480.0, 12),
    "wedge": (wedge(10, 8), 10 * 8 * 8 * np.sqrt(0.75) / 2, 9),
    "standing_wedge": (standing_wedge(9, 7), 9 * 9 * np.sqrt(0.75) / 2 * 7, 9),
    "pyramid": (pyramid(10, 9, 7), 210.0, 8),
    "room_corner": (room_corner(16, 14, 10, 1), (16 + 13) * 10.0, 18),
    "cylinder": (cylinder(9, 7), np.pi * 4.5**2 * 7, 360),
}


def volume(solid: Solid) -> float:
    """By the divergence theorem, over fans of triangles."""
    total = 0.0
    for face in solid.faces:
        p = solid.vertices[list(face)]
        for i in range(1, len(p) - 1):
            total += p[0] @ np.cross(p[i], p[i + 1]) / 6
    return total


@pytest.mark.parametrize("name", CLOSED)
def test_a_closed_solid_has_its_volume_and_its_edges(name: str) -> None:
    solid, expected, edges = CLOSED[name]
    assert volume(solid) == pytest.approx(expected, rel=1e-3)  # the cylinder has facets
    assert len(solid.edges) == edges
    assert solid.vertices[:, 2].min() == 0.0
    assert solid.size == pytest.approx(np.ptp(solid.vertices, axis=0))


def test_a_placed_solid_keeps_its_shape_and_scales_its_size() -> None:
    solid = placed(printed(cuboid(10, 8, 6), 1), 3, 4, yaw=0.3, scale=2.0)
    assert solid.size == (20, 16, 12)
    assert solid.vertices.mean(axis=0) == pytest.approx([3, 4, 6])
    start, end = solid.vertices[[0, 1]]
    assert end - start == pytest.approx([20 * np.cos(0.3), 20 * np.sin(0.3), 0])
    before = cuboid(10, 8, 6)
    period = printed(before, 1).prints[0]
    moved = solid.prints[0]
    assert period is not None
    assert moved is not None
    assert moved.period == 2 * period.period


def test_a_bent_face_is_refused() -> None:
    bent = [[0, 0, 0], [1, 0, 0], [1, 1, 0.1], [0, 1, 0]]
    with pytest.raises(ValueError, match="not flat"):
        Solid("bent", np.array(bent), ((0, 1, 2, 3),), (1.0,), (1.0, 1.0, 1.0))


def test_faces_that_disagree_about_outside_are_refused() -> None:
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    with pytest.raises(ValueError, match="same direction"):
        Solid("twice", np.array(square), ((0, 1, 2), (0, 1, 3)), (1.0, 1.0), (1.0, 1.0, 0.0))


def test_an_albedo_beyond_one_is_refused() -> None:
    with pytest.raises(ValueError, match="albedo"):
        cuboid(1, 1, 1, albedo=1.2)
