"""Simulated views: what a robot would have brought home from a world."""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.types import Camera, Pose, View
from facetlog.robot.render import render
from facetlog.robot.world import World

__all__ = ["views_of"]


def views_of(
    world: World,
    poses: Sequence[Pose],
    camera: Camera,
    *,
    seed: int = 0,
    noise_sd: float = 5.0,
    blur_px: float = 1.0,
) -> tuple[View, ...]:
    """One view per pose, in the world's frame and unit; the noise of each follows from the seed.

    The noise of a view depends on its place in `poses` alone, not on the others.
    """
    return tuple(
        View(
            f"view{index:03d}.png",
            render(
                world,
                camera,
                pose,
                noise_sd=noise_sd,
                blur_px=blur_px,
                rng=np.random.default_rng([seed, index]),
            ),
            camera,
            pose,
        )
        for index, pose in enumerate(poses)
    )
