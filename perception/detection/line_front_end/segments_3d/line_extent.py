"""The extents of 3-D segments: coverage profiles along their lines, and joined pieces."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.segments_3d.line_support import hits
from facetlog.perception.stable_order import at_least
from facetlog.perception.types import FloatArray, View

# Samples of a profile; the line is looked at from MARGIN lengths before to MARGIN after it.
SAMPLES = 192
MARGIN = 1.0
# A segment ends where its coverage, averaged over a step of the walk, falls below this.
MIN_COVERAGE = 0.5
WALK_STEPS = 96


@dataclass(frozen=True, eq=False, slots=True)
class LineProfiles:
    """Cumulated coverage along n lines: `origin` (n, 3), unit `direction` (n, 3).

    `begin` and `step` (n,): where the profile starts on the line and how far its samples lie
    apart; `cumulated` (n, SAMPLES + 1) sums the coverage in [0, 1] of the samples before.
    """

    origin: FloatArray
    direction: FloatArray
    begin: FloatArray
    step: FloatArray
    cumulated: FloatArray

    def mean(self, line: NDArray[np.intp], start: FloatArray, end: FloatArray) -> FloatArray:
        """Return the mean coverage of lines between two places on them; outside the profile it is
        0.
        """
        low, high = np.minimum(start, end), np.maximum(start, end)
        length = np.maximum(high - low, 1e-300)
        inside = self._at(line, high) - self._at(line, low)
        mean: FloatArray = np.clip(inside * self.step[line] / length, 0.0, 1.0)
        return mean

    def _at(self, line: NDArray[np.intp], place: FloatArray) -> FloatArray:
        x = np.clip((place - self.begin[line]) / self.step[line], 0, SAMPLES)
        k = np.minimum(x.astype(np.intp), SAMPLES - 1)
        c = self.cumulated
        value: FloatArray = c[line, k] + (x - k) * (c[line, k + 1] - c[line, k])
        return value


def measure_line_profiles(
    segments: FloatArray,
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    use: NDArray[np.bool_],
    weight: FloatArray,
) -> LineProfiles:
    """Return the coverage profiles of segments (n, 2, 3) from the views in `use` (n, V) by their
    weights.
    """
    along = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(along, axis=1)
    direction = along / length[:, None]
    begin = -MARGIN * length
    step = (1 + 2 * MARGIN) * length / SAMPLES
    longer = segments + MARGIN * np.stack([-along, along], axis=1)
    found = np.zeros((len(segments), SAMPLES))
    possible = np.zeros((len(segments), SAMPLES))
    for k, (view, edges) in enumerate(zip(views, maps, strict=True)):
        chosen = np.nonzero(use[:, k])[0]
        if len(chosen):
            hit, inside = hits(view, edges, longer[chosen], SAMPLES)
            found[chosen] += weight[k] * hit
            possible[chosen] += weight[k] * inside
    covered = found / np.maximum(possible, 1e-12)
    cumulated = np.concatenate([np.zeros((len(segments), 1)), covered.cumsum(axis=1)], axis=1)
    return LineProfiles(segments[:, 0].copy(), direction, begin, step, cumulated)


def find_covered_extents(segments: FloatArray, profiles: LineProfiles) -> FloatArray:
    """Return segments (n, 2, 3) lengthened or cut, from their middles, to where covered."""
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    line = np.arange(len(segments))
    ends = []
    for sign in (-1.0, 1.0):
        place = length / 2
        step = sign * 1.5 * length / WALK_STEPS
        walking = np.ones(len(segments), np.bool_)
        for _ in range(WALK_STEPS):
            walking &= at_least(profiles.mean(line, place, place + 2 * step), MIN_COVERAGE)
            if not walking.any():
                break
            place = np.where(walking, place + step, place)
        ends.append(profiles.origin + place[:, None] * profiles.direction)
    return np.stack(ends, axis=1)
