"""What is wrong with a scene that can be read: geometry that contradicts itself."""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.scene import Face, Scene
from facetlog.perception.surfaces.scene_numbers import ROUNDING, SceneFault
from facetlog.perception.types import FloatArray

__all__ = ["scene_faults"]

# A vertex is off its face's plane beyond both: chance gives 5 sd once in two million, and what is
# below 1 % of the face's extent changes no measure that a model asks for.
OFF_SDS, OFF_SHARE = 5.0, 0.01
# A face with less area than this share of its extent, squared, is a line.
LEAST_AREA = 1e-9
# Of many vertices that nothing uses so many are named.
NAMED = 5


def scene_faults(scene: Scene) -> Iterator[SceneFault]:
    """All faults of a scene in the order of its file; none if it is sound.

    - up is no unit vector;
    - vertices that no edge, face or patch uses;
    - outlines and holes without area, that cross themselves or each other, or run the wrong way;
    - vertices off their face's plane by more than 5 sd and more than 1 % of the face's extent;
    - normals of a patch that are neither unit vectors nor zero.
    """
    if scene.up is not None:
        length = float(np.linalg.norm(scene.up))
        if abs(length - 1.0) > ROUNDING:
            yield SceneFault("$.up", f"is {length:.6g} long: give a unit vector, or null")
    yield from _vertex_faults(scene)
    points = scene.points
    for i, face in enumerate(scene.faces):
        place = f"$.faces[{i}]"
        yield from _outline_faults(place, face, points)
        yield from _plane_faults(place, face, scene)
    for i, patch in enumerate(scene.patches):
        lengths = np.linalg.norm(patch.normals, axis=1)
        wrong = np.flatnonzero((np.abs(lengths - 1.0) > ROUNDING) & (lengths != 0.0))
        for j in wrong[:1].tolist():
            yield SceneFault(
                f"$.patches[{i}].normals[{j}]",
                f"is {lengths[j]:.6g} long: give unit vectors, or zeros where not known"
                + _more(len(wrong)),
            )


def _more(count: int) -> str:
    return f" (and {count - 1} more)" if count > 1 else ""


def _vertex_faults(scene: Scene) -> Iterator[SceneFault]:
    used = {i for face in scene.faces for ring in (face.outline, *face.holes) for i in ring}
    used |= {i for edge in scene.edges for i in (edge.start, edge.end)}
    used |= {i for patch in scene.patches for i in patch.hull}
    unused = [i for i in range(len(scene.vertices)) if i not in used]
    if unused:
        named = ", ".join(map(str, unused[:NAMED])) + (", …" if len(unused) > NAMED else "")
        yield SceneFault(
            "$.vertices",
            f"no edge, face or patch uses {len(unused)} of {len(scene.vertices)} ({named}): "
            "remove them",
        )


def _outline_faults(place: str, face: Face, points: FloatArray) -> Iterator[SceneFault]:
    corners = points[list(face.outline)]
    start = corners[0]
    axes = plane_axes(face.plane.normal, corners[1] - start)
    rings = [(points[list(r)] - start) @ axes.T for r in (face.outline, *face.holes)]
    names = [f"{place}.outline", *(f"{place}.holes[{j}]" for j in range(len(face.holes)))]
    areas = [_signed_area(ring) for ring in rings]
    sound = True
    for j, (ring, name) in enumerate(zip(rings, names, strict=True)):
        for said in _ring_fault(ring, areas[j], hole=j > 0):
            sound = False
            yield SceneFault(name, said)
    if sound and len(rings) > 1:
        open_area = abs(areas[0]) - sum(map(abs, areas[1:]))
        if _is_crossed(shapely.Polygon(rings[0], rings[1:]), open_area, rings[0]):
            yield SceneFault(f"{place}.holes", "lie outside the outline, or cross it or each other")


def _signed_area(ring: FloatArray) -> float:
    x, y = (ring - ring[0]).T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2.0


def _extent(ring: FloatArray) -> float:
    return float(np.linalg.norm(np.ptp(ring, axis=0)))


def _is_crossed(polygon: shapely.Polygon, area: float, ring: FloatArray) -> bool:
    """Whether loops of that area together cross: what they enclose is another area.

    Where they only touch, as two pieces do that share a corner, it is the same.
    """
    if polygon.is_valid:
        return False
    enclosed = float(shapely.make_valid(polygon).area)
    return abs(enclosed - area) > ROUNDING * _extent(ring) ** 2


def _ring_fault(ring: FloatArray, area: float, *, hole: bool) -> Iterator[str]:
    """What is wrong with a loop (k, 2) as seen from outside, if anything is."""
    crossed = _is_crossed(shapely.Polygon(ring), abs(area), ring)
    if abs(area) <= LEAST_AREA * _extent(ring) ** 2:
        yield "crosses itself and has no area" if crossed else "has no area"
    elif crossed:
        yield "crosses itself: give its vertices in their order round it"
    elif not hole and area < 0.0:
        yield "runs clockwise seen from outside: reverse it, or the plane"


def _plane_faults(place: str, face: Face, scene: Scene) -> Iterator[SceneFault]:
    """The vertices that are off the plane of a face."""
    for name, ring in _rings(place, face):
        own = scene.points[list(ring)]
        covs = np.array([scene.vertices[i].cov for i in ring])
        levers = np.column_stack([own, np.ones(len(own))])
        away = np.abs(face.plane.distance(own))
        # var d = (p, 1) C (p, 1)ᵀ + nᵀ V n
        variance = np.einsum("ij,jk,ik->i", levers, face.plane.cov, levers)
        variance += np.einsum("j,ijk,k->i", face.plane.normal, covs, face.plane.normal)
        sds = np.sqrt(np.maximum(variance, 0.0))
        extent = float(np.linalg.norm(np.ptp(scene.points[list(face.outline)], axis=0)))
        for j in np.flatnonzero((away > OFF_SDS * sds) & (away > OFF_SHARE * extent)).tolist():
            yield SceneFault(
                f"{name}[{j}]",
                f"vertex {ring[j]} is {away[j]:.3g} off the face's plane, "
                f"{away[j] / extent:.1%} of its extent",
            )


def _rings(place: str, face: Face) -> Sequence[tuple[str, tuple[int, ...]]]:
    holes = ((f"{place}.holes[{j}]", hole) for j, hole in enumerate(face.holes))
    return ((f"{place}.outline", face.outline), *holes)
