"""The motion half of the simulated firmware: motors, settings, speed control, odometry, stalls.

Translation and rotation are commanded separately, by VEL and RVEL; the last command holds until the
next one.
"""

import math
from dataclasses import dataclass, field, replace

from facetlog.robot.pioneer.packets.commands import Command, read_argument
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import SIMULATOR, Configuration
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.body import STEP, Body, Contacts, pressed


def add_arc(pose: Pose2, way: float, turn: float) -> Pose2:
    """Return the pose after a small way along an arc."""
    middle = pose.heading + turn / 2
    return Pose2(
        pose.x + way * math.cos(middle),
        pose.y + way * math.sin(middle),
        math.remainder(pose.heading + turn, 2 * math.pi),
    )


@dataclass(frozen=True, slots=True)
class Ramp:
    """Limits of one speed: the largest, and how fast it grows and falls."""

    highest: float
    acceleration: float
    deceleration: float

    def towards(self, speed: float, goal: float, deceleration: float | None = None) -> float:
        """Return the speed a step later on the way to a goal."""
        goal = min(max(goal, -self.highest), self.highest)
        falls = self.deceleration if deceleration is None else deceleration
        if speed * goal < 0.0:
            goal = 0.0  # first to a stand
        change = (falls if abs(goal) < abs(speed) else self.acceleration) * STEP
        return min(max(goal, speed - change), speed + change)


@dataclass(slots=True)
class Servo:
    """The commanded speeds, ahead and of turning."""

    ahead: Ramp
    turn: Ramp
    hard_deceleration: float
    """m/s² of an emergency stop."""
    hard_turn_deceleration: float
    _speed: float = field(default=0.0, init=False)
    _turning: float = field(default=0.0, init=False)
    _emergency: bool = field(default=False, init=False)

    def drive(self, speed: float) -> None:
        if not self._emergency:
            self._speed = speed

    def rotate(self, turning: float) -> None:
        if not self._emergency:
            self._turning = turning

    def stop(self) -> None:
        """Stop with the usual deceleration (STOP)."""
        self._speed = self._turning = 0.0

    def emergency_stop(self) -> None:
        """Stop as hard as possible (ESTOP)."""
        self.stop()
        self._emergency = True

    def compute_next_speeds(
        self, speed: float, turning: float, *, held: bool = False
    ) -> tuple[float, float]:
        """Return speed and turning a step later. `held`: to a stand now, and go on with it
        afterwards."""
        if self._emergency:
            if speed == 0.0 and turning == 0.0:
                self._emergency = False
            return (
                self.ahead.towards(speed, 0.0, self.hard_deceleration),
                self.turn.towards(turning, 0.0, self.hard_turn_deceleration),
            )
        wanted = (0.0, 0.0) if held else (self._speed, self._turning)
        return self.ahead.towards(speed, wanted[0]), self.turn.towards(turning, wanted[1])


BOTH_RINGS = 3
"""BUMPSTALL: 0 none, 1 the front ring, 2 the rear one, 3 both."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Limits in millimetres and degrees, as they stand on the wire."""

    speed_top: int
    turning_top: int
    acceleration_top: int
    turning_acceleration_top: int
    speed: int
    turning: int
    acceleration: int
    deceleration: int
    turning_acceleration: int
    turning_deceleration: int
    bump_stall: int
    e_stall: bool

    @classmethod
    def of(cls, configuration: Configuration, parameters: Parameters) -> "Settings":
        """Return the settings at start. Bumpers and stop button stall the robot from AROS on."""
        stalls = parameters.generation.reports_motors
        return cls(
            speed_top=configuration.speed_top or 0,
            turning_top=configuration.turning_top or 0,
            acceleration_top=configuration.acceleration_top or 0,
            turning_acceleration_top=configuration.turning_acceleration_top or 0,
            speed=configuration.speed_max or 0,
            turning=configuration.turning_max or 0,
            acceleration=configuration.acceleration or 0,
            deceleration=configuration.deceleration or 0,
            turning_acceleration=configuration.turning_acceleration or 0,
            turning_deceleration=configuration.turning_deceleration or 0,
            bump_stall=BOTH_RINGS if stalls else 0,
            e_stall=stalls,
        )

    def changed(self, command: Command, value: int) -> "Settings":
        """Return the settings after a command; other commands and limits of zero change none."""
        match command:
            case Command.BUMPSTALL if 0 <= value <= BOTH_RINGS:
                return replace(self, bump_stall=value)
            case Command.E_STALL:
                return replace(self, e_stall=value != 0)
        if value == 0:
            return self
        size = abs(value)
        linear, angular = (
            min(size, self.acceleration_top),
            min(size, self.turning_acceleration_top),
        )
        match command:
            case Command.SETV:
                return replace(self, speed=min(size, self.speed_top))
            case Command.SETRV:
                return replace(self, turning=min(size, self.turning_top))
            case Command.SETA if value > 0:
                return replace(self, acceleration=linear)
            case Command.SETA:
                return replace(self, deceleration=linear)
            case Command.SETRA if value > 0:
                return replace(self, turning_acceleration=angular)
            case Command.SETRA:
                return replace(self, turning_deceleration=angular)
        return self

    def ramps(self) -> tuple[Ramp, Ramp]:
        """Return limits ahead in m/s and m/s², and of turning in rad/s and rad/s²."""
        ahead = (self.speed, self.acceleration, self.deceleration)
        turn = (self.turning, self.turning_acceleration, self.turning_deceleration)
        return Ramp(*(mm / 1e3 for mm in ahead)), Ramp(*(math.radians(deg) for deg in turn))

    def get_hard_decelerations(self) -> tuple[float, float]:
        """Return m/s² and rad/s² of an emergency stop: as much as the robot can."""
        return self.acceleration_top / 1e3, math.radians(self.turning_acceleration_top)

    def reported(self, configuration: Configuration) -> Configuration:
        """Return the answer to CONFIG, with what has been set since."""
        return replace(
            configuration,
            speed_max=self.speed,
            turning_max=self.turning,
            acceleration=self.acceleration,
            deceleration=self.deceleration,
            turning_acceleration=self.turning_acceleration,
            turning_deceleration=self.turning_deceleration,
        )


