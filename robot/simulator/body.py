"""The body of the simulated robot: motion, contacts, obstacles and sonars.

Encoder counts and true pose differ: odometry follows the former, camera and walls the latter. Time
advances in steps of one length, so that the same commands at the same times give the same path.
"""

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from facetlog.perception.types import FloatArray
from facetlog.robot.pioneer.packets.reports import SonarReading
from facetlog.robot.pioneer.parameters import Parameters, SonarPlace
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.world import Solid

STEP = 0.005
"""Seconds between two states of the motion, as the robot's own control runs (P2OS: 200 Hz)."""
CONTACT_GAP = 1e-3
"""Metres: nearer than this the robot touches."""
HALVINGS = 12  # of a step of some millimetres: contact is found to a micrometre


@dataclass(frozen=True, slots=True)
class Contact:
    """The nearest obstacle: the gap to it in metres, and its direction in the world, radians."""

    gap: float
    direction: float


class Surroundings(Protocol):
    """Obstacles that the robot may run into."""

    def nearest(self, x: float, y: float) -> Contact | None:
        """Return the nearest thing to the robot's circle about (x, y); None if there is none."""


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
        """Return the errors of a robot as delivered, on a hard floor (assumed). One whose wheels
        skid turns less than they say, and slips more.
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
    truth: Pose2
    """Where the robot truly stands, in the world frame."""
    errors: MotionErrors = MotionErrors()
    surroundings: Surroundings | None = None
    rng: np.random.Generator = field(default_factory=np.random.default_rng)
    speed: float = 0.0
    turning: float = 0.0
    blocked: bool = False
    """Whether something kept it from going where its wheels drove it in the last step."""
    contact: Contact | None = None
    """The obstacle that it touches."""
    _clear: float = field(default=0.0, init=False)
    """A lower bound of the distance to the nearest thing: no search before it is used up."""

    def __post_init__(self) -> None:
        self._update_contact()

    @property
    def standing(self) -> bool:
        return self.speed == 0.0 and self.turning == 0.0

    def step(self) -> tuple[float, float]:
        """Advance by `STEP` seconds; return distance and turn as the encoders counted them."""
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
        return (left + right) / 2, (right - left) / self.track

    def _move(self, left: float, right: float) -> float:
        """Move by ways of the wheels; the share of the way ahead that was free."""
        ahead, here = (left + right) / 2, self.truth
        turn = (right - left) / (self.track * (1 + self.errors.track))
        middle = here.heading + turn / 2
        dx, dy = ahead * math.cos(middle), ahead * math.sin(middle)
        free = self._free(dx, dy)
        self.blocked = free < 1.0
        heading = math.remainder(here.heading + turn, 2 * math.pi)
        self.truth = Pose2(here.x + free * dx, here.y + free * dy, heading)
        self._update_contact()
        return free

    def _free(self, dx: float, dy: float) -> float:
        """Return the share of a small way that can be gone: it may leave what it touches, not
        enter.
        """
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

    def _update_contact(self) -> None:
        if self._clear > CONTACT_GAP:
            return
        self.contact, self._clear = None, math.inf
        if self.surroundings is not None:
            found = self.surroundings.nearest(self.truth.x, self.truth.y)
            if found is not None:
                self._clear = found.gap
                self.contact = found if found.gap < CONTACT_GAP else None


STALL_SECONDS = 0.5
"""How long the wheels push before they are found to be stalled: "a second or more" without bumpers
on a robot that is built to climb (Pioneer 2 manual, page 45); a still world stops it sooner."""


def pressed(contact: Contact | None, truth: Pose2, front: int, rear: int) -> tuple[int, int]:
    """Return bits of the bumpers that a contact presses: in front (leftmost lowest), behind
    (rightmost).

    Each ring covers half of the robot with so many segments.
    """
    if contact is None:
        return 0, 0
    angle = math.remainder(contact.direction - truth.heading, 2 * math.pi)
    if abs(angle) <= math.pi / 2:
        return _find_bumper_bit(math.pi / 2 - angle, front), 0
    return 0, _find_bumper_bit((-angle - math.pi / 2) % (2 * math.pi), rear)


def _find_bumper_bit(angle: float, count: int) -> int:
    """Return the bit of the segment at an angle of half a circle."""
    return 1 << min(int(angle / math.pi * count), count - 1) if count else 0


@dataclass(slots=True)
class Contacts:
    """Stall bits of the wheels, from pushing too long or from a bumper that counts as a stall."""

    pause: float
    """Seconds for which a stalled wheel is not driven again (StallCount)."""
    _pushing: float | None = field(default=None, init=False)
    _until: float | None = field(default=None, init=False)

    @property
    def stalled(self) -> bool:
        """Whether both wheels are stalled."""
        return self._until is not None

    def stall(self, now: float, seconds: float = 0.0) -> None:
        """Stall the wheels for a while, at least for the pause."""
        self._until = max(self._until or 0.0, now + max(seconds, self.pause))

    def free(self) -> None:
        self._until, self._pushing = None, None

    def step(self, now: float, *, blocked: bool, bumped: bool) -> None:
        """Update the stall after a step of motion: whether something `blocked` the robot.

        `bumped`: a bumper that counts as a stall is pressed.
        """
        if self._until is not None:
            if now >= self._until:
                self.free()
        elif not blocked:
            self._pushing = None
        else:
            self._pushing = now if self._pushing is None else self._pushing
            if bumped or now - self._pushing >= STALL_SECONDS:
                self.stall(now)


# Places of the arc of a sector: of 30 degrees its chords are a two-thousandth of its radius off.
ARC = 9


def footprint(solid: Solid, height: float) -> BaseGeometry:
    """Return the part of a solid between the floor and `height` (its unit), seen from above.

    Walls are lines in it, level faces areas: what comes from outside meets one or the other.
    """
    pieces: list[BaseGeometry] = []
    for face in solid.faces:
        corners = _clip_to_heights(solid.vertices[list(face)], 0.0, height)
        if len(corners) == 0:
            continue
        flat = corners[:, :2]
        ring = np.vstack([flat, flat[:1]])
        pieces.append(shapely.linestrings(ring))
        if len(flat) >= 3:
            pieces.append(shapely.make_valid(shapely.polygons(ring)))
    return shapely.union_all(pieces)


def _clip_to_heights(corners: FloatArray, low: float, high: float) -> FloatArray:
    """Return the part of a polygon (n, 3) with z in [low, high] (Sutherland and Hodgman, 1974)."""
    for sign, limit in ((1.0, low), (-1.0, -high)):
        inside = sign * corners[:, 2] - limit
        kept: list[FloatArray] = []
        for i in range(len(corners)):
            a, b = inside[i - 1], inside[i]
            if (a < 0) != (b < 0):
                share = a / (a - b)
                kept.append(corners[i - 1] + share * (corners[i] - corners[i - 1]))
            if b >= 0:
                kept.append(corners[i])
        corners = np.array(kept).reshape(-1, 3)
    return corners


@dataclass(frozen=True, eq=False, slots=True)
class Obstacles:
    """Footprints of all that the robot, a circle of `radius` about its middle, can run into."""

    shape: BaseGeometry
    radius: float

    @classmethod
    def of(cls, solids: tuple[Solid, ...], *, radius: float, height: float) -> "Obstacles":
        """Return the solids' parts below the robot's `height`, in their unit."""
        shape = shapely.union_all([footprint(solid, height) for solid in solids])
        shapely.prepare(shape)
        return cls(shape, radius)

    def nearest(self, x: float, y: float) -> Contact | None:
        """Return the nearest point of any solid; the gap is negative where the circle overlaps
        it.
        """
        if self.shape.is_empty:
            return None
        line = shapely.shortest_line(shapely.Point(x, y), self.shape)
        (x0, y0), (x1, y1) = shapely.get_coordinates(line)
        gap = math.hypot(x1 - x0, y1 - y0) - self.radius
        return Contact(gap, math.atan2(y1 - y0, x1 - x0))

    def distance(self, x: float, y: float, heading: float, half: float, reach: float) -> float:
        """Return how far the nearest solid is from (x, y) in the directions from `heading` - `half`
        to `heading` + `half`; `reach` if none is so near.
        """
        here = shapely.Point(x, y)
        if not shapely.dwithin(self.shape, here, reach):
            return reach
        angles = heading + half * np.linspace(-1.0, 1.0, ARC)
        arc = np.array([x, y]) + reach * np.column_stack([np.cos(angles), np.sin(angles)])
        met = shapely.intersection(shapely.polygons(np.vstack([[x, y], arc])), self.shape)
        return reach if met.is_empty else min(float(met.distance(here)), reach)


RANGE = 5.0
"""Largest range, metres, and the one reported where nothing is detected (Pioneer 2 manual)."""
# The beam is some 30 degrees wide; the nearest thing anywhere in it is measured.
BEAM = math.radians(30)
ARRAY = 8
"""Sonars in an array; the arrays fire at the same time, one sonar of each at a time."""


@dataclass(slots=True)
class Sonars:
    """Fires one sonar of each array every `period` seconds, one after the other."""

    parameters: Parameters
    obstacles: Obstacles
    period: float
    on: bool = field(default=False, init=False)
    _fired: int = field(default=0, init=False)
    _since: float = field(default=0.0, init=False)

    def switch(self, on: bool, now: float) -> None:
        """SONAR: they fire, from now on, or no longer."""
        if on and not self.on:
            self._since = now
        self.on = on

    def readings(self, now: float, truth: Pose2) -> tuple[SonarReading, ...]:
        """Return the ranges measured since the last call: at most one for each sonar."""
        if not self.on:
            return ()
        due_count = int((now - self._since) / self.period + 1e-6)
        self._since += self.period * due_count
        fired = min(due_count, ARRAY)
        indices: list[int] = []
        for first in range(0, len(self.parameters.sonars), ARRAY):
            indices += [first + (self._fired + i) % ARRAY for i in range(fired)]
        self._fired += fired
        return tuple(SonarReading(i, self._measure(i, truth)) for i in indices)

    def _measure(self, index: int, truth: Pose2) -> int:
        place = self.parameters.sonars[index]
        return min(round(self._range(place, truth) / self.parameters.range), 0xFFFF)

    def _range(self, place: SonarPlace, truth: Pose2) -> float:
        c, s = math.cos(truth.heading), math.sin(truth.heading)
        x, y = truth.x + c * place.x - s * place.y, truth.y + s * place.x + c * place.y
        return self.obstacles.distance(x, y, truth.heading + place.heading, BEAM / 2, RANGE)
