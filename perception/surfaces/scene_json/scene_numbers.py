"""What is wrong with the numbers of a scene: covariances that are none, directions that are not of
unit length, and lengths whose areas and volumes no float holds.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain

import numpy as np

from facetlog.perception.ragged import stacked
from facetlog.perception.scene import Patch, Scene
from facetlog.perception.surfaces.scene_json.scene_fault import SceneFault
from facetlog.perception.types import FloatArray

__all__ = ["LARGEST", "LEAST", "ROUNDING", "number_faults"]

# Unit vectors and symmetric matrices written with seven digits are off by less.
ROUNDING = 1e-6
# The variance of a volume, and what is made of it, is still a float: some length to the twelfth.
LARGEST, LEAST = 1e20, 1e-20

BEYOND = f"is beyond {LARGEST:g}: give another unit"
PIXELS_BEYOND = f"is beyond {LARGEST:g}: such a picture is none"


def number_faults(scene: Scene) -> Iterator[SceneFault]:
    """All faults of a scene's numbers, each at its JSON path; none if facts can be made of them.

    - up, or a normal of a patch, is no unit vector;
    - a covariance is not symmetric, has a negative variance in some direction, or one too large;
    - places, offsets and pixels beyond LARGEST, or a scene smaller than LEAST.
    """
    if scene.up is not None and abs((length := math.hypot(*scene.up)) - 1.0) > ROUNDING:
        yield SceneFault("$.up", f"is {length:.6g} long: give a unit vector, or null")
    points = scene.points
    large = _large(points)
    yield from (SceneFault(f"$.vertices[{i}].point", BEYOND) for i in large)
    if len(points) and not large and 0.0 < _extent(points) < LEAST:
        yield SceneFault("$.vertices", f"lie within {LEAST:g} of each other: give another unit")
    covs = stacked([v.cov for v in scene.vertices], 3, 3)
    yield from _covariance_faults(covs, "$.vertices[{}].cov".format)
    yield from _observation_faults(scene)
    for i, face in enumerate(scene.faces):
        if abs(face.plane.offset) > LARGEST:
            yield SceneFault(f"$.faces[{i}].plane.offset", BEYOND)
    planes = stacked([f.plane.cov for f in scene.faces], 4, 4)
    yield from _covariance_faults(planes, "$.faces[{}].plane.cov".format)
    for i, patch in enumerate(scene.patches):
        yield from _patch_faults(f"$.patches[{i}]", patch)
    yield from _sight_faults(scene)


def _extent(points: FloatArray) -> float:
    return float((points.max(axis=0) - points.min(axis=0)).max())


def _large(rows: FloatArray) -> list[int]:
    """Which rows (n, k) hold what is beyond LARGEST."""
    if not len(rows) or np.abs(rows).max() <= LARGEST:
        return []
    return np.flatnonzero((np.abs(rows) > LARGEST).any(axis=1)).tolist()


def _observation_faults(scene: Scene) -> Iterator[SceneFault]:
    seen = list(chain.from_iterable(v.observations for v in scene.vertices))
    if not seen:
        return

    def place(which: int) -> str:
        for i, vertex in enumerate(scene.vertices):
            if which < len(vertex.observations):
                return f"$.vertices[{i}].observations[{which}]"
            which -= len(vertex.observations)
        raise IndexError

    for k in _large(stacked([o.uv for o in seen], 2)):
        yield SceneFault(f"{place(k)}.uv", PIXELS_BEYOND)
    covs = stacked([o.cov for o in seen], 2, 2)
    yield from _covariance_faults(covs, lambda k: f"{place(k)}.cov")


def _patch_faults(place: str, patch: Patch) -> Iterator[SceneFault]:
    for j in _large(patch.points):
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


def _sight_faults(scene: Scene) -> Iterator[SceneFault]:
    """Faults of lines of sight, and of cameras and where they stood."""
    for i, lines in enumerate(scene.sights):
        if np.abs(lines.origin).max() > LARGEST:
            yield SceneFault(f"$.sights[{i}].origin", BEYOND)
        for j in _large(lines.ends)[:1]:
            yield SceneFault(f"$.sights[{i}].ends", f"has a coordinate of point {j} that {BEYOND}")
    for i, seen in enumerate(scene.lattices):
        with np.errstate(over="ignore"):
            reach = seen.steps * np.array(seen.shown.shape[1:])[:, None]
        parts = {"corner": seen.corner[None], "steps": reach, "origins": seen.origins}
        for name, rows in parts.items():
            if _large(rows):
                yield SceneFault(f"$.lattices[{i}].{name}", BEYOND)
    for i in _large(stacked([pose.centre for pose in scene.poses], 3)):
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


def _covariance_faults(covs: FloatArray, place: Callable[[int], str]) -> Iterator[SceneFault]:
    """Which of some matrices (n, k, k) at their places are no covariances, and why."""
    count = len(covs)
    if not count or _surely_covariances(covs):
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


def _surely_covariances(covs: FloatArray) -> bool:
    """Whether all matrices are: two thirds of the time are saved where they are to the last bit."""
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
