"""A measure of space that is partly unseen: its value, and between what it lies."""

from typing import NamedTuple

from facetlog.perception.flat_faces import Estimate

__all__ = ["Bounded"]


class Bounded(NamedTuple):
    """A value and the sd with which it is measured, and what it comes to if all that is unseen is
    free, and if all is full. Where these differ the value is their middle.
    """

    value: float
    sd: float
    if_free: float
    if_full: float

    @classmethod
    def sure(cls, one: Estimate) -> "Bounded":
        """What no unseen space could change."""
        return cls(*one, one.value, one.value)

    @classmethod
    def between(cls, if_free: Estimate, if_full: Estimate) -> "Bounded":
        """What has these two readings.

        >>> Bounded.between(Estimate(0.5, 0.01), Estimate(0.25, 0.02))
        Bounded(value=0.375, sd=0.02, if_free=0.5, if_full=0.25)
        """
        sd = max(if_free.sd, if_full.sd)
        if if_free.value == if_full.value:
            return cls(if_free.value, sd, if_free.value, if_full.value)
        middle = (if_free.value + if_full.value) / 2.0
        return cls(middle, sd, if_free.value, if_full.value)

    @property
    def open(self) -> bool:
        """Whether the two readings differ."""
        return self.if_free != self.if_full
