"""From where the cameras see the thing: all from one direction they tell hardly any depth.

Cameras that drive straight at a thing, or stand in a narrow arc, see its corners under small
angles. Planes are chosen wrong then, and no standard deviation of a corner tells of it.
"""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.types import FloatArray, View

__all__ = ["looking_apart", "one_direction"]

NONE = np.zeros((0, 3))
LEAST_ANGLE = np.radians(8.0)
"""On some hundred ways straight towards a rendered block or past it, 16 views each, corners came up
to 240 mm off where most are seen under less than 7 degrees, 11 mm at 7 to 9, 3 mm beyond."""


def one_direction(views: Sequence[View], corners: FloatArray = NONE) -> tuple[str, ...]:
    """A warning where all views see most corners of faces (n, 3) from one direction.

    Without a corner the point that the views look at stands for them.
    """
    points = corners if len(corners) else view_graph(views).focus[None]
    angle = float(np.median(_widest(points, np.array([v.pose.centre for v in views]))))
    if not angle < LEAST_ANGLE:
        return ()
    return (
        f"the cameras look from one direction, within {np.degrees(angle):.0f} degrees: depth is "
        "hardly known, and faces may be far off; take views from different sides",
    )


def looking_apart(views: Sequence[View]) -> tuple[str, ...]:
    """A line where most cameras have the point behind them that their axes pass nearest to.

    Such cameras may see a room; no thing that stands between them.
    """
    focus = view_graph(views).focus
    ahead = [(focus - v.pose.centre) @ v.pose.rotation[:, 2] > 0 for v in views]
    if 2 * sum(ahead) > len(ahead):
        return ()
    return (
        "the cameras look away from one another: place them round the thing, turned towards it, "
        "or check which way the axes of their poses point",
    )


def _widest(points: FloatArray, centres: FloatArray) -> FloatArray:
    # The angle (n,) between the rays to each point (n, 3) that are farthest apart: from the first
    # ray to the one farthest from it, and from there again. At least half of the widest, and all
    # of it for cameras on a line or an arc.
    rays = points[:, None] - centres
    rays /= np.maximum(np.linalg.norm(rays, axis=-1, keepdims=True), np.finfo(float).tiny)
    from_ = rays[:, 0]
    for _ in range(2):
        apart = np.linalg.norm(rays - from_[:, None], axis=-1)
        from_ = rays[np.arange(len(rays)), apart.argmax(axis=1)]
    # The chord between unit vectors.
    return np.asarray(2.0 * np.arcsin(np.minimum(apart.max(axis=1) / 2.0, 1.0)))
