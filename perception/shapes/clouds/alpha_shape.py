"""The area covered by points in a plane: their alpha shape, without thin whiskers."""

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import Delaunay, QhullError

from facetlog.perception.polygons import find_intersection, join_triangles
from facetlog.perception.types import FloatArray

__all__ = ["covered_area"]

# Random points leave an empty disc of 2.2 times their spacing once in e^15 (π 2.2²).
ALPHA = 2.2
# More points than this make no better outline, only a slower one; the spacing grows with the gap.
MOST_POINTS = 6000
# Whiskers and cracks narrower than twice this, in spacings, are the triangulation's own.
CLEARED = 1.0
# Holes must be this wide, in spacings, to be holes and not chance.
HOLE = 4.0
# Pieces with less than this share of the largest one's area are scatter.
PIECE_SHARE = 0.05
# Noise of less than this many spacings moves no rim by more than its own jaggedness.
LEAST_NOISE = 0.5
# Density is smoothed by the noise, by so many spacings at least (28 points: good to a fifth), in
# bins of a share of that, and compared with its mean over twice that.
LEAST_SMOOTHING, DENSITY_BIN, AROUND = 1.5, 0.5, 2.0
# A face of more bins, a thousand widths across, is changed by noise at its rim by less than .2 %.
MOST_BINS = 4_000_000
# At a straight rim blurred by noise density is half that of the inside, and so much of the mean
# around (.5 / .8, by integration).
RIM_DENSITY = 0.62
# Points and corners are put on a grid this fine, in spacings. Without one the overlay of two areas
# can fail where sides all but touch (GEOS rounds onto the grid soundly), and the corners that it
# leaves on a side would come from the last digits of the points, which differ by processor.
GRID = 1e-6


def covered_area(
    flat: FloatArray, spacing: FloatArray, noise: float = 0.0
) -> tuple[tuple[shapely.Polygon, ...], float]:
    """Polygons that points (n, 2) cover, largest first, and the median spacing they rest on.

    `spacing` (n,) is the side of the square that each point has to itself, `noise` the sd of a
    point. There are none where the points are on one line.
    """
    if len(flat) > MOST_POINTS:
        kept = np.random.default_rng(0).permutation(len(flat))[:MOST_POINTS]
        flat, spacing = flat[kept], spacing[kept] * np.sqrt(len(flat) / MOST_POINTS)
    typical = float(np.median(spacing))
    if not typical > 0.0:
        return (), typical
    if noise > LEAST_NOISE * typical:
        dense = _is_dense(flat, max(noise, LEAST_SMOOTHING * typical))
        flat, spacing = flat[dense], spacing[dense]
    # of a power of two all multiples are exact
    step = float(np.exp2(np.floor(np.log2(GRID * typical))))
    flat, typical = np.rint(flat / step) * step, float(np.rint(typical / step)) * step
    try:
        triangles = Delaunay(flat).simplices
    except (QhullError, ValueError):
        return (), typical
    # A point that is sparse by its neighbourhood's chance must not let a real gap be bridged.
    reach = ALPHA * np.minimum(spacing, 2.0 * typical)[triangles].mean(axis=1)
    kept_triangles = flat[triangles[_circumradius(flat[triangles]) <= reach]]
    if not len(kept_triangles):
        return (), typical
    whole = join_triangles(kept_triangles)
    width = CLEARED * typical
    closed = whole.buffer(width, join_style="mitre").buffer(-width, join_style="mitre")
    opened = closed.buffer(-width, join_style="mitre").buffer(width, join_style="mitre")
    both = find_intersection(opened, closed, grid_size=GRID * typical)
    pieces = [p for p in shapely.get_parts(both) if p.geom_type == "Polygon"]
    pieces = [_without_pinholes(p, HOLE * typical) for p in pieces if p.area > 0.0]
    pieces.sort(key=lambda piece: -piece.area)
    return tuple(p for p in pieces if p.area >= PIECE_SHARE * pieces[0].area), typical


def _is_dense(flat: FloatArray, width: float) -> NDArray[np.bool_]:
    """Whether there are as many points at each of points (n, 2) as within a blurred rim, (n,).

    Noise carries points 3 sd beyond a face, and along another plane that passes through it; there
    are less than half as many there as on the face. `width` is what density is smoothed by.
    """
    scaled = (flat - flat.min(axis=0)) / (DENSITY_BIN * width)
    if np.prod(scaled.max(axis=0) + 1.0) > MOST_BINS:
        return np.ones(len(flat), dtype=np.bool_)
    bins = np.floor(scaled).astype(np.intp)
    counts = np.zeros(bins.max(axis=0) + 1)
    np.add.at(counts, tuple(bins.T), 1.0)
    density = ndimage.gaussian_filter(counts, 1.0 / DENSITY_BIN, mode="constant")
    sums, squares = (
        ndimage.gaussian_filter(each, AROUND / DENSITY_BIN, mode="constant")
        for each in (density, density**2)
    )
    dense: NDArray[np.bool_] = (density * sums >= RIM_DENSITY * squares)[tuple(bins.T)]
    return dense


def _circumradius(triangles: FloatArray) -> FloatArray:
    """Radii (n,) of the circles through corners (n, 3, 2): r = abc / (4 area)."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    (ax, ay), (bx, by) = np.moveaxis(triangles[:, 1:] - triangles[:, :1], (1, 2), (0, 1))
    twice = np.abs(ax * by - ay * bx)
    radius: FloatArray = sides.prod(axis=1) / np.maximum(2.0 * twice, 1e-300)
    return radius


def _without_pinholes(polygon: shapely.Polygon, width: float) -> shapely.Polygon:
    holes = [r for r in polygon.interiors if not shapely.Polygon(r).buffer(-width / 2.0).is_empty]
    return shapely.Polygon(polygon.exterior, holes)
