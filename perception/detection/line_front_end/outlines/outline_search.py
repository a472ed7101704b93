"""Closed outlines on a plane: polygons of 3 to 6 sides whose every side the pictures show."""

from dataclasses import dataclass
from functools import cache
from itertools import combinations, permutations

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import LineProfiles
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray

# Lines of a plane that take part, best first; more sides allow fewer lines (all subsets are tried).
MAX_LINES = {3: 14, 4: 14, 5: 9, 6: 8}
# Least coverage of any side: what other things hide of a true one is rarely more than a third.
MIN_COVERAGE = 0.6
# Least turn at a corner: the paper's 30 degrees, less what perspective and noise take.
MIN_TURN_SINE = np.sin(np.radians(20.0))
# Sides shorter, or outlines thinner, than this many px are below what a segment detector finds.
MIN_SIDE_PX = 10.0
# A notch costs no length, and texture offers many: outlines that are not plain need more support.
# A true L still wins over its rectangle, half of whose two false sides is missing.
COMPLEXITY = 0.1
# Outlines kept for one plane, before views judge them.
KEEP = 12


@dataclass(frozen=True, eq=False, slots=True)
class Outline:
    """A polygon: corners (k, 3); side i, on line `lines[i]`, runs from corner i to corner i + 1.

    `score` is Σ (2 · coverage - 1) · length, since true borders are longer than edges of texture,
    less COMPLEXITY of the outline's length for each side beyond four and each reflex corner.
    """

    corners: FloatArray
    lines: tuple[int, ...]
    coverage: FloatArray
    score: float
    normal: FloatArray


def find_outlines(
    plane: PlaneHypothesis, cloud: LineCloud, profiles: LineProfiles
) -> tuple[Outline, ...]:
    """Return the best outlines on a plane, by score."""
    segments, end_covs, support, pixel = (
        cloud.segments,
        cloud.end_covs,
        cloud.support,
        cloud.pixel,
    )
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    members = plane.lines[descending((support * length)[plane.lines])]
    members = members[: max(MAX_LINES.values())]
    basis = plane_basis(plane.normal)
    origin = plane.normal * plane.distance
    ends = _onto_plane(segments[members], end_covs[members], plane, pixel)
    flat = (ends - origin) @ basis  # (m, 2 ends, 2)
    corner = _crossings(flat)
    found: list[Outline] = []
    for sides, most in MAX_LINES.items():
        cycles = _cycles(min(most, len(members)), sides)
        if len(cycles):
            found += _supported(cycles, corner, members, profiles, origin, basis, plane, pixel)
    best = descending(np.array([o.score for o in found]))[:KEEP]
    return tuple(found[n] for n in best)


def _onto_plane(
    ends: FloatArray, covs: FloatArray, plane: PlaneHypothesis, pixel: float
) -> FloatArray:
    # The most likely points on the plane: each end moves in the direction of its largest variance,
    # along the views' depth, so that it stays where it is in the pictures.
    towards = covs @ plane.normal + 1e-2 * pixel**2 * plane.normal
    share = (plane.distance - ends @ plane.normal) / (towards @ plane.normal)
    moved: FloatArray = ends + share[..., None] * towards
    return moved


def _supported(
    cycles: NDArray[np.intp],
    corner: FloatArray,
    members: NDArray[np.intp],
    profiles: LineProfiles,
    origin: FloatArray,
    basis: FloatArray,
    plane: PlaneHypothesis,
    pixel: float,
) -> list[Outline]:
    # Corner i lies between sides i - 1 and i of the cycle.
    corners = corner[np.roll(cycles, 1, axis=1), cycles]  # (n, k, 2)
    good = np.isfinite(corners).all(axis=(1, 2))
    cycles, corners = cycles[good], corners[good]
    side = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(side, axis=-1)
    good = (length > MIN_SIDE_PX * pixel).all(axis=1)
    good &= _thickness(corners, length) > MIN_SIDE_PX * pixel
    good &= _is_simple(corners, side, length)
    cycles, corners, length = cycles[good], corners[good], length[good]
    if not len(cycles):
        return []
    space = origin + corners @ basis.T  # (n, k, 3)
    line = members[cycles]
    start = np.einsum("nkx,nkx->nk", space - profiles.origin[line], profiles.direction[line])
    following = np.roll(space, -1, axis=1)
    end = np.einsum("nkx,nkx->nk", following - profiles.origin[line], profiles.direction[line])
    cover = profiles.mean(line, start, end)
    score = ((2 * cover - 1) * length).sum(axis=1)
    sides = cycles.shape[1]
    complexity = max(sides - 4, 0) + _find_reflex_corners(corners)
    score = score - COMPLEXITY * complexity * length.sum(axis=1)
    keep = np.nonzero(cover.min(axis=1) >= MIN_COVERAGE)[0]
    keep = keep[descending(score[keep])][:KEEP]
    return [
        Outline(space[n], tuple(map(int, line[n])), cover[n], float(score[n]), plane.normal)
        for n in keep
    ]


