"""Find pieces of what is open: bars and boards without their hidden sides, and flat layers."""

import numpy as np

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.pieces.exact.assemble_pieces import FoundPieces
from facetlog.perception.pieces.exact.cap_sheets import SHALLOW
from facetlog.perception.pieces.exact.convex_parts import (
    DIRECTIONS,
    Hull,
    find_hull,
    measure_section_roundness,
)
from facetlog.perception.pieces.exact.cut_pieces import CutPiece
from facetlog.perception.pieces.exact.regions import PLANE_SLACK
from facetlog.perception.pieces.exact.sheets import LAYER_SHARE, OpenSheet, Sheets
from facetlog.perception.pieces.pieces import find_least_box
from facetlog.perception.pieces.shown_pieces import SLENDER
from facetlog.perception.ragged import iter_groups
from facetlog.perception.types import FloatArray

# The least share of the surface of an open bar or board that is there: three sides of four of a
# square bar, and some less.
MOST_SIDES = 0.6
# Triangles times planes that are compared.
MOST_COMPARED = 1_000_000
# Sides of a board lie along each other to this cosine, half a degree, and are alike in extent but
# for this share.
EVEN = np.cos(np.radians(0.5))
SAME_SIDE = 0.05

# Extents (3,), axes (3, 3) as rows, and middle (3,).
_Box = tuple[FloatArray, FloatArray, FloatArray]


def add_open_parts(sheets: Sheets, found: FoundPieces) -> None:
    """Add bars and boards of which hidden sides are missing, and flat layers as thin boards."""
    _add_layers(sheets, _add_bars(sheets, found), found)


def _add_bars(sheets: Sheets, found: FoundPieces) -> list[FloatArray]:
    """Add bars and boards of which hidden sides are missing; return the layers of other open
    sheets, of which what is in no layer stays open.
    """
    layers = []
    for loose in sheets.loose:
        large = len(loose.layers) != 1 and loose.area > LAYER_SHARE * sheets.surface
        hull = find_hull(loose.corners.reshape(-1, 3)) if large else None
        box = None if hull is None else _find_bar(loose, hull)
        if hull is None or box is None:
            layers += loose.layers
            if loose.bare > 0.0:
                found.open_area += loose.bare
                spots = loose.corners.reshape(-1, 3) + sheets.centre
                found.left.append(np.stack([spots.min(axis=0), spots.max(axis=0)]))
                found.left_volumes.append(0.0)
            continue
        _add_hull(sheets, found, hull, box, box[1])
    return layers


def _find_bar(loose: OpenSheet, hull: Hull) -> _Box | None:
    """Return extents, axes and middle of an open sheet that is most of a bar or a board."""
    if loose.area < MOST_SIDES * hull.area or len(loose.corners) * len(hull.planes) > MOST_COMPARED:
        return None
    sides = loose.corners[:, 1:] - loose.corners[:, :1]
    normals = np.cross(sides[:, 0], sides[:, 1])
    double = np.linalg.norm(normals, axis=1)
    off = (loose.corners.mean(axis=1) @ hull.planes[:, :3].T + hull.planes[:, 3]).max(axis=1)
    largest = np.argsort(-double, kind="stable")[:DIRECTIONS]
    box = find_least_box(hull.points, list(normals[largest] / double[largest, None]), 0.0)
    length, width, thickness = box[0]
    even = off.min() > -SAME_SIDE * thickness
    bar = width < SLENDER * length or thickness < SHALLOW * np.sqrt(length * width)
    return box if even and bar else None


def _add_layers(sheets: Sheets, flat: list[FloatArray], found: FoundPieces) -> None:
    """Add boards of layers: two that are the sides of a board without edges are one; others are as
    thick as places are known, so that they have a hull.
    """
    layers = []
    for corners in flat:
        centred = corners - corners.mean(axis=0)
        normal = np.linalg.svd(centred, full_matrices=False)[2][2]
        layers.append((corners - (centred @ normal)[:, None] * normal, normal))
    number = np.arange(len(layers))
    normals = np.array([normal for _, normal in layers]).reshape(-1, 3)
    for one, two in np.argwhere(np.triu(np.abs(normals @ normals.T) > EVEN, 1)).tolist():
        one_side, two_side = layers[one][0], layers[two][0]
        if (number[[one, two]] == (one, two)).all() and _is_board(one_side, two_side, normals[one]):
            number[two] = one
    for own in iter_groups(number):
        normal = normals[own[0]]
        points = np.concatenate([layers[i][0] for i in own])
        if len(own) == 1:
            half = PLANE_SLACK * sheets.slack * normal
            points = np.concatenate([points - half, points + half])
        hull = find_hull(points)
        if hull is None:
            continue
        box = find_least_box(hull.points, [normal], 0.0)
        _add_hull(sheets, found, hull, box, normal[None])


def _is_board(one: FloatArray, two: FloatArray, normal: FloatArray) -> bool:
    """Return whether two level layers of points (n, 3), (m, 3) are sides of a board."""
    across = make_plane_axes(normal, np.eye(3)[np.abs(normal).argmin()])
    sizes = [np.ptp(side @ across.T, axis=0) for side in (one, two)]
    both = np.ptp(np.concatenate([one, two]) @ across.T, axis=0)
    apart = abs(float((one[0] - two[0]) @ normal))
    same = (both * (1.0 - SAME_SIDE) <= np.minimum(*sizes)).all()
    return bool(same and apart < SHALLOW * float(np.sqrt(both.prod())))


def _add_hull(sheets: Sheets, found: FoundPieces, hull: Hull, box: _Box, ways: FloatArray) -> None:
    """Add a piece of no body, as round as its roundest section across one of the ways (k, 3)."""
    extents, axes, middle = box
    round_ = max(measure_section_roundness(hull.points, way) for way in ways)
    place = (hull.points + sheets.centre, axes, middle + sheets.centre, extents)
    found.pieces.append(CutPiece(*place, round_, hull.volume))
    found.hulls.append(hull)
    found.body.append(-1 - len(found.body))
