"""A motor that turns at an even speed from where it was to where it was sent."""

import math
from dataclasses import dataclass

__all__ = ["Slew"]


@dataclass(frozen=True, slots=True)
class Slew:
    """Motion of one axis since `since`; acceleration is left out, it takes less than a picture."""

    origin: float
    target: float
    speed: float
    """Steps a second."""
    since: float
    """Seconds."""

    @classmethod
    def standing(cls, at: float) -> "Slew":
        """An axis that stands still."""
        return cls(at, at, math.inf, 0.0)

    @property
    def end(self) -> float:
        """When it arrives, seconds."""
        return self.since + abs(self.target - self.origin) / self.speed

    def at(self, now: float) -> float:
        """Where it is at `now`, exact at both ends and never beyond them."""
        if now >= self.end:
            return self.target
        gone = max(now - self.since, 0.0) * self.speed
        return self.origin + math.copysign(gone, self.target - self.origin)

    def to(self, target: float, speed: float, now: float) -> "Slew":
        """The motion to another target from where it is at `now`."""
        return Slew(self.at(now), target, speed, now)

    def stopped(self, now: float) -> "Slew":
        """It stands where it is at `now`."""
        return Slew.standing(self.at(now))
