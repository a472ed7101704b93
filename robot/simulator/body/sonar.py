"""Ranges that the sonars measure against the world's obstacles."""

import math
from dataclasses import dataclass, field

from facetlog.robot.pioneer.packets.server_information import SonarReading
from facetlog.robot.pioneer.parameters import Parameters, SonarPlace
from facetlog.robot.simulator.body.dynamics import Truth
from facetlog.robot.simulator.body.obstacles import Obstacles

__all__ = ["RANGE", "Sonars"]

RANGE = 5.0
"""Largest range, metres, and the one reported where nothing is detected (Pioneer 2 manual)."""
# The beam is some 30 degrees wide; the nearest thing anywhere in it is measured.
BEAM = math.radians(30)
ARRAY = 8
"""Sonars in an array; the arrays fire at the same time, one sonar of each at a time."""


@dataclass(slots=True)
class Sonars:
    """Fires one sonar of each array every `period` seconds, in an order that can be set."""

    parameters: Parameters
    obstacles: Obstacles
    period: float
    on: bool = field(default=False, init=False)
    _orders: list[list[int]] = field(default_factory=list, init=False)
    _fired: int = field(default=0, init=False)
    _since: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self.set_order(range(1, len(self.parameters.sonars) + 1))

    def switch(self, on: bool, now: float) -> None:
        """SONAR: they fire, from now on, or no longer."""
        if on and not self.on:
            self._since = now
        self.on = on

    def set_order(self, numbers: range | bytes) -> None:
        """POLLING: which sonars fire, by their numbers from 1 on; each array keeps its own."""
        count = len(self.parameters.sonars)
        valid = [number - 1 for number in numbers if 1 <= number <= count]
        if not valid and len(numbers):
            return
        arrays = range(-(-count // ARRAY))
        self._orders = [[i for i in valid if i // ARRAY == array] for array in arrays]
        self._fired = 0

    def readings(self, now: float, truth: Truth) -> tuple[SonarReading, ...]:
        """The ranges measured since the last call: at most one for each sonar."""
        if not self.on:
            return ()
        due_count = int((now - self._since) / self.period + 1e-6)
        self._since += self.period * due_count
        fired = min(due_count, ARRAY)
        indices: list[int] = []
        for order in self._orders:
            due = [order[(self._fired + i) % len(order)] for i in range(fired) if order]
            indices += dict.fromkeys(due)
        self._fired += fired
        return tuple(SonarReading(i, self._measure(i, truth)) for i in indices)

    def _measure(self, index: int, truth: Truth) -> int:
        place = self.parameters.sonars[index]
        return min(round(self._range(place, truth) / self.parameters.range), 0xFFFF)

    def _range(self, place: SonarPlace, truth: Truth) -> float:
        c, s = math.cos(truth.heading), math.sin(truth.heading)
        x, y = truth.x + c * place.x - s * place.y, truth.y + s * place.x + c * place.y
        return self.obstacles.distance(x, y, truth.heading + place.heading, BEAM / 2, RANGE)