def _thickness(corners: FloatArray, length: FloatArray) -> FloatArray:
    # Area over the longest side: a sliver's sides all lie on the same edge.
    following = np.roll(corners, -1, axis=1)
    twice = (corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]).sum(axis=1)
    thickness: FloatArray = np.abs(twice) / 2 / np.maximum(length.max(axis=1), 1e-300)
    return thickness


def _is_simple(corners: FloatArray, side: FloatArray, length: FloatArray) -> NDArray[np.bool_]:
    # Every corner turns enough, the turns add up to one round, and no two sides cross.
    following = np.roll(side, -1, axis=1)
    turn_sine = side[..., 0] * following[..., 1] - side[..., 1] * following[..., 0]
    turn_cosine = (side * following).sum(axis=-1)
    scale = length * np.roll(length, -1, axis=1)
    turns = np.abs(turn_sine) > MIN_TURN_SINE * scale
    total = np.arctan2(turn_sine, turn_cosine).sum(axis=1)
    simple: NDArray[np.bool_] = turns.all(axis=1) & (np.abs(np.abs(total) - 2 * np.pi) < 1e-3)
    k = corners.shape[1]
    for i, j in combinations(range(k), 2):
        if (j - i) % k in (1, k - 1):
            continue
        simple &= ~_cross(corners[:, i], side[:, i], corners[:, j], side[:, j])
    return simple


def _find_reflex_corners(corners: FloatArray) -> NDArray[np.intp]:
    side = np.roll(corners, -1, axis=1) - corners
    following = np.roll(side, -1, axis=1)
    turn = side[..., 0] * following[..., 1] - side[..., 1] * following[..., 0]
    inward = turn * np.sign(turn.sum(axis=1, keepdims=True)) < 0
    count: NDArray[np.intp] = inward.sum(axis=1)
    return count


def _cross(a: FloatArray, u: FloatArray, b: FloatArray, v: FloatArray) -> NDArray[np.bool_]:
    denominator = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    safe = np.where(np.abs(denominator) > 0, denominator, np.inf)
    d = b - a
    s = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / safe
    t = (d[:, 0] * u[:, 1] - d[:, 1] * u[:, 0]) / safe
    crossing: NDArray[np.bool_] = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    return crossing & np.isfinite(safe)


def _crossings(flat: FloatArray) -> FloatArray:
    # Where lines i and j cross, (m, m, 2); NaN where they are nearly parallel.
    a = flat[:, 0]
    u = flat[:, 1] - a
    u = u / np.linalg.norm(u, axis=1, keepdims=True)
    sine = u[:, None, 0] * u[None, :, 1] - u[:, None, 1] * u[None, :, 0]
    d = a[None] - a[:, None]
    s = d[..., 0] * u[None, :, 1] - d[..., 1] * u[None, :, 0]
    safe = np.where(np.abs(sine) > MIN_TURN_SINE, sine, np.nan)
    crossings: FloatArray = a[:, None] + (s / safe)[..., None] * u[:, None]
    return crossings


@cache
def _cycles(lines: int, sides: int) -> NDArray[np.intp]:
    # Every cyclic order of every choice of lines, reversals left out: (n, sides).
    orders = [(0, *p) for p in permutations(range(1, sides)) if p[0] < p[-1]]
    chosen = np.array(list(combinations(range(lines), sides)), dtype=np.intp)
    if not len(chosen):
        return np.zeros((0, sides), dtype=np.intp)
    return np.concatenate([chosen[:, order] for order in orders])
