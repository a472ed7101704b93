"""Faults of a scene: numbers that no facts can be made of, geometry that contradicts itself."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain

import numpy as np

from facetlog.perception.flat_faces import cross, make_plane_axes
from facetlog.perception.polygons import find_intersection, find_union, make_polygon
from facetlog.perception.ragged import Bools, find_row_starts, stacked
from facetlog.perception.scene import Face, Patch, Scene, Vertex
from facetlog.perception.surfaces.scene_json.scene_fault import SceneFault
from facetlog.perception.types import FloatArray

__all__ = ["LARGEST", "LEAST", "find_scene_faults", "find_unsound_faces", "iter_number_faults"]

# Unit vectors and symmetric matrices written with seven digits are off by less.
ROUNDING = 1e-6
# The variance of a volume, and what is made of it, is still a float: some length to the twelfth.
LARGEST, LEAST = 1e20, 1e-20

BEYOND = f"is beyond {LARGEST:g}: give another unit"
PIXELS_BEYOND = f"is beyond {LARGEST:g}: such a picture is none"
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


def find_scene_faults(scene: Scene) -> Iterator[SceneFault]:
    """Return all faults of a scene's geometry, whose numbers are sound; none if it is sound, too.

    - vertices that no edge, face or patch uses;
    - outlines without area, that cross themselves, or run the wrong way, and holes that lie
      outside of theirs or cross;
    - vertices off their face's plane by more than 5 sd and more than a quarter of its extent.
    """
    yield from _iter_vertex_faults(scene)
    for _, fault in _iter_face_faults(scene.faces, scene.vertices):
        yield fault


def find_unsound_faces(faces: Sequence[Face], vertices: Sequence[Vertex]) -> tuple[int, ...]:
    """Return the indices of the faces that `find_scene_faults` would name in a scene of these
    vertices.
    """
    return tuple(dict.fromkeys(index for index, _ in _iter_face_faults(faces, vertices)))


def _iter_face_faults(
    faces: Sequence[Face], vertices: Sequence[Vertex]
) -> Iterator[tuple[int, SceneFault]]:
    """Return the faults of faces, each with the face's index."""
    if not faces:
        return
    points = stacked([vertex.point for vertex in vertices], 3)
    # Most faces are surely sound, which is found out for all at once.
    for i in np.flatnonzero(~_are_surely_sound(faces, points)).tolist():
        for fault in _iter_outline_faults(f"$.faces[{i}]", faces[i], points):
            yield i, fault
        for fault in _iter_plane_faults(f"$.faces[{i}]", faces[i], vertices, points):
            yield i, fault


def _iter_vertex_faults(scene: Scene) -> Iterator[SceneFault]:
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


def _are_surely_sound(faces: Sequence[Face], points: FloatArray) -> Bools:
    """Return which faces (f,) with vertices (n, 3) have no hole, a convex outline that runs the
    right way, and all corners near their plane.
    """
    lengths = np.array([len(face.outline) for face in faces], dtype=np.intp)
    starts = find_row_starts(lengths)
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


def _iter_outline_faults(place: str, face: Face, points: FloatArray) -> Iterator[SceneFault]:
    """Return what is wrong with the loops of a face."""
    corners = points[list(face.outline)]
    axes = make_plane_axes(face.plane.normal, corners[1] - corners[0])
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
    """Return whether a loop crosses itself: what it encloses is another area than the signed one,
    by more than `slack`.

    Where it only touches itself, as two pieces do that share a corner, it is the same.
    """
    return abs(float(make_polygon(loop).area) - abs(_signed_area(loop))) > slack


def _iter_plane_faults(
    place: str, face: Face, vertices: Sequence[Vertex], points: FloatArray
) -> Iterator[SceneFault]:
    """Return the vertices that are off the plane of a face."""
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


def iter_number_faults(scene: Scene) -> Iterator[SceneFault]:
    """Return all faults of a scene's numbers, each at its JSON path; none if facts can be made of
    them.

    - up, or a normal of a patch, is no unit vector;
    - a covariance is not symmetric, has a negative variance in some direction, or one too large;
    - places, offsets and pixels beyond LARGEST, or a scene smaller than LEAST.
    """
    if scene.up is not None and abs((length := math.hypot(*scene.up)) - 1.0) > ROUNDING:
        yield SceneFault("$.up", f"is {length:.6g} long: give a unit vector, or null")
    points = scene.points
    large = _find_large_rows(points)
    yield from (SceneFault(f"$.vertices[{i}].point", BEYOND) for i in large)
    if len(points) and not large and 0.0 < _compute_widest_extent(points) < LEAST:
        yield SceneFault("$.vertices", f"lie within {LEAST:g} of each other: give another unit")
    covs = stacked([v.cov for v in scene.vertices], 3, 3)
    yield from _iter_covariance_faults(covs, "$.vertices[{}].cov".format)
    yield from _iter_observation_faults(scene)
    for i, face in enumerate(scene.faces):
        if abs(face.plane.offset) > LARGEST:
            yield SceneFault(f"$.faces[{i}].plane.offset", BEYOND)
    planes = stacked([f.plane.cov for f in scene.faces], 4, 4)
    yield from _iter_covariance_faults(planes, "$.faces[{}].plane.cov".format)
    for i, patch in enumerate(scene.patches):
        yield from _iter_patch_faults(f"$.patches[{i}]", patch)
    yield from _iter_sight_faults(scene)


def _compute_widest_extent(points: FloatArray) -> float:
    return float((points.max(axis=0) - points.min(axis=0)).max())


