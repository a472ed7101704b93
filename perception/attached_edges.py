"""Edges attached to a face: below it, such as legs under a top, or risen from its rim, as backs."""

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.types import FloatArray

# The outline is widened by this share of the face's size: legs stand at the rim.
RIM_SHARE = 0.08
# Edges that begin farther behind than this share of the face's size are another thing's: a top is
# rarely thicker than a quarter of the root of its area.
MAX_GAP_SHARE = 0.25
# Edges that stay nearer to the face's plane than this share lie on the face.
MIN_DEPTH_SHARE = 0.05
# A face carries what rises from it if its normal points this far above the horizon: sin 30°.
LEVEL_ENOUGH = 0.5
# Posts lean less than this from upright: backs lean by 25° at most.
UPRIGHT = float(np.cos(np.deg2rad(30.0)))


def find_segments_behind(
    segments: FloatArray, corners: FloatArray, normal: FloatArray
) -> NDArray[np.bool_]:
    """Return which segments (n, 2, 3) begin just behind a face and stay within its outline (n,).

    `corners` (k, 3) is the face's outline, `normal` (3,) its outward unit normal.

    >>> square = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    >>> leg, beside = [[0.1, 0.1, 0.9], [0.1, 0.1, 0]], [[2, 0, 0.9], [2, 0, 0.0]]
    >>> find_segments_behind(np.array([leg, beside]), square, np.array([0, 0, 1.0]))
    array([ True, False])
    """
    depth, within, size = _measure_depths_behind(segments, corners, normal)
    begins = np.abs(depth).min(axis=1) < MAX_GAP_SHARE * size
    reaches = depth.max(axis=1) > MIN_DEPTH_SHARE * size
    result: NDArray[np.bool_] = begins & reaches & _is_behind(depth, within, size)
    return result


def is_hung_behind(sides: FloatArray, corners: FloatArray, normal: FloatArray) -> bool:
    """Return whether a face with these sides (n, 2, 3) begins at another from behind, within its
    outline.

    `corners` and `normal` are the other's; of a board pictures often show the upper side alone, so
    what begins no farther behind than boards are thick begins there.
    """
    depth, within, size = _measure_depths_behind(sides, corners, normal)
    begins = depth.min() < MAX_GAP_SHARE * size and depth.max() > MIN_DEPTH_SHARE * size
    return bool(begins and _is_behind(depth, within, size).all())


def find_segments_inside(
    segments: FloatArray, corners: FloatArray, normal: FloatArray
) -> NDArray[np.bool_]:
    """Return which segments (n, 2, 3) lie behind a face within its outline, however deep (n,).

    Of a solid that is where its inside is: no view shows an edge there.
    """
    return _is_behind(*_measure_depths_behind(segments, corners, normal))


def _is_behind(depth: FloatArray, within: NDArray[np.bool_], size: float) -> NDArray[np.bool_]:
    behind: NDArray[np.bool_] = (depth > -MIN_DEPTH_SHARE * size).all(axis=1) & within
    return behind


def _measure_depths_behind(
    segments: FloatArray, corners: FloatArray, normal: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_], float]:
    # Depths (n, 2) behind the face, whether both ends are within its widened outline, its size.
    middle = corners.mean(axis=0)
    axes = make_plane_axes(normal, corners[1] - corners[0])
    polygon = shapely.Polygon((corners - middle) @ axes.T)
    size = float(np.sqrt(polygon.area))
    flat = (segments - middle) @ axes.T
    within = shapely.contains_xy(polygon.buffer(RIM_SHARE * size), flat[..., 0], flat[..., 1])
    return -(segments - middle) @ normal, within.all(axis=1), size


def find_risen_segments(
    segments: FloatArray,
    corners: FloatArray,
    normal: FloatArray,
    up: FloatArray,
    posts: NDArray[np.bool_] | None = None,
) -> NDArray[np.bool_]:
    """Return which segments (n, 2, 3) rise from the rim of a face, or hang together with such (n,).

    `corners` (k, 3) is the face's outline, `normal` (3,) its outward unit normal, `up` (3,) a unit
    vector. Those that stand at the rim are about upright, and of `posts` (n,) where that is given;
    they may go on below the face, to the ground. Of what is above it those belong to them of which
    one ends on the other, as rails do on posts: bars are as thick as what is still at the rim.

    >>> seat = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    >>> post, rail = [[0, 0, 1], [0, 0, 2]], [[0, 0, 2], [1, 0, 2]]
    >>> leg, vase = [[0, 0, 0], [0, 0, 1]], [[0.5, 0.5, 1], [0.5, 0.5, 2]]
    >>> z = np.array([0, 0, 1.0])
    >>> find_risen_segments(np.array([post, rail, leg, vase], dtype=float), seat, z, z)
    array([ True,  True, False, False])
    """
    if float(normal @ up) <= LEVEL_ENOUGH:
        return np.zeros(len(segments), np.bool_)
    middle = corners.mean(axis=0)
    axes = make_plane_axes(normal, corners[1] - corners[0])
    polygon = shapely.Polygon((corners - middle) @ axes.T)
    size = float(np.sqrt(polygon.area))
    height = (segments - middle) @ normal
    feet = (_find_foot_points(segments, height) - middle) @ axes.T
    away = shapely.distance(polygon.exterior, shapely.points(feet))
    reach = RIM_SHARE * size
    found = _are_upright(segments, up) & (away < reach)
    found &= (height.min(axis=1) < reach) & (height.max(axis=1) > reach)
    if posts is not None:
        found &= posts
    above = (height > -MIN_DEPTH_SHARE * size).all(axis=1)
    return _add_connected(segments, found, above, reach)


def _find_foot_points(segments: FloatArray, height: FloatArray) -> FloatArray:
    # Where each passes the plane from which heights (n, 2) count, or its end that is nearer to it.
    rise = height[:, 1] - height[:, 0]
    share = np.clip(-height[:, 0] / np.where(rise == 0.0, 1.0, rise), 0.0, 1.0)
    feet: FloatArray = segments[:, 0] + share[:, None] * (segments[:, 1] - segments[:, 0])
    return feet


def _are_upright(segments: FloatArray, up: FloatArray) -> NDArray[np.bool_]:
    span = segments[:, 1] - segments[:, 0]
    upright: NDArray[np.bool_] = np.abs(span @ up) > UPRIGHT * np.linalg.norm(span, axis=1)
    return upright


def _add_connected(
    segments: FloatArray, found: NDArray[np.bool_], may: NDArray[np.bool_], reach: float
) -> NDArray[np.bool_]:
    """Return which are `found`, or `may` be and hang together with such (n,)."""
    found, left = found.copy(), np.flatnonzero(may & ~found)
    fresh = np.flatnonzero(found)
    while len(left) and len(fresh):
        joined = np.zeros(len(left), np.bool_)
        for one in segments[fresh, None]:
            joined |= (_away(segments[left], one) < reach).any(axis=1)
            joined |= (_away(one, segments[left]) < reach).any(axis=1)
        fresh, left = left[joined], left[~joined]
        found[fresh] = True
    return found


def _away(ends: FloatArray, segments: FloatArray) -> FloatArray:
    """Return how far ends (n, 2, 3) are from segments (n, 2, 3), or from or of a single one: (n,
    2).
    """
    start, span = segments[:, :1], segments[:, 1:] - segments[:, :1]
    square = np.maximum((span * span).sum(axis=-1), 1e-300)
    t = np.clip(((ends - start) * span).sum(axis=-1) / square, 0.0, 1.0)
    away: FloatArray = np.linalg.norm(ends - start - t[..., None] * span, axis=-1)
    return away
