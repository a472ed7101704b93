"""What is wrong with a scene whose numbers are sound: geometry that contradicts itself."""

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from facetlog.perception.flat_faces import cross, plane_axes
from facetlog.perception.polygons import find_intersection, find_union, make_polygon
from facetlog.perception.ragged import Bools, row_starts, stacked
from facetlog.perception.scene import Face, Scene, Vertex
from facetlog.perception.surfaces.scene_json.scene_fault import SceneFault
from facetlog.perception.types import FloatArray

__all__ = ["scene_faults", "unsound_faces"]

# A vertex is off its face's plane beyond both: chance gives 5 sd once in two million, and what is
# off by a quarter of the face's extent is no flat face. Of meshes whose faces share vertices these
# lie where they fit all of them best: up to 7 % off.
OFF_SDS, OFF_SHARE = 5.0, 0.25
# A face with less area than this share of its extent, squared, is a line.
LEAST_AREA = 1e-9
# Loops cross if that takes or gives as large a share of their area; of less, facts are made of what
# is enclosed. Rims of meshes, about as wide as their noise, cross themselves by up to 5 %.
CROSSED_SHARE = 0.25
# A loop of so many corners that turns left at each goes round once.
FEW_CORNERS = 4
# Of many vertices that nothing uses so many are named.
NAMED = 5


def scene_faults(scene: Scene) -> Iterator[SceneFault]:
    """All faults of a scene's geometry, whose numbers are sound; none if it is sound, too.

    - vertices that no edge, face or patch uses;
    - outlines without area, that cross themselves, or run the wrong way, and holes that lie
      outside of theirs or cross;
    - vertices off their face's plane by more than 5 sd and more than a quarter of its extent.
    """
    yield from _vertex_faults(scene)
    for _, fault in _face_faults(scene.faces, scene.vertices):
        yield fault


def unsound_faces(faces: Sequence[Face], vertices: Sequence[Vertex]) -> tuple[int, ...]:
    """The indices of the faces that `scene_faults` would name in a scene of these vertices."""
    return tuple(dict.fromkeys(index for index, _ in _face_faults(faces, vertices)))


def _face_faults(
    faces: Sequence[Face], vertices: Sequence[Vertex]
) -> Iterator[tuple[int, SceneFault]]:
    """The faults of faces, each with the face's index."""
    if not faces:
        return
    points = stacked([vertex.point for vertex in vertices], 3)
    # Most faces are surely sound, which is found out for all at once.
    for i in np.flatnonzero(~_surely_sound(faces, points)).tolist():
        for fault in _outline_faults(f"$.faces[{i}]", faces[i], points):
            yield i, fault
        for fault in _plane_faults(f"$.faces[{i}]", faces[i], vertices, points):
            yield i, fault


def _vertex_faults(scene: Scene) -> Iterator[SceneFault]:
    used = set(chain.from_iterable(face.outline for face in scene.faces))
    if len(used) < len(scene.vertices):  # most often an outline has them all
        used.update(chain.from_iterable(hole for face in scene.faces for hole in face.holes))
        used.update(chain.from_iterable((edge.start, edge.end) for edge in scene.edges))
        used.update(chain.from_iterable(patch.hull for patch in scene.patches))
    if len(used) < len(scene.vertices):
        unused = [i for i in range(len(scene.vertices)) if i not in used]
        named = ", ".join(map(str, unused[:NAMED])) + (", …" if len(unused) > NAMED else "")
        yield SceneFault(
            "$.vertices",
            f"no edge, face or patch uses {len(unused)} of {len(scene.vertices)} ({named}): "
            "remove them",
        )


