"""How the robot moves: speeds that change no faster than they may, wheels that slip, contact.

The encoders' counts and the true pose differ: odometry follows the former, camera and walls the
latter. Time advances in steps of one length, so that the same commands at the same times give the
same path, however often the state is read.
"""

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

__all__ = ["STEP", "Body", "Contact", "MotionErrors", "Surroundings", "Truth"]

STEP = 0.005
"""Seconds between two states of the motion, as the robot's own control runs (P2OS: 200 Hz)."""
CONTACT_GAP = 1e-3
"""Metres: nearer than this the robot touches."""
HALVINGS = 12  # of a step of some millimetres: contact is found to a micrometre


@dataclass(frozen=True, slots=True)
class Truth:
    """Where the robot truly stands: metres and radians in the world frame."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Contact:
    """What is nearest: the gap to it in metres, and its direction in the world frame, radians."""

    gap: float
    direction: float


class Surroundings(Protocol):
    """What the robot may run into."""

    def nearest(self, x: float, y: float) -> Contact | None:
        """The nearest thing to the robot's circle about (x, y); None if there is none."""


@dataclass(frozen=True, slots=True)
class MotionErrors:
    """Errors of odometry: differences between the wheels' true motion and their encoders' counts.

    `left` and `right` are the shares by which each wheel goes further than its encoder counts
    (unequal tyres), `track` the share by which the effective track is wider than the firmware's.
    `slip` and `encoder` are standard deviations of a wheel's distance and of its count over one
    metre, in metres: they grow with the root of the distance.
    """

    left: float = 0.0
    right: float = 0.0
    track: float = 0.0
    slip: float = 0.0
    encoder: float = 0.0

    @classmethod
    def usual(cls, *, skids: bool) -> "MotionErrors":
        """Of a robot as it comes, on a hard floor (assumed); one whose wheels skid as it turns
        turns less than they say, and slips more.
        """
        if skids:
            return cls(left=0.002, right=0.003, track=0.02, slip=0.004, encoder=0.001)
        return cls(left=0.002, right=0.003, track=0.005, slip=0.002, encoder=0.001)


@dataclass(slots=True)
class Body:
    """A robot with two driven wheels on a floor; metres, radians, seconds.

    `track` is the distance of the wheels that the firmware reckons with. `speed` and `turning`
    are those that the encoders measure.
    """

    track: float
    truth: Truth
    errors: MotionErrors = MotionErrors()
    surroundings: Surroundings | None = None
    rng: np.random.Generator = field(default_factory=np.random.default_rng)
    speed: float = 0.0
    turning: float = 0.0
    left: float = 0.0
    """Distance that the left wheel's encoder counted since the robot was switched on."""
    right: float = 0.0
    blocked: bool = False
    """Whether something kept it from going where its wheels drove it in the last step."""
    contact: Contact | None = None
    """What it touches."""
    _clear: float = field(default=0.0, init=False)
    """A lower bound of the distance to the nearest thing: no search before it is used up."""

    def __post_init__(self) -> None:
        self._feel()

    @property
    def standing(self) -> bool:
        """Whether both wheels stand."""
        return self.speed == 0.0 and self.turning == 0.0

    def place(self, truth: Truth) -> None:
        """Puts the robot somewhere else, as by hand; it stands."""
        self.truth, self.speed, self.turning, self.blocked = truth, 0.0, 0.0, False
        self._clear = 0.0
        self._feel()

    def step(self) -> tuple[float, float]:
        """Advances by `STEP` seconds; distance and turn as the encoders counted them."""
        self.blocked = False
        if self.standing:
            return 0.0, 0.0
        left = (self.speed - self.turning * self.track / 2) * STEP
        right = (self.speed + self.turning * self.track / 2) * STEP
        noise: list[float] = self.rng.standard_normal(4).tolist()
        true_left = left * (1 + self.errors.left)
        true_left += self.errors.slip * math.sqrt(abs(left)) * noise[0]
        true_right = right * (1 + self.errors.right)
        true_right += self.errors.slip * math.sqrt(abs(right)) * noise[1]
        moved = self._move(true_left, true_right)
        if self.blocked:
            # The wheels stand still against what is in the way; it may still turn on the spot.
            ahead = moved * (left + right) / 2
            left, right = ahead - (right - left) / 2, ahead + (right - left) / 2
            self.speed = 0.0
        left += self.errors.encoder * math.sqrt(abs(left)) * noise[2]
        right += self.errors.encoder * math.sqrt(abs(right)) * noise[3]
        self.left += left
        self.right += right
        return (left + right) / 2, (right - left) / self.track

    def _move(self, left: float, right: float) -> float:
        """Moves by ways of the wheels; the share of the way ahead that was free."""
        ahead, here = (left + right) / 2, self.truth
        turn = (right - left) / (self.track * (1 + self.errors.track))
        middle = here.heading + turn / 2
        dx, dy = ahead * math.cos(middle), ahead * math.sin(middle)
        free = self._free(dx, dy)
        self.blocked = free < 1.0
        heading = math.remainder(here.heading + turn, 2 * math.pi)
        self.truth = Truth(here.x + free * dx, here.y + free * dy, heading)
        self._feel()
        return free

    def _free(self, dx: float, dy: float) -> float:
        """The share of a small way that can be gone: it may leave what it touches, not enter."""
        self._clear -= math.hypot(dx, dy)
        if self._clear > CONTACT_GAP:
            return 1.0
        before, there = self._gap(0.0, 0.0), self._gap(dx, dy)
        if there >= 0.0 or there >= before:
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            half = (low + high) / 2
            if self._gap(half * dx, half * dy) >= min(0.0, before):
                low = half
            else:
                high = half
        return low

    def _gap(self, dx: float, dy: float) -> float:
        if self.surroundings is None:
            return math.inf
        found = self.surroundings.nearest(self.truth.x + dx, self.truth.y + dy)
        return math.inf if found is None else found.gap

    def _feel(self) -> None:
        if self._clear > CONTACT_GAP:
            return
        self.contact, self._clear = None, math.inf
        if self.surroundings is not None:
            found = self.surroundings.nearest(self.truth.x, self.truth.y)
            if found is not None:
                self._clear = found.gap
                self.contact = found if found.gap < CONTACT_GAP else None
