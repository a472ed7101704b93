"""The exact scene of one solid that is made of upright cuboids: the surface of their union."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from facetlog.perception.polygons import find_union
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import one_object, polyhedron
from facetlog.perception.types import FloatArray

# Planes nearer to each other than this are one: vertices are exact to a millimetre.
LEAST_LENGTH_M = 0.001
SD_M = 0.001

Loop = list[tuple[float, float, float]]


def cuboid_union(low: ArrayLike, high: ArrayLike, name: str) -> Scene:
    """Return the union of cuboids from corners `low` to `high`, (n, 3) metres, as one thing seen
    all over.

    What lies in one plane and touches is one face, with holes where others stand on it; up is z.
    Raise ValueError if a cuboid is thinner than a millimetre, or they are not one solid.

    >>> scene = cuboid_union([[0, 0, 0.4], [0.2, 0.2, 0]], [[0.6, 0.6, 0.5], [0.4, 0.4, 0.4]], "T")
    >>> len(scene.faces), [len(face.holes) for face in scene.faces if face.holes]
    (11, [1])
    """
    corners = np.stack([np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)])
    planes = [_planes(corners[:, :, axis].ravel()) for axis in range(3)]
    solid = np.zeros([len(along) - 1 for along in planes], dtype=np.bool_)
    for first, last in corners.transpose(1, 0, 2):
        ends = [np.abs(planes[i][:, None] - (first[i], last[i])).argmin(axis=0) for i in range(3)]
        if not all(a < b for a, b in ends):
            raise ValueError(f"a part of the {name} is thinner than {LEAST_LENGTH_M:g} m")
        solid[tuple(slice(a, b) for a, b in ends)] = True
    if ndimage.label(solid)[1] > 1:
        raise ValueError(f"the parts of the {name} do not touch")
    places: dict[tuple[float, ...], int] = {}
    loops: list[list[int]] = []
    holes: dict[int, list[list[int]]] = {}
    for rings in _faces(solid, planes):
        outline, *inner = ([places.setdefault(p, len(places)) for p in ring] for ring in rings)
        if inner:
            holes[len(loops)] = inner
        loops.append(outline)
    scene = polyhedron(list(places), loops, sd=SD_M, name=name, holes=holes)
    return replace(one_object(scene), metric=True)


def _planes(values: FloatArray) -> FloatArray:
    """Return where planes are along an axis, each once."""
    ordered = np.sort(values)
    return ordered[np.diff(ordered, prepend=-np.inf) >= LEAST_LENGTH_M]


def _faces(solid: NDArray[np.bool_], planes: list[FloatArray]) -> Iterator[list[Loop]]:
    """Return each face's rings of points, its outline first: that runs counter-clockwise from
    outside.
    """
    for axis in range(3):
        across = [(axis + 1) % 3, (axis + 2) % 3]
        layers = np.pad(np.moveaxis(solid, (axis, *across), (0, 1, 2)), ((1, 1), (0, 0), (0, 0)))
        u, v = (planes[i] for i in across)
        for nth, height in enumerate(planes[axis].tolist()):
            for outward, shown in (
                (1, layers[nth] & ~layers[nth + 1]),
                (-1, layers[nth + 1] & ~layers[nth]),
            ):
                i, j = np.nonzero(shown)
                cells = shapely.box(u[i], v[j], u[i + 1], v[j + 1])
                for polygon in shapely.get_parts(find_union(cells)):
                    yield [
                        [_point(axis, height, a, b) for a, b in _corners(ring)[::outward]]
                        for ring in _rings(polygon)
                    ]


def _rings(polygon: shapely.Polygon) -> Iterator[shapely.LinearRing]:
    sound = shapely.geometry.polygon.orient(polygon)
    yield sound.exterior
    yield from sound.interiors


def _corners(ring: shapely.LinearRing) -> list[tuple[float, float]]:
    """Return the points at which a ring turns."""
    points = shapely.get_coordinates(ring)[:-1]
    into, out = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    turns = into[:, 0] * out[:, 1] != into[:, 1] * out[:, 0]
    return [(float(a), float(b)) for a, b in points[turns]]


def _point(axis: int, height: float, a: float, b: float) -> tuple[float, float, float]:
    point = np.roll((height, a, b), axis)
    return float(point[0]), float(point[1]), float(point[2])