def _surely_sound(faces: Sequence[Face], points: FloatArray) -> Bools:
    """Which faces (f,) with vertices (n, 3) have no hole, a convex outline that runs the right way,
    and all corners near their plane.
    """
    lengths = np.array([len(face.outline) for face in faces], dtype=np.intp)
    starts = row_starts(lengths)
    face = np.repeat(np.arange(len(faces)), lengths)
    corners = points[np.fromiter(chain.from_iterable(f.outline for f in faces), np.intp, len(face))]
    normals = stacked([f.plane.normal for f in faces], 3)[face]
    after = np.arange(1, len(face) + 1)
    after[starts + lengths - 1] = starts

    sides = corners[after] - corners
    # A convex loop has more area than the triangle of any three corners that follow each other.
    turns = np.einsum("ij,ij->i", cross(sides, sides[after]), normals)
    left = turns > 2.0 * LEAST_AREA * np.square(points.max(axis=0) - points.min(axis=0)).sum()
    away = np.einsum("ij,ij->i", corners, normals) + np.array([f.plane.offset for f in faces])[face]
    longest = np.maximum.reduceat(np.einsum("ij,ij->i", sides, sides), starts)
    near = away * away <= OFF_SHARE**2 * longest[face]
    found = np.logical_and.reduceat(left & near, starts) & [not f.holes for f in faces]
    if lengths.max() > FEW_CORNERS:
        # It turns round once if its sides turn towards the first of them once.
        towards = np.einsum("ij,ij->i", sides, sides[starts][face]) >= 0.0
        found &= np.add.reduceat(towards[after] > towards, starts, dtype=np.intp) == 1
    return np.asarray(found)


def _outline_faults(place: str, face: Face, points: FloatArray) -> Iterator[SceneFault]:
    """What is wrong with the loops of a face."""
    corners = points[list(face.outline)]
    axes = plane_axes(face.plane.normal, corners[1] - corners[0])
    outline, *holes = (
        (points[list(loop)] - corners[0]) @ axes.T for loop in (face.outline, *face.holes)
    )
    area, extent = _signed_area(outline), _extent(outline)
    if abs(area) <= LEAST_AREA * extent**2:
        crosses = _is_crossed(outline, LEAST_AREA * extent**2)
        said = "crosses itself and has no area" if crosses else "has no area"
        yield SceneFault(f"{place}.outline", said)
        return
    enclosed = make_polygon(outline)
    sound, slack = True, CROSSED_SHARE * min(abs(area), float(enclosed.area))
    for j, loop in enumerate((outline, *holes)):
        if _is_crossed(loop, slack):
            sound = False
            yield SceneFault(
                f"{place}.holes[{j - 1}]" if j else f"{place}.outline",
                "crosses itself: give its vertices in their order round it",
            )
    if sound and area < 0.0:
        yield SceneFault(
            f"{place}.outline", "runs clockwise seen from outside: reverse it, or the plane"
        )
    if sound and holes:
        stated = sum(abs(_signed_area(hole)) for hole in holes)
        taken = find_union([make_polygon(hole) for hole in holes])
        within = float(find_intersection(enclosed, taken).area)
        if stated - within > CROSSED_SHARE * stated:
            yield SceneFault(f"{place}.holes", "lie outside the outline, or cross it or each other")


def _signed_area(loop: FloatArray) -> float:
    x, y = (loop - loop[0]).T
    return float(x[:-1] @ y[1:] - y[:-1] @ x[1:]) / 2.0


def _extent(loop: FloatArray) -> float:
    return float(np.hypot(*(loop.max(axis=0) - loop.min(axis=0))))


def _is_crossed(loop: FloatArray, slack: float) -> bool:
    """Whether a loop crosses itself: what it encloses is another area than the signed one, by more
    than `slack`.

    Where it only touches itself, as two pieces do that share a corner, it is the same.
    """
    return abs(float(make_polygon(loop).area) - abs(_signed_area(loop))) > slack


def _plane_faults(
    place: str, face: Face, vertices: Sequence[Vertex], points: FloatArray
) -> Iterator[SceneFault]:
    """The vertices that are off the plane of a face."""
    outline = points[list(face.outline)]
    extent = float(np.linalg.norm(outline.max(axis=0) - outline.min(axis=0)))
    loops = {f"{place}.outline": face.outline}
    loops |= {f"{place}.holes[{j}]": hole for j, hole in enumerate(face.holes)}
    for name, loop in loops.items():
        away = np.abs(face.plane.distance(points[list(loop)]))
        for j in np.flatnonzero(away > OFF_SHARE * extent).tolist():
            vertex = vertices[loop[j]]
            lever = np.append(vertex.point, 1.0)
            # var d = (p, 1) C (p, 1)ᵀ + nᵀ V n
            variance = lever @ face.plane.cov @ lever
            variance += face.plane.normal @ vertex.cov @ face.plane.normal
            if away[j] > OFF_SDS * np.sqrt(max(variance, 0.0)):
                yield SceneFault(
                    f"{name}[{j}]",
                    f"vertex {loop[j]} is {away[j]:.3g} off the face's plane, where the face is "
                    f"{extent:.3g} wide",
                )
