"""A measure of space that is partly unseen: its value, and between what it lies."""

from typing import NamedTuple

import numpy as np

from facetlog.perception.flat_faces import Estimate

__all__ = ["ROUNDING", "Bounded"]

ROUNDING = 1.0 / float(np.sqrt(12.0))
"""The sd of what lies anywhere within one: a uniform error."""


class Bounded(NamedTuple):
    """A value and its sd, and its bounds: the two readings of what is unseen, as free and as full.

    Where they differ the value is their middle, and the sd that of a value anywhere between.
    """

    value: float
    sd: float
    low: float
    high: float

    @classmethod
    def sure(cls, one: Estimate) -> "Bounded":
        """What no unseen space could change."""
        return cls(*one, one.value, one.value)

    @classmethod
    def between(cls, one: Estimate, other: Estimate) -> "Bounded":
        """What has these two readings, in either order.

        >>> Bounded.between(Estimate(0.5, 0.01), Estimate(0.25, 0.01))[::2]
        (0.375, 0.25)
        """
        low, high = sorted((one.value, other.value))
        sd = max(one.sd, other.sd)
        if low == high:
            return cls(low, sd, low, high)
        return cls((low + high) / 2.0, float(np.hypot(sd, ROUNDING * (high - low))), low, high)

    @property
    def open(self) -> bool:
        """Whether the two readings differ."""
        return self.high > self.low
