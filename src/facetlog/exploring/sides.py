"""Which sides of a thing lack the views that a face needs, after views from some places."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from facetlog.kb.explaining.unseen import GRAZING_DEG
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray

# A thing may have a face on each of so many sides in plan, and one upwards: two neighbours are 30
# degrees apart, less than what one look sees of sides.
SIDES = 12
GRAZING = math.cos(math.radians(GRAZING_DEG))
"""What faces a place at a smaller cosine is not seen from there."""


@dataclass(frozen=True, eq=False, slots=False)
class Sides:
    """Sides of a thing with its `middle` (3,) and `normals` (k, 3) of faces that nobody measured,
    after looks from `places` (v, 3).
    """

    middle: FloatArray
    normals: FloatArray
    places: FloatArray

    @cached_property
    def towards(self) -> FloatArray:
        """Unit vectors (v, 3) to the places."""
        return units(self.places - self.middle)

    @cached_property
    def facing(self) -> FloatArray:
        """Directions (s, 3) that faces of the thing may face: the first view's bearing is one."""
        first = self.towards[0] if len(self.towards) else np.array([1.0, 0.0, 0.0])
        angles = math.atan2(first[1], first[0]) + math.tau / SIDES * np.arange(SIDES)
        level = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(SIDES)])
        # What faces the floor is seen from nowhere.
        down = (self.normals[:, 2] < 0) & (np.linalg.norm(self.normals[:, :2], axis=1) < GRAZING)
        return np.concatenate([level, [[0.0, 0.0, 1.0]], self.normals[~down]])

    @cached_property
    def lacking(self) -> FloatArray:
        """Share of the views a face needs that each side lacks (s,), 0..1."""
        looks = (self.facing @ self.towards.T > GRAZING).sum(axis=1)
        lacking: FloatArray = np.maximum(FEWEST_VIEWS - looks, 0) / FEWEST_VIEWS
        return lacking

    @property
    def lack(self) -> float:
        """Which share of all that is to be seen was not, 0..1."""
        return float(self.lacking.mean())

    def shown_from(self, place: FloatArray) -> float:
        """Return the share of what lacks that one more view from a place (3,) would show, 0..1."""
        before = (self.facing @ units(place - self.middle) > GRAZING) & (self.lacking > 0)
        total = float(self.lacking.sum())
        return float(before.sum()) / FEWEST_VIEWS / total if total else 0.0


def units(steps: FloatArray) -> FloatArray:
    """Return steps (..., 3) as unit vectors."""
    found: FloatArray = steps / np.maximum(np.linalg.norm(steps, axis=-1, keepdims=True), 1e-12)
    return found
