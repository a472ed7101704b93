"""Caps of open sheets: ends that a mesh leaves away because nobody sees them.

A leg whose end lies on a table top is often modelled without that end. Its border is a flat loop
that runs all along another sheet: a cap closes it. So are ends of bars, undersides of boards, and
what stands on the ground. Any other border is where a box or a bucket is open, and stays open.
"""

from collections.abc import Iterator

import numpy as np
import shapely

from facetlog.perception.flat_faces import compute_vector_area, make_plane_axes
from facetlog.perception.polygons import triangulate
from facetlog.perception.ragged import Bools, Indices
from facetlog.perception.types import FloatArray

# Borders of more corners than this are looked at in too many places.
MOST_CORNERS = 200
# Sheets with borders that are looked at, at most: what falls to pieces has thousands.
MOST_OPEN = 200
# A corner of a border lies on another sheet within so many times what a corner is known to.
NEAR = 8.0
# The end of a bar takes less of its surface: .087 where its width is .35 of its length.
END = 0.1
# A board is less deep than this share of the square root of its underside, a tray is deeper.
SHALLOW = 0.1
# A loop that turns inwards by as much (radians) at every corner is filled from its first corner.
FAN_TURN = 1e-3


def find_caps(
    points: FloatArray,
    triangles: Indices,
    sheet: Indices,
    is_open: Bools,
    slack: float,
    up: FloatArray | None,
) -> tuple[Indices, Indices]:
    """Return triangles (k, 3) that close sheets, and triangles (k,) of the sheets that they are of.

    Of triangles (m, 3) of points (n, 3), `sheet` (m,) is the sheet and `is_open` (m, 3) says which
    sides, from each corner to the next, have no neighbour.
    """
    ground = None if up is None else (up, float((points @ up)[triangles].min()) + NEAR * slack)
    caps: list[Indices] = []
    of: list[int] = []
    sheets = np.unique(sheet[is_open.any(axis=1)])
    for number in sheets.tolist() if len(sheets) <= MOST_OPEN else ():
        rows = np.flatnonzero(sheet == number)
        loops = list(_iter_loops(triangles[rows], is_open[rows]))
        if not loops or any(len(loop) > MOST_CORNERS for loop in loops):
            continue
        others = points[triangles[sheet != number]]
        made = [cap_loop(points, loop, slack) for loop in loops]
        if any(cap is None for cap in made) or not all(
            _is_unseen(points[loop], points[triangles[rows]], ground)
            or _lies_on(points[loop], others, NEAR * slack)
            for loop in loops
        ):
            continue
        for cap in made:
            if cap is not None:
                caps.append(cap)
                of += [int(rows[0])] * len(cap)
    if not caps:
        return np.zeros((0, 3), dtype=np.int64), np.zeros(0, dtype=np.int64)
    return np.concatenate(caps).astype(np.int64), np.array(of, dtype=np.int64)


def _is_unseen(
    loop: FloatArray, corners: FloatArray, ground: tuple[FloatArray, float] | None
) -> bool:
    """Return whether a loop (k, 3) of a sheet of triangles (m, 3, 3) bounds the end of a bar, the
    underside of a board, or what stands on the ground: below a height along an axis.
    """
    if ground is not None and (loop @ ground[0]).max() <= ground[1]:
        return True
    across = compute_vector_area(loop)
    area = float(np.linalg.norm(across))
    sides = corners[:, 1:] - corners[:, :1]
    surface = float(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum()) / 2.0
    depth = float(np.abs((corners - loop[0]) @ across).max()) / area
    return area < END * surface or depth < SHALLOW * np.sqrt(area)


def _iter_loops(triangles: Indices, is_open: Bools) -> Iterator[list[int]]:
    """Yield the closed borders of a sheet, as its sides run; nothing if a corner is of two."""
    ends = np.roll(triangles, -1, axis=1)[is_open]
    after = dict(zip(triangles[is_open].tolist(), ends.tolist(), strict=True))
    if len(after) != len(ends) or set(after) != set(ends.tolist()):
        return
    while after:
        first, here = after.popitem()
        loop = [first]
        while here != first:
            loop.append(here)
            here = after.pop(here)
        yield loop


def cap_loop(points: FloatArray, loop: list[int], slack: float) -> Indices | None:
    """Return triangles (k, 3) that fill a flat loop, wound as its sheet is; None if it is not
    flat.
    """
    corners = points[loop]
    area = compute_vector_area(corners)
    size = float(np.linalg.norm(area))
    extent = float(np.linalg.norm(np.ptp(corners, axis=0)))
    if not size > slack * extent:
        return None
    normal = area / size
    if np.abs((corners - corners[0]) @ normal).max() > NEAR * slack:
        return None
    axes = make_plane_axes(normal, corners[1] - corners[0])
    flat = (corners - corners[0]) @ axes.T
    sides = np.roll(flat, -1, axis=0) - flat
    after = np.roll(sides, -1, axis=0)
    turns = np.arctan2(
        sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0], (sides * after).sum(axis=1)
    )
    if turns.min() > FAN_TURN and turns.sum() < 3.0 * np.pi:
        fan = np.arange(1, len(loop) - 1)
        return np.array(loop)[np.column_stack([fan + 1, fan, np.zeros_like(fan)])]
    polygon = shapely.Polygon(flat)
    if not polygon.is_valid:
        return None
    filled = triangulate(polygon)
    gaps = np.linalg.norm(filled[:, :, None] - flat, axis=3)
    if gaps.min(axis=2).max() > slack:
        return None
    cap = np.array(loop)[gaps.argmin(axis=2)]
    (ax, ay), (bx, by) = np.moveaxis(filled[:, 1:] - filled[:, :1], (1, 2), (0, 1))
    # the border runs against its cap
    upwards = ax * by - ay * bx > 0.0
    cap[upwards] = cap[upwards][:, ::-1]
    found: Indices = cap
    return found


def _lies_on(corners: FloatArray, triangles: FloatArray, slack: float) -> bool:
    """Return whether corners (k, 3) of a loop, and the middles of its sides, all lie on other
    triangles (m, 3, 3).
    """
    places = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2.0])
    low, high = places.min(axis=0) - slack, places.max(axis=0) + slack
    near = triangles[((triangles.max(axis=1) >= low) & (triangles.min(axis=1) <= high)).all(axis=1)]
    if not len(near):
        return False
    a = near[:, 0]
    sides = near[:, 1:] - a[:, None]
    normal = np.cross(sides[:, 0], sides[:, 1])
    double = np.linalg.norm(normal, axis=1)
    sound = double > 0.0
    a, sides, near = a[sound], sides[sound], near[sound]
    normal = normal[sound] / double[sound, None]
    away = places[:, None] - a[None]
    on = np.abs(np.einsum("kmi,mi->km", away, normal)) <= slack
    for k in range(3):
        start = near[:, k]
        along = near[:, (k + 1) % 3] - start
        inner = np.cross(normal, along)
        inner /= np.maximum(np.linalg.norm(inner, axis=1), 1e-300)[:, None]
        on &= np.einsum("kmi,mi->km", places[:, None] - start[None], inner) >= -slack
    return bool(on.any(axis=1).all())
