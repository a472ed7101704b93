"""Places for words on a picture so that none covers another or what is drawn already."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

__all__ = ["Box", "placed"]

# Pixels from a label's anchor to its middle, from near to far, and the directions that are tried.
DISTANCES = (16, 24, 34, 46, 60, 80, 105, 135)
DIRECTIONS = 16
GAP = 2  # pixels between two labels


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle of pixels: its upper left corner, width and height."""

    left: float
    top: float
    width: float
    height: float

    def shared(self, other: "Box") -> float:
        """The area that both have, a gap about each included."""
        width = min(self.left + self.width, other.left + other.width) - max(self.left, other.left)
        height = min(self.top + self.height, other.top + other.height) - max(self.top, other.top)
        return max(width + GAP, 0.0) * max(height + GAP, 0.0)

    def outside(self, width: float, height: float) -> float:
        """How many pixels it is beyond a picture's border."""
        right, bottom = self.left + self.width - width, self.top + self.height - height
        return max(-self.left, 0.0) + max(-self.top, 0.0) + max(right, 0.0) + max(bottom, 0.0)


def placed(
    anchors: Sequence[tuple[float, float]],
    sizes: Sequence[tuple[float, float]],
    drawn: Iterable[Box],
    picture: tuple[float, float],
) -> list[Box]:
    """A box of each size near its anchor, clear of what is `drawn` and of the boxes before it.

    Where no place near it is clear, the one that covers least.
    """
    taken = list(drawn)
    boxes = []
    for anchor, size in zip(anchors, sizes, strict=True):
        best, least = None, math.inf
        for box in _candidates(anchor, size):
            cost = box.outside(*picture) * size[0] * size[1] + sum(
                box.shared(other) for other in taken
            )
            if cost < least:
                best, least = box, cost
            if cost == 0:
                break
        assert best is not None  # noqa: S101 - there are candidates, and each has a finite cost
        boxes.append(best)
        taken.append(best)
    return boxes


def _candidates(anchor: tuple[float, float], size: tuple[float, float]) -> Iterable[Box]:
    (x, y), (width, height) = anchor, size
    for distance in DISTANCES:
        for k in range(DIRECTIONS):
            # First up and to the right, where a number is looked for.
            angle = math.pi / 4 + 2 * math.pi * k / DIRECTIONS
            dx, dy = math.cos(angle), -math.sin(angle)
            # Long words keep off by half their length where they lie beside.
            middle_x = x + dx * (distance + width / 2 - height / 2)
            middle_y = y + dy * distance
            yield Box(middle_x - width / 2, middle_y - height / 2, width, height)
