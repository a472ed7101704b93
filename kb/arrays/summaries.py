"""What all answers come to, as aggregate_all/3 works it out."""

import numpy as np

from facetlog.kb.arrays.values import Kind, NotOnArraysError, Values

__all__ = ["Summary"]


class Summary:
    """The `count`, `sum`, `max` or `min` of values that come in parts."""

    def __init__(self, functor: str) -> None:
        self._functor = functor
        self._kind: Kind | None = None
        self.value: int | float | None = 0 if functor in ("count", "sum") else None
        """So far; None of no values where that is nothing."""

    def add(self, length: int, values: Values | None) -> None:
        """So many more, with their values where these count."""
        if self._functor == "count" or values is None:
            self.value = (self.value or 0) + length
            return
        if values.kind not in (Kind.FLOAT, Kind.INTEGER) or self._kind not in (None, values.kind):
            raise NotOnArraysError
        self._kind = values.kind
        if self._functor == "sum":
            self.value = _sum(self.value or 0, values)
        else:
            self.value = _best(self._functor, self.value, values)


def _sum(total: int | float, values: Values) -> int | float:
    """One after the other: floats come to something else in another order."""
    if values.kind is Kind.INTEGER:
        whole: int = sum(values.data.tolist(), start=int(total))
        if abs(whole) >= 1 << 63:
            raise NotOnArraysError
        return whole
    with np.errstate(all="ignore"):
        added = float(np.add.accumulate(np.concatenate([[total], values.data]))[-1])
    if not np.isfinite(added):
        raise NotOnArraysError
    return added


def _best(functor: str, before: int | float | None, values: Values) -> int | float:
    choose = max if functor == "max" else min
    found: list[int | float] = [(values.data.max() if choose is max else values.data.min()).item()]
    # Which of 0.0 and -0.0 is the larger is Prolog's to say.
    if found[0] == 0 and values.kind is Kind.FLOAT:
        raise NotOnArraysError
    return choose(found if before is None else [before, *found])
