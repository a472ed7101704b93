"""Up from lines, where nobody states it: what people build is level and upright."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray, View

# Cameras look down at a thing by less than 60 degrees: then their own ups lie along up by this much
# in the mean (cosine). At a wall they look by 30 degrees at most from below, where it is as much.
HELD_UPRIGHT = 0.5
# Up is this near to the cameras' mean up (cosine of 30 degrees): a tour round half of a thing is
# lopsided by so much.
NEAR_HELD = float(np.cos(np.deg2rad(30.0)))
# A line of 50 px whose ends are known to a pixel is known to some two degrees.
SQUARE = float(np.sin(np.deg2rad(2.0)))
ALONG = float(np.cos(np.deg2rad(2.0)))
# Of so many of the likeliest lines each two propose what is square to both.
PROPOSING = 40
# Of what lies all over some is level by chance: so much of the lines' likelihood must agree.
LEAST_AGREEING = 0.5
STEPS = 3


def held_up(views: Sequence[View], normal: FloatArray) -> bool:
    """Return whether a unit vector (3,) is upwards as the cameras were held in the mean."""
    return float(_held(views) @ normal) > HELD_UPRIGHT


def level_direction(
    segments: FloatArray, score: FloatArray, views: Sequence[View]
) -> FloatArray | None:
    """Return the unit vector (3,) near the cameras' own up that most of segments (n, 2, 3), by
    their score (n,), are along or square to; None where they do not agree, or cameras were not held
    upright.
    """
    held = _held(views)
    length = float(np.linalg.norm(held))
    likely = np.flatnonzero(score > 0)
    if not length > HELD_UPRIGHT or not len(likely):
        return None
    likely = likely[np.argsort(-score[likely], kind="stable")]
    ways = segments[likely, 1] - segments[likely, 0]
    ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
    weight = score[likely]
    pairs = np.array(list(combinations(range(min(len(ways), PROPOSING)), 2)), np.intp)
    square = np.cross(ways[pairs[:, 0]], ways[pairs[:, 1]]) if len(pairs) else np.zeros((0, 3))
    proposed = np.concatenate([ways, square])
    size = np.linalg.norm(proposed, axis=1)
    # Lines that are nearly along one another say little of what is square to both.
    proposed = proposed[size > SQUARE] / size[size > SQUARE, None]
    proposed *= np.where(proposed @ held < 0.0, -1.0, 1.0)[:, None]
    proposed = proposed[proposed @ held > NEAR_HELD * length]
    if not len(proposed):
        return None
    agreeing = _agrees(ways, proposed.T).T @ weight
    up: FloatArray = proposed[int(np.argmax(agreeing))]
    for _ in range(STEPS):
        some = _agrees(ways, up)
        upright = np.abs(ways @ up) > ALONG
        # The least sum of squares of sines to level lines and to upright ones.
        signed = np.where(upright, -weight, weight)[some]
        up = np.linalg.eigh((ways[some] * signed[:, None]).T @ ways[some])[1][:, 0]
        up = up if float(up @ held) > 0.0 else -up
    agrees = float(_agrees(ways, up) @ weight)
    return up if agrees >= LEAST_AGREEING * float(weight.sum()) else None


def _held(views: Sequence[View]) -> FloatArray:
    # The mean (3,) of the cameras' own ups.
    return np.asarray(np.mean([-view.pose.rotation[:, 1] for view in views], axis=0))


def _agrees(ways: FloatArray, up: FloatArray) -> NDArray[np.bool_]:
    # Which ways (n, 3) are along or square to up (3,), or to each of several (3, m).
    along = np.abs(ways @ up)
    agrees: NDArray[np.bool_] = (along < SQUARE) | (along > ALONG)
    return agrees