def _find_large_rows(rows: FloatArray) -> list[int]:
    """Return which rows (n, k) hold what is beyond LARGEST."""
    if not len(rows) or np.abs(rows).max() <= LARGEST:
        return []
    return np.flatnonzero((np.abs(rows) > LARGEST).any(axis=1)).tolist()


def _iter_observation_faults(scene: Scene) -> Iterator[SceneFault]:
    seen = list(chain.from_iterable(v.observations for v in scene.vertices))
    if not seen:
        return

    def place(which: int) -> str:
        for i, vertex in enumerate(scene.vertices):
            if which < len(vertex.observations):
                return f"$.vertices[{i}].observations[{which}]"
            which -= len(vertex.observations)
        raise IndexError

    for k in _find_large_rows(stacked([o.uv for o in seen], 2)):
        yield SceneFault(f"{place(k)}.uv", PIXELS_BEYOND)
    covs = stacked([o.cov for o in seen], 2, 2)
    yield from _iter_covariance_faults(covs, lambda k: f"{place(k)}.cov")


def _iter_patch_faults(place: str, patch: Patch) -> Iterator[SceneFault]:
    for j in _find_large_rows(patch.points):
        yield SceneFault(f"{place}.points[{j}]", BEYOND)
    if len(patch.areas) and patch.areas.max() > LARGEST**2:
        j = int(patch.areas.argmax())
        yield SceneFault(f"{place}.areas[{j}]", f"is beyond {LARGEST**2:g}: give another unit")
    # Longer ones are cut off: of what is too large there is no length.
    lengths = np.linalg.norm(np.clip(patch.normals, -2.0, 2.0), axis=1)
    wrong = np.flatnonzero((np.abs(lengths - 1.0) > ROUNDING) & (lengths != 0.0))
    for j in wrong[:1].tolist():
        yield SceneFault(
            f"{place}.normals[{j}]",
            f"is {math.hypot(*patch.normals[j]):.6g} long: give unit vectors, or zeros where not "
            "known" + (f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""),
        )


def _iter_sight_faults(scene: Scene) -> Iterator[SceneFault]:
    """Return faults of lines of sight, and of cameras and where they stood."""
    for i, lines in enumerate(scene.sights):
        if np.abs(lines.origin).max() > LARGEST:
            yield SceneFault(f"$.sights[{i}].origin", BEYOND)
        for j in _find_large_rows(lines.ends)[:1]:
            yield SceneFault(f"$.sights[{i}].ends", f"has a coordinate of point {j} that {BEYOND}")
    for i, seen in enumerate(scene.lattices):
        with np.errstate(over="ignore"):
            reach = seen.steps * np.array(seen.shown.shape[1:])[:, None]
        parts = {"corner": seen.corner[None], "steps": reach, "origins": seen.origins}
        for name, rows in parts.items():
            if _find_large_rows(rows):
                yield SceneFault(f"$.lattices[{i}].{name}", BEYOND)
    for i in _find_large_rows(stacked([pose.centre for pose in scene.poses], 3)):
        yield SceneFault(f"$.cameras[{i}].centre", BEYOND)
    for i, camera in enumerate(scene.cameras):
        optics: dict[str, Sequence[float]] = {
            "size": (camera.width, camera.height),
            "focal": (camera.fx, camera.fy),
            "middle": (camera.cx, camera.cy),
        }
        for name, numbers in optics.items():
            if max(map(abs, numbers)) > LARGEST:
                yield SceneFault(f"$.cameras[{i}].{name}", PIXELS_BEYOND)
        if min(camera.fx, camera.fy) < LEAST:
            yield SceneFault(f"$.cameras[{i}].focal", f"is below {LEAST:g}: such a lens is none")


def _iter_covariance_faults(covs: FloatArray, place: Callable[[int], str]) -> Iterator[SceneFault]:
    """Return which of some matrices (n, k, k) at their places are no covariances, and why."""
    count = len(covs)
    if not count or _are_surely_covariances(covs):
        return
    scale = np.abs(covs).reshape(count, -1).max(axis=1)
    large = scale > LARGEST**2
    # What is too large is not looked into: its sums may be no numbers.
    bounded = np.where(large[:, None, None], 0.0, covs) if large.any() else covs
    slack = ROUNDING * scale
    off = np.abs(bounded - bounded.swapaxes(1, 2)).reshape(count, -1).max(axis=1)
    skew = off > slack
    least = np.linalg.eigvalsh(bounded)[:, 0]
    for i in np.flatnonzero(large | skew | (least < -slack)).tolist():
        if large[i]:
            said = f"has a variance beyond {LARGEST**2:g}: give another unit"
        elif skew[i]:
            said = "is not symmetric: it is no covariance"
        else:
            said = f"has the negative variance {least[i]:.3g} one way: it is no covariance"
        yield SceneFault(place(i), said)


def _are_surely_covariances(covs: FloatArray) -> bool:
    """Return whether all matrices are: two thirds of the time are saved where they are to the last
    bit.
    """
    variances = np.diagonal(covs, axis1=1, axis2=2)
    scale = variances.max(axis=1)
    # No entry of a covariance is larger than the largest variance.
    if not (scale.max() <= LARGEST**2 and (covs == covs.swapaxes(1, 2)).all()):
        return False
    lifted = covs.copy()
    np.einsum("ijj->ij", lifted)[:] = variances + ROUNDING * scale[:, None]
    try:
        np.linalg.cholesky(lifted)
    except np.linalg.LinAlgError:
        return False
    return True