ROLL_OUT, ROLL_OUT_TURN = 1.0, 3.0
"""m/s² and rad/s² with which the gears stop a robot whose motors are off."""


@dataclass(slots=True)
class Drive:
    """Motors, wheels and their commands; seconds, metres and radians."""

    parameters: Parameters
    configuration: Configuration
    body: Body
    motors: bool = field(default=False, init=False)
    stop_button: bool = field(default=False, init=False)
    odometry: Pose2 = field(default=Pose2(), init=False)
    """The firmware's pose estimate since odometry was last reset."""
    settings: Settings = field(init=False)
    contacts: Contacts = field(init=False)
    servo: Servo = field(init=False)

    def __post_init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Reset as after power-on: motors off, settings and odometry as at first."""
        self.settings = Settings.of(self.configuration, self.parameters)
        ahead, turn = self.settings.ramps()
        self.servo = Servo(ahead, turn, *self.settings.get_hard_decelerations())
        self.contacts = Contacts((self.configuration.stall_count or 0) / 1e3)
        self.odometry = Pose2()
        self.motors = False

    def name_camera(self, address: str) -> None:
        """Report the camera's address in the serial number, unless the world file gives one."""
        if self.configuration.serial_number == SIMULATOR:
            serial_number = f"{SIMULATOR} {address}"
            self.configuration = replace(self.configuration, serial_number=serial_number)

    def enable(self, on: bool) -> None:
        """Switch motors on, unless the stop button is pressed, or off; clear motion commands."""
        on = on and not self.stop_button
        if on != self.motors:
            self.motors = on
            self.servo.stop()

    def press_stop_button(self, now: float, *, pressed: bool) -> None:
        """Press the red button: motors go off and cannot be switched on until it is released."""
        self.stop_button = pressed
        if pressed:
            self.enable(False)
            if self.settings.e_stall:
                self.contacts.stall(now)

    def bumpers(self) -> tuple[int, int]:
        """Return bits of the bumpers in front and behind that are pressed."""
        front, rear = self.configuration.front_bumpers, self.configuration.rear_bumpers
        return pressed(self.body.contact, self.body.truth, front or 0, rear or 0)

    def step(self, now: float, *, held: bool) -> None:
        """Go on for a step of the dynamics; `held`: to a stand, and on with it afterwards."""
        body = self.body
        if self.motors and not self.contacts.stalled:
            body.speed, body.turning = self.servo.compute_next_speeds(
                body.speed, body.turning, held=held
            )
        else:
            falls = (ROLL_OUT, ROLL_OUT_TURN)
            if self.motors:
                falls = self.settings.get_hard_decelerations()
            body.speed = _reduce_speed(body.speed, falls[0] * STEP)
            body.turning = _reduce_speed(body.turning, falls[1] * STEP)
        way, turn = body.step()
        self.odometry = add_arc(self.odometry, way, turn)
        front, rear = self.bumpers()
        stalling = self.settings.bump_stall
        bumped = bool(front and stalling & 1) or bool(rear and stalling & 2)
        self.contacts.step(now, blocked=body.blocked, bumped=bumped)

    def obey(self, command: Command, packet: Packet) -> None:
        """Carry out a command of motion or its settings; others change nothing.

        PacketError if its argument is malformed.
        """
        match command:
            case Command.STOP:
                self.servo.stop()
            case Command.ESTOP:
                self.servo.emergency_stop()
            case _:
                value = read_argument(packet)
                if isinstance(value, int):
                    self._obey_number(command, value)

    def _obey_number(self, command: Command, value: int) -> None:
        if command is Command.ENABLE:
            self.enable(value != 0)
        elif command is Command.VEL:
            if self.motors:  # without them nothing is kept for later
                self.servo.drive(value / 1e3)
        elif command is Command.RVEL:
            if self.motors:
                self.servo.rotate(math.radians(value))
        else:
            self.settings = self.settings.changed(command, value)
            self.servo.ahead, self.servo.turn = self.settings.ramps()


def _reduce_speed(speed: float, change: float) -> float:
    return math.copysign(max(abs(speed) - change, 0.0), speed)
