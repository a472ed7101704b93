"""What is wrong with the numbers of a scene: covariances that are none, and lengths whose areas and
volumes no float holds.
"""

from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

import numpy as np

from facetlog.perception.scene import Scene
from facetlog.perception.types import FloatArray

__all__ = ["LARGEST", "LEAST", "ROUNDING", "SceneFault", "number_faults"]

# Unit vectors and symmetric matrices written with seven digits are off by less.
ROUNDING = 1e-6
# The square of a volume, some length to the sixth, is still a float.
LARGEST, LEAST = 1e50, 1e-50


class SceneFault(NamedTuple):
    """What is wrong in a scene file, and where: a JSON path as $.faces[3].outline."""

    path: str
    message: str

    def __str__(self) -> str:
        return f"{self.path}: {self.message}"


def number_faults(scene: Scene) -> Iterator[SceneFault]:
    """All faults of a scene's numbers, each at its JSON path; none if facts can be made of them.

    - a covariance is not symmetric, has a negative variance in some direction, or one too large;
    - places and offsets beyond LARGEST, or a scene smaller than LEAST.
    """
    points = scene.points
    large = np.flatnonzero((np.abs(points) > LARGEST).any(axis=1))
    for i in large.tolist():
        yield SceneFault(f"$.vertices[{i}].point", f"is beyond {LARGEST:g}: give another unit")
    if len(points) and not len(large) and 0 < np.ptp(points, axis=0).max() < LEAST:
        yield SceneFault("$.vertices", f"lie within {LEAST:g} of each other: give another unit")
    covs = np.array([v.cov for v in scene.vertices]).reshape(-1, 3, 3)
    yield from _covariance_faults([f"$.vertices[{i}].cov" for i in range(len(covs))], covs)
    yield from _observation_faults(scene)
    for i, face in enumerate(scene.faces):
        if abs(face.plane.offset) > LARGEST:
            yield SceneFault(
                f"$.faces[{i}].plane.offset", f"is beyond {LARGEST:g}: give another unit"
            )
    planes = np.array([f.plane.cov for f in scene.faces]).reshape(-1, 4, 4)
    yield from _covariance_faults([f"$.faces[{i}].plane.cov" for i in range(len(planes))], planes)


def _observation_faults(scene: Scene) -> Iterator[SceneFault]:
    seen = list(chain.from_iterable(v.observations for v in scene.vertices))
    covs = np.array([o.cov for o in seen]).reshape(-1, 2, 2)
    wrong = tuple(_wrong(covs))
    if wrong:
        places = [
            f"$.vertices[{i}].observations[{j}].cov"
            for i, v in enumerate(scene.vertices)
            for j in range(len(v.observations))
        ]
        yield from (SceneFault(places[k], said) for k, said in wrong)


def _covariance_faults(places: list[str], covs: FloatArray) -> Iterator[SceneFault]:
    yield from (SceneFault(places[k], said) for k, said in _wrong(covs))


def _wrong(covs: FloatArray) -> Iterator[tuple[int, str]]:
    """Which of some matrices (n, k, k) are no covariances, and why."""
    if not len(covs):
        return
    scale = np.abs(covs).max(axis=(1, 2))
    large = scale > LARGEST**2
    # What is too large is not looked into: its sums may be no numbers.
    bounded = np.where(large[:, None, None], 0.0, covs)
    turned = bounded.swapaxes(1, 2)
    skew = np.abs(bounded - turned).max(axis=(1, 2)) > ROUNDING * scale
    least = np.linalg.eigvalsh((bounded + turned) / 2.0)[:, 0]
    for i in np.flatnonzero(large | skew | (least < -ROUNDING * scale)).tolist():
        if large[i]:
            yield i, f"has a variance beyond {LARGEST**2:g}: give another unit"
        elif skew[i]:
            yield i, "is not symmetric: it is no covariance"
        else:
            yield i, f"has the negative variance {least[i]:.3g} one way: it is no covariance"
