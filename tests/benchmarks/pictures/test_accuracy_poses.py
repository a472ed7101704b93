"""The peer that knows which pixels belong together."""

import numpy as np
import pytest

from benchmarks.pictures.accuracy_poses import solve_peer_corners
from benchmarks.pictures.recognition import Shape
from facetlog.perception.types import Camera, View
from facetlog.robot.rendering.solids import cuboid
from facetlog.robot.rendering.views import add_pose_noise
from facetlog.robot.tour import make_ring_poses

BLOCK = cuboid(0.25, 0.2, 0.15)
SHAPE = Shape(np.array(BLOCK.vertices), BLOCK.edges, BLOCK.faces)
CAMERA = Camera(640, 480, 600.0, 600.0, 319.5, 239.5)


def ring() -> tuple[View, ...]:
    image = np.zeros((480, 640), np.uint8)
    poses = make_ring_poses([0.0, 0.0, 0.08], 0.7, (0.35, 0.5), 12)
    return tuple(View(f"{k}.png", image, CAMERA, pose) for k, pose in enumerate(poses))


@pytest.mark.parametrize(("degrees", "metres", "limit"), [(0.0, 0.0, 2e-4), (0.3, 0.005, 8e-3)])
def test_the_peer_finds_the_corners_as_far_as_poses_allow(
    degrees: float, metres: float, limit: float
) -> None:
    angle_sd = float(np.radians(degrees))
    rng = np.random.default_rng(0)
    off = add_pose_noise(ring(), rng, position_sd=metres, angle_sd=angle_sd)
    found = solve_peer_corners(ring(), off, SHAPE, rng, metres, angle_sd)
    assert np.sqrt(((found - SHAPE.vertices) ** 2).sum(axis=1).mean()) < limit
