"""A report in metres, radians and seconds: `RobotState`, and its computation."""

import math
from dataclasses import dataclass, field

from facetlog.perception.types import FloatArray
from facetlog.robot.pioneer.odometry import Odometry, OdometryErrors
from facetlog.robot.pioneer.packets.configuration import Configuration
from facetlog.robot.pioneer.packets.server_information import ServerInformation
from facetlog.robot.pioneer.parameters import Parameters, SonarPlace
from facetlog.robot.pose2 import Pose2

__all__ = ["STANDING_SPEED", "RobotState", "SonarRange", "StateMaker", "reports_motors"]

STANDING_SPEED = 0.005
"""m/s below which a wheel stands: some steps of the report's 1 … 2.5 mm/s."""
MOTORS, STOP_BUTTON, STOP_STALL = 1 << 0, 1 << 5, 1 << 6
"""Flags of the report (Pioneer 3 manual, table 8)."""
CHARGER_POWER = 1 << 10
BUMPERS = 5
"""Of a bumper ring: bits 1 to 5 (Pioneer 2 manual)."""
NO_TEMPERATURE = -127
OLD_FIRMWARE = frozenset({"p2dx", "p2de", "p2ce", "p2df", "p2at", "p2it"})
"""Pioneer 2 before the H8 boards, under P2OS: there the flags are a servo's pulse width."""


@dataclass(frozen=True, slots=True)
class SonarRange:
    """The last that a sonar measured: metres, when (s), and where it sits if that is known."""

    index: int
    range: float
    at: float
    place: SonarPlace | None = None


@dataclass(frozen=True, slots=True)
class RobotState:
    """The robot's state by its last report: metres, radians, seconds."""

    at: float
    """When its first byte came, on the driver's clock (monotonic unless another was given)."""
    pose: Pose2
    """In the frame in which the robot stood when the driver connected."""
    covariance: FloatArray = field(compare=False)
    """(3, 3), of x, y and heading."""
    speed: float
    """m/s ahead."""
    turning: float
    """rad/s, counter-clockwise."""
    left_speed: float
    right_speed: float
    battery_v: float
    """0 where the robot does not report it."""
    motors_on: bool | None
    """None until a flag or the robot's behaviour shows it."""
    stop_button: bool | None
    stalled: tuple[bool, bool]
    """Left wheel, right wheel."""
    front_bumpers: tuple[bool, ...]
    """From left to right."""
    rear_bumpers: tuple[bool, ...]
    """From right to left."""
    sonars: tuple[SonarRange, ...]
    """The last range of each that has measured yet."""
    charging: int | None
    """0 not, 1 bulk, 2 overcharge, 3 float, 4 balance; None where it is not reported."""
    charge: float | None
    """Share of the battery's charge, 0 … 1."""
    charger_power: bool | None
    stop_stall: bool | None
    """The stop button has stalled the wheels."""
    faults: int | None
    sideways: float | None
    """m/s to the left, of robots that can."""
    temperature_c: int | None
    digital_in: int | None
    digital_out: int | None
    analog: int | None
    gripper: int | None
    timer: float | None
    """Seconds of the robot's own clock."""
    raw: ServerInformation
    """The report in the robot's own integers, whatever else is in it."""

    @property
    def standing(self) -> bool:
        """Whether both wheels stand."""
        return max(abs(self.left_speed), abs(self.right_speed)) < STANDING_SPEED

    @property
    def bumped(self) -> bool:
        """Whether any bumper is pressed."""
        return any(self.front_bumpers) or any(self.rear_bumpers)


def reports_motors(parameters: Parameters) -> bool:
    """Whether the model's reports include the state of the motors: from AROS (H8 boards) on."""
    return parameters.has_move and parameters.name not in OLD_FIRMWARE


class StateMaker:
    """Makes a state of each report, in the order in which they came."""

    def __init__(
        self,
        parameters: Parameters,
        configuration: Configuration | None = None,
        errors: OdometryErrors | None = None,
    ) -> None:
        self._parameters = parameters
        self._odometry = Odometry(parameters, errors)
        self._ranges: dict[int, SonarRange] = {}
        self._reports_motors = reports_motors(parameters)
        self._front = self._rear = BUMPERS
        if configuration is not None and configuration.rear_bumpers is not None:
            self._front = configuration.front_bumpers or 0
            self._rear = configuration.rear_bumpers
        self.motors_thought_on: bool | None = None
        """For models that do not report it: the state inferred from their behaviour."""

    def state(self, sip: ServerInformation, at: float) -> tuple[RobotState, str | None]:
        """The state after a report that came at `at`, and why odometry is unreliable, if it is."""
        p = self._parameters
        doubt = self._odometry.update(sip, at)
        for reading in sip.sonar:
            place = p.sonars[reading.index] if reading.index < len(p.sonars) else None
            metres = reading.range * p.range
            self._ranges[reading.index] = SonarRange(reading.index, metres, at, place)
        left, right = sip.left * p.speed, sip.right * p.speed
        turning = (right - left) / 2 * p.turning_per_speed
        if sip.turning is not None:
            turning = math.radians(sip.turning / 10)
        state = RobotState(
            at=at,
            pose=self._odometry.pose,
            covariance=self._odometry.covariance,
            speed=(left + right) / 2,
            turning=turning,
            left_speed=left,
            right_speed=right,
            battery_v=(sip.battery_10 or sip.battery) / 10,
            motors_on=self._flag(sip, MOTORS, self.motors_thought_on),
            stop_button=self._flag(sip, STOP_BUTTON),
            stalled=(sip.stall_left, sip.stall_right),
            front_bumpers=_bits(sip.front_bumpers, self._front),
            rear_bumpers=_bits(sip.rear_bumpers, self._rear),
            sonars=tuple(self._ranges[index] for index in sorted(self._ranges)),
            charging=sip.charge_state,
            charge=None if sip.charge_percent is None else sip.charge_percent / 100,
            charger_power=self._flag(sip, CHARGER_POWER),
            stop_stall=self._flag(sip, STOP_STALL),
            faults=sip.faults,
            sideways=None if sip.sideways is None else sip.sideways / 1e3,
            temperature_c=_temperature(sip.temperature),
            digital_in=sip.digital_in,
            digital_out=sip.digital_out,
            analog=sip.analog,
            gripper=sip.gripper,
            timer=None if sip.timer is None else sip.timer / 1e6,
            raw=sip,
        )
        return state, doubt

    def _flag(self, sip: ServerInformation, bit: int, else_: bool | None = None) -> bool | None:
        return bool(sip.flags & bit) if self._reports_motors else else_


def _bits(value: int, count: int) -> tuple[bool, ...]:
    return tuple(bool(value >> bit & 1) for bit in range(count))


def _temperature(value: int | None) -> int | None:
    return None if value is None or value <= NO_TEMPERATURE else value
