"""Planar poses: place and heading on the floor, the group SE(2)."""

import math
from dataclasses import dataclass


def wrapped(angle: float) -> float:
    """Wrap an angle into (-π, π], radians.

    >>> round(wrapped(1.5 * math.pi) / math.pi, 9)
    -0.5
    """
    turned = math.remainder(angle, math.tau)
    return math.pi if turned == -math.pi else turned


@dataclass(frozen=True, slots=True)
class Pose2:
    """Place and heading in a frame: metres, radians, counter-clockwise from its x axis."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.x, self.y, self.heading))):
            raise ValueError(f"({self.x}, {self.y}, {self.heading}) is no place on the floor")

    def compose(self, other: "Pose2") -> "Pose2":
        """Return `other`, given in this pose's own frame, in the frame that this pose is given in.

        >>> Pose2(1.0, 0.0, math.pi).compose(Pose2(2.0, 0.0)).x
        -1.0
        """
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrapped(self.heading + other.heading),
        )

    def inverse(self) -> "Pose2":
        """Return the inverse: the pose of the reference frame in this pose's own frame."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose2(
            -c * self.x - s * self.y,
            s * self.x - c * self.y,
            wrapped(-self.heading),
        )

    def between(self, other: "Pose2") -> "Pose2":
        """Return `other` in this pose's own frame, where both are given in one frame."""
        return self.inverse().compose(other)
