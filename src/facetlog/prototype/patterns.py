"""Parts by the dozen: how many, of which kind, and where they stand in a plan."""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

from facetlog.prototype.assembly import Length

Extent = tuple[Length, Length]
Plan = tuple[Extent, Extent]


def about(middle: Length, extent: Length) -> Extent:
    """Return the ends of what is so long about a middle."""
    return middle - extent * 0.5, middle + extent * 0.5


@dataclass(frozen=True, slots=True)
class Sides:
    """An extent cut from both of its ends: `rim` in from them, and members so thick there."""

    low: Length
    high: Length
    rim: Length
    thick: Length

    @property
    def first(self) -> Extent:
        return self.low + self.rim, self.low + self.rim + self.thick

    @property
    def last(self) -> Extent:
        return self.high - self.rim - self.thick, self.high - self.rim

    @property
    def middle(self) -> Extent:
        return about((self.low + self.high) * 0.5, self.thick)

    def spread(self, count: int) -> list[Extent]:
        """Return so many members from the first to the last, evenly apart."""
        step = (self.last[0] - self.first[0]) * (1.0 / (count - 1))
        starts = [self.first[0] + step * float(nth) for nth in range(count)]
        return [(start, start + self.thick) for start in starts]

    @property
    def inner(self) -> Extent:
        return self.first[1], self.last[0]

    @property
    def all(self) -> Extent:
        return self.low + self.rim, self.high - self.rim


@dataclass(frozen=True, slots=True)
class Pattern:
    """Number and kind of parts, and their places in a plan."""

    count: int
    kind: str
    plan: Callable[[Sides, Sides], tuple[Plan, ...]]
    longest_row: int = 0  # of a grid


PATTERNS: Mapping[str, Pattern] = MappingProxyType(
    {
        "four legs": Pattern(
            4,
            "bar",
            lambda x, y: tuple((a, b) for a in (x.first, x.last) for b in (y.first, y.last)),
        ),
        "three legs": Pattern(
            3, "bar", lambda x, y: ((x.first, y.first), (x.last, y.first), (x.middle, y.last))
        ),
        "two posts": Pattern(2, "bar", lambda x, y: ((x.first, y.middle), (x.last, y.middle))),
        "two panels": Pattern(2, "board", lambda x, y: ((x.first, y.all), (x.last, y.all))),
        "two long panels": Pattern(2, "board", lambda x, y: ((x.all, y.first), (x.all, y.last))),
        "three panels": Pattern(
            3, "board", lambda x, y: ((x.first, y.all), (x.last, y.all), (x.inner, y.last))
        ),
        "four walls": Pattern(
            4,
            "board",
            lambda x, y: (
                (x.first, y.all), (x.last, y.all), (x.inner, y.first), (x.inner, y.last)
            ),
        ),
        "a column": Pattern(1, "bar", lambda x, y: ((x.middle, y.middle),)),
        "a back": Pattern(1, "board", lambda x, y: ((x.all, y.last),)),
        "a head": Pattern(1, "board", lambda x, y: ((x.last, y.all),)),
        "a block": Pattern(1, "block", lambda x, y: ((x.all, y.all),)),
    }
)  # fmt: skip
"""By what they are called where a prototype is described."""


def grids(count: int) -> Iterator[str]:
    """Yield the names of so many blocks in rows of equally many, two rows and three a row at
    least.
    """
    for rows in range(2, math.isqrt(count) + 1):
        if count % rows == 0 and count // rows > 2:
            yield f"{rows} rows of {count // rows} blocks"


def find_pattern(name: str) -> Pattern:
    """Return the pattern of a name, as of `PATTERNS` or of `grids`."""
    if name in PATTERNS:
        return PATTERNS[name]
    rows, columns = (int(word) for word in re.findall(r"\d+", name))
    return Pattern(
        rows * columns,
        "cube",
        lambda x, y: tuple(product(x.spread(columns), y.spread(rows))),
        max(rows, columns),
    )
