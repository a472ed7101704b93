"""What stands behind a face within its outline, such as the legs under a table top."""

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.types import FloatArray

__all__ = ["MIN_DEPTH_SHARE", "RIM_SHARE", "hangs_behind", "lies_inside", "stands_behind"]

# The outline is widened by this share of the face's size: legs stand at the rim.
RIM_SHARE = 0.08
# What begins farther behind than this share of the face's size is another thing: a table top is
# rarely thicker than a quarter of the root of its area.
MAX_GAP_SHARE = 0.25
# What stays nearer to the face's plane than this share lies on the face.
MIN_DEPTH_SHARE = 0.05


def stands_behind(
    segments: FloatArray, corners: FloatArray, normal: FloatArray
) -> NDArray[np.bool_]:
    """Which segments (n, 2, 3) begin just behind a face and stay within its outline (n,).

    `corners` (k, 3) is the face's outline, `normal` (3,) its outward unit normal.

    >>> square = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    >>> leg, beside = [[0.1, 0.1, 0.9], [0.1, 0.1, 0]], [[2, 0, 0.9], [2, 0, 0.0]]
    >>> stands_behind(np.array([leg, beside]), square, np.array([0, 0, 1.0]))
    array([ True, False])
    """
    depth, within, size = _seen_along(segments, corners, normal)
    begins = np.abs(depth).min(axis=1) < MAX_GAP_SHARE * size
    reaches = depth.max(axis=1) > MIN_DEPTH_SHARE * size
    result: NDArray[np.bool_] = begins & reaches & _is_behind(depth, within, size)
    return result


def hangs_behind(sides: FloatArray, corners: FloatArray, normal: FloatArray) -> bool:
    """Whether a face with these sides (n, 2, 3) begins at another from behind, within its outline.

    `corners` and `normal` are the other's; of a board pictures often show the upper side alone, so
    what begins no farther behind than boards are thick begins there.
    """
    depth, within, size = _seen_along(sides, corners, normal)
    begins = depth.min() < MAX_GAP_SHARE * size and depth.max() > MIN_DEPTH_SHARE * size
    return bool(begins and _is_behind(depth, within, size).all())


def lies_inside(segments: FloatArray, corners: FloatArray, normal: FloatArray) -> NDArray[np.bool_]:
    """Which segments (n, 2, 3) lie behind a face within its outline, however deep (n,).

    Of a solid that is where its inside is: no view shows an edge there.
    """
    return _is_behind(*_seen_along(segments, corners, normal))


def _is_behind(depth: FloatArray, within: NDArray[np.bool_], size: float) -> NDArray[np.bool_]:
    behind: NDArray[np.bool_] = (depth > -MIN_DEPTH_SHARE * size).all(axis=1) & within
    return behind


def _seen_along(
    segments: FloatArray, corners: FloatArray, normal: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_], float]:
    # Depths (n, 2) behind the face, whether both ends are within its widened outline, its size.
    middle = corners.mean(axis=0)
    axes = plane_axes(normal, corners[1] - corners[0])
    polygon = shapely.Polygon((corners - middle) @ axes.T)
    size = float(np.sqrt(polygon.area))
    flat = (segments - middle) @ axes.T
    within = shapely.contains_xy(polygon.buffer(RIM_SHARE * size), flat[..., 0], flat[..., 1])
    return -(segments - middle) @ normal, within.all(axis=1), size
