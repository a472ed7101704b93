"""The plan of the scene as its cameras know it: which way is up, and how the block is turned.

A camera on a pan-tilt head without skew keeps the rows of its pictures level, so that the axes x
of all cameras lie in the ground plane. A block's level edges then point in four directions of
the plan, a quarter turn apart.
"""

import numpy as np

from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.types import FloatArray, View

__all__ = ["block_turn", "edge_azimuth", "ground_axes", "upward_direction"]

# The cameras' x axes fix the ground plane if they spread more than this (second singular value
# over the first): some 6 degrees; below it the mean of the pictures' own upward axes is taken.
LEAST_SPREAD = 0.1
# Edges vote for the block's turn; the winning turn has this share of all level directions (by
# length) within TURN_WINDOW of it. Directions at random would give it 2 * 5 / 90 = .11.
LEAST_TURN_SHARE = 0.35
TURN_WINDOW = np.deg2rad(5.0)
TURN_STEPS = 180
QUARTER = np.pi / 2.0


def upward_direction(views: tuple[View, ...]) -> FloatArray:
    """Unit vector (3,) in the world that is up in the pictures, for cameras without skew."""
    x_axes = np.array([view.pose.rotation[:, 0] for view in views])
    up_axes = -np.array([view.pose.rotation[:, 1] for view in views])
    mean_up = up_axes.sum(axis=0)
    _, spread, vt = np.linalg.svd(x_axes)
    level = len(spread) >= 2 and spread[1] >= LEAST_SPREAD * spread[0]
    up = vt[2] if level else mean_up - vt[0] * (vt[0] @ mean_up)
    if up @ mean_up < 0:
        up = -up
    return np.asarray(up / np.linalg.norm(up), dtype=np.float64)


def ground_axes(up: FloatArray, first: View) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (3,), (3,) of the plan: right and ahead of the first view; right x ahead = up.

    The azimuths of this module are counter-clockwise from the first one, seen from above.
    """
    right = first.pose.rotation[:, 0]
    right = right - up * (up @ right)
    right = right / np.linalg.norm(right)
    return right, np.cross(up, right)


def edge_azimuth(
    view: View, line: EdgeLine, up: FloatArray, axes: tuple[FloatArray, FloatArray]
) -> float | None:
    """Azimuth (radians) of a level edge from its start to its end; None if the edge can be upright.

    The rays through a line span a plane; the level direction in it is that plane's normal x up.
    """
    inverse = np.linalg.inv(view.camera.matrix)
    rays = np.array([inverse @ [*p, 1.0] for p in (line.start, line.end)]) @ view.pose.rotation.T
    normal = np.cross(rays[0], rays[1])
    normal /= np.linalg.norm(normal)
    level = np.cross(normal, up)
    # |level| is the sine of the plane's tilt off the ground: a nearly level plane fixes nothing.
    if np.linalg.norm(level) < LEAST_TILT or abs(normal @ up) < UPRIGHT_SINE:
        return None
    level /= np.linalg.norm(level)
    # From start to end: the ray at the end lies towards the level direction.
    along = rays[1] / np.linalg.norm(rays[1]) - rays[0] / np.linalg.norm(rays[0])
    if along @ level < 0:
        level = -level
    return float(np.arctan2(level @ axes[1], level @ axes[0]))


# Below this sine an edge's plane of rays contains the upright: 3 degrees, an edge's own error.
UPRIGHT_SINE = 0.05
# Sine of the tilt off the ground below which an edge at the height of the eye has no azimuth.
LEAST_TILT = 0.05


def block_turn(azimuths: FloatArray, lengths: FloatArray) -> float | None:
    """Turn (radians, 0..pi/2) of the block's level edges in the plan; None if no turn stands out.

    Each edge votes by its length for its azimuth modulo a quarter turn.

    >>> round(float(np.rad2deg(block_turn(np.deg2rad([10, 101, -79, -171, 40]), np.ones(5)))))
    10
    """
    if not len(azimuths):
        return None
    folded = np.asarray(azimuths, dtype=np.float64)
    candidates = np.linspace(0.0, QUARTER, TURN_STEPS, endpoint=False)
    off = (folded[None, :] - candidates[:, None] + QUARTER / 2) % QUARTER - QUARTER / 2
    votes = (lengths * np.maximum(0.0, 1.0 - np.abs(off) / TURN_WINDOW)).sum(axis=1)
    best = int(np.argmax(votes))
    near = np.abs(off[best]) <= TURN_WINDOW
    if lengths[near].sum() < LEAST_TURN_SHARE * lengths.sum():
        return None
    middle = float((lengths[near] * off[best][near]).sum() / lengths[near].sum())
    return float((candidates[best] + middle) % QUARTER)
