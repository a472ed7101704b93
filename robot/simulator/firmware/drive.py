"""The motion half of the simulated firmware: motors, settings, speed control, odometry, stalls.

Translation and rotation are commanded separately, by VEL or MOVE and by RVEL or a heading; the last
command holds until the next one.
"""

import math
import struct
from dataclasses import dataclass, field, replace

from facetlog.robot.pioneer.packets.commands import NEGATIVE, Command, read_argument
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import SIMULATOR, Configuration
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.simulator.body import STEP, Body, Contacts, Truth, pressed
from facetlog.robot.simulator.firmware.generations import Generation, find_generation

# A way or heading is reached when less than this is left; both are below a unit of the SIP.
WAY_REACHED = 2e-4  # metres
TURN_REACHED = math.radians(0.02)


@dataclass(frozen=True, slots=True)
class Odometry:
    """The firmware's pose estimate since odometry was last reset; metres and radians."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def moved(self, way: float, turn: float) -> "Odometry":
        """After a small way along an arc."""
        middle = self.heading + turn / 2
        return Odometry(
            self.x + way * math.cos(middle),
            self.y + way * math.sin(middle),
            math.remainder(self.heading + turn, 2 * math.pi),
        )


@dataclass(frozen=True, slots=True)
class Ramp:
    """Limits of one speed: the largest in either direction, and how fast it grows and falls."""

    highest: float
    lowest: float
    acceleration: float
    deceleration: float

    def towards(self, speed: float, goal: float, deceleration: float | None = None) -> float:
        """The speed a step later on the way to a goal."""
        goal = min(max(goal, self.lowest), self.highest)
        falls = self.deceleration if deceleration is None else deceleration
        if speed * goal < 0.0:
            goal = 0.0  # first to a stand
        change = (falls if abs(goal) < abs(speed) else self.acceleration) * STEP
        return min(max(goal, speed - change), speed + change)

    def for_way(self, left: float) -> float:
        """The speed from which the rest of a way is just enough to stop."""
        # v² = 2 a s, less half a step's fall, for the speed changes in steps.
        speed = math.sqrt(2 * self.deceleration * abs(left)) - self.deceleration * STEP / 2
        return math.copysign(min(max(speed, 0.0), abs(left) / STEP), left)


@dataclass(slots=True)
class Servo:
    """The commanded targets: a speed or a distance ahead, a turning speed or a heading."""

    ahead: Ramp
    turn: Ramp
    hard_deceleration: float
    """m/s² of an emergency stop."""
    hard_turn_deceleration: float
    _speed: float = field(default=0.0, init=False)
    _way: float | None = field(default=None, init=False)
    _turning: float = field(default=0.0, init=False)
    _heading: float | None = field(default=None, init=False)
    _emergency: bool = field(default=False, init=False)

    @property
    def heading(self) -> float | None:
        """The commanded heading, in the frame of odometry; None if a turning speed was."""
        return self._heading

    def drive(self, speed: float) -> None:
        if not self._emergency:
            self._speed, self._way = speed, None

    def move(self, way: float) -> None:
        if not self._emergency:
            self._speed, self._way = 0.0, way

    def rotate(self, turning: float) -> None:
        if not self._emergency:
            self._turning, self._heading = turning, None

    def head(self, heading: float) -> None:
        """HEAD: to a heading in the frame of odometry, the shorter way round."""
        if not self._emergency:
            self._turning, self._heading = 0.0, heading

    def stop(self) -> None:
        """Stop with the usual deceleration (STOP)."""
        self._speed, self._way, self._turning, self._heading = 0.0, None, 0.0, None

    def emergency_stop(self) -> None:
        """Stop as hard as possible (ESTOP)."""
        self.stop()
        self._emergency = True

    def turn_frame(self, turn: float) -> None:
        """Odometry's headings jumped by `turn`: the commanded one stays the same direction."""
        if self._heading is not None:
            self._heading += turn

    def went(self, way: float) -> None:
        """Reduce the commanded distance by one that was driven, by odometry."""
        if self._way is not None:
            self._way -= way

    def next_speeds(
        self, speed: float, turning: float, heading: float, *, held: bool = False
    ) -> tuple[float, float]:
        """Speed and turning a step later. `held`: to a stand now, and go on with it afterwards."""
        if self._emergency:
            if speed == 0.0 and turning == 0.0:
                self._emergency = False
            return (
                self.ahead.towards(speed, 0.0, self.hard_deceleration),
                self.turn.towards(turning, 0.0, self.hard_turn_deceleration),
            )
        if held:
            return self.ahead.towards(speed, 0.0), self.turn.towards(turning, 0.0)
        return self._next_speed(speed), self._next_turning(turning, heading)

    def _next_speed(self, speed: float) -> float:
        if self._way is None:
            return self.ahead.towards(speed, self._speed)
        if abs(self._way) < WAY_REACHED and abs(speed) <= self.ahead.deceleration * STEP:
            self._way, self._speed = None, 0.0
            return 0.0
        return self.ahead.towards(speed, self.ahead.for_way(self._way))

    def _next_turning(self, turning: float, heading: float) -> float:
        if self._heading is None:
            return self.turn.towards(turning, self._turning)
        left = math.remainder(self._heading - heading, 2 * math.pi)
        if abs(left) < TURN_REACHED and abs(turning) <= self.turn.deceleration * STEP:
            return 0.0
        return self.turn.towards(turning, self.turn.for_way(left))


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
    left_turning: int
    right_turning: int
    acceleration: int
    deceleration: int
    turning_acceleration: int
    turning_deceleration: int
    bump_stall: int
    e_stall: bool

    @classmethod
    def of(cls, configuration: Configuration, generation: Generation) -> "Settings":
        """Return the settings at start. Bumpers and stop button stall the robot from AROS on."""
        turning = configuration.turning_max or 0
        return cls(
            speed_top=configuration.speed_top or 0,
            turning_top=configuration.turning_top or 0,
            acceleration_top=configuration.acceleration_top or 0,
            turning_acceleration_top=configuration.turning_acceleration_top or 0,
            speed=configuration.speed_max or 0,
            left_turning=turning,
            right_turning=turning,
            acceleration=configuration.acceleration or 0,
            deceleration=configuration.deceleration or 0,
            turning_acceleration=configuration.turning_acceleration or 0,
            turning_deceleration=configuration.turning_deceleration or 0,
            bump_stall=BOTH_RINGS if generation.reports_motors else 0,
            e_stall=generation.reports_motors,
        )

    def changed(self, command: Command, value: int) -> "Settings":
        """After a command that sets something; unchanged by any other, and by a limit of zero."""
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
                turning = min(size, self.turning_top)
                return replace(self, left_turning=turning, right_turning=turning)
            case Command.SETRVDIR if value > 0:
                return replace(self, left_turning=min(size, self.turning_top))
            case Command.SETRVDIR:
                return replace(self, right_turning=min(size, self.turning_top))
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
        """Limits ahead in m/s and m/s², and of turning in rad/s and rad/s²."""
        ahead = (self.speed, -self.speed, self.acceleration, self.deceleration)
        turn = (
            self.left_turning,
            -self.right_turning,
            self.turning_acceleration,
            self.turning_deceleration,
        )
        return Ramp(*(mm / 1e3 for mm in ahead)), Ramp(*(math.radians(deg) for deg in turn))

    def hard_decelerations(self) -> tuple[float, float]:
        """m/s² and rad/s² of an emergency stop: as much as the robot can."""
        return self.acceleration_top / 1e3, math.radians(self.turning_acceleration_top)

    def reported(self, configuration: Configuration) -> Configuration:
        """The answer to CONFIG, with what has been set since."""
        return replace(
            configuration,
            speed_max=self.speed,
            turning_max=self.left_turning,
            acceleration=self.acceleration,
            deceleration=self.deceleration,
            turning_acceleration=self.turning_acceleration,
            turning_deceleration=self.turning_deceleration,
        )


ROLL_OUT, ROLL_OUT_TURN = 1.0, 3.0
"""m/s² and rad/s² with which the gears stop a robot whose motors are off."""


@dataclass(slots=True)
class Drive:
    """Motors, wheels and their commands; seconds, metres and radians.

    `home` is where SIM_RESET puts the robot.
    """

    parameters: Parameters
    configuration: Configuration
    body: Body
    home: Truth
    motors: bool = field(default=False, init=False)
    stop_button: bool = field(default=False, init=False)
    odometry: Odometry = field(default=Odometry(), init=False)
    settings: Settings = field(init=False)
    contacts: Contacts = field(init=False)
    servo: Servo = field(init=False)

    def __post_init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """As after power-on: motors off, settings and odometry as at first."""
        self.settings = Settings.of(self.configuration, find_generation(self.parameters.name))
        ahead, turn = self.settings.ramps()
        self.servo = Servo(ahead, turn, *self.settings.hard_decelerations())
        self.contacts = Contacts((self.configuration.stall_count or 0) / 1e3)
        self.odometry = Odometry()
        self.motors = False
        self.body.left = self.body.right = 0.0

    def name_camera(self, address: str) -> None:
        """Report the camera's address in the serial number, unless the world file gives one."""
        if self.configuration.serial_number == SIMULATOR:
            serial_number = f"{SIMULATOR} {address}"
            self.configuration = replace(self.configuration, serial_number=serial_number)

    def enable(self, on: bool) -> None:
        """Motors on, unless the stop button is pressed, or off; motion commands are cleared."""
        on = on and not self.stop_button
        if on != self.motors:
            self.motors = on
            self.servo.stop()

    def press_stop_button(self, now: float, *, pressed: bool) -> None:
        """The red button: motors go off and cannot be switched on until it is released."""
        self.stop_button = pressed
        if pressed:
            self.enable(False)
            if self.settings.e_stall:
                self.contacts.stall(now)

    def bumpers(self) -> tuple[int, int]:
        """Bits of the bumpers in front and behind that are pressed."""
        front, rear = self.configuration.front_bumpers, self.configuration.rear_bumpers
        return pressed(self.body.contact, self.body.truth, front or 0, rear or 0)

    def step(self, now: float, *, held: bool) -> None:
        """Goes on for a step of the dynamics; `held`: to a stand, and on with it afterwards."""
        body = self.body
        if self.motors and not self.contacts.stalled:
            body.speed, body.turning = self.servo.next_speeds(
                body.speed, body.turning, self.odometry.heading, held=held
            )
        else:
            falls = (ROLL_OUT, ROLL_OUT_TURN)
            if self.motors:
                falls = self.settings.hard_decelerations()
            body.speed = _nearer_zero(body.speed, falls[0] * STEP)
            body.turning = _nearer_zero(body.turning, falls[1] * STEP)
        way, turn = body.step()
        self.odometry = self.odometry.moved(way, turn)
        self.servo.went(way)
        front, rear = self.bumpers()
        stalling = self.settings.bump_stall
        bumped = bool(front and stalling & 1) or bool(rear and stalling & 2)
        self.contacts.step(now, blocked=body.blocked, bumped=bumped)

    def obey(self, command: Command, packet: Packet) -> None:
        """Carries out a command of motion or its settings; others change nothing.

        PacketError or struct.error if its argument is malformed.
        """
        match command:
            case Command.STOP:
                self.servo.stop()
            case Command.ESTOP | Command.QSTOP:
                self.servo.emergency_stop()
            case Command.SETO:
                self._set_origin(packet.payload)
            case Command.VEL2:
                self._drive_wheels(packet.payload)
            case Command.SIM_SET_POSE:
                x, y, degrees = struct.unpack_from("<iii", packet.payload, 1)
                self.body.place(Truth(x / 1e3, y / 1e3, math.radians(degrees)))
            case Command.SIM_RESET:
                self.body.place(self.home)
                self._set_origin(b"")
            case _:
                value = read_argument(packet)
                if isinstance(value, int):
                    self._obey_number(command, value)

    def _obey_number(self, command: Command, value: int) -> None:
        if command is Command.ENABLE:
            self.enable(value != 0)
        elif command in _MOTIONS:
            if self.motors:  # without them nothing is kept for later
                self._obey_motion(command, value)
        else:
            self.settings = self.settings.changed(command, value)
            self.servo.ahead, self.servo.turn = self.settings.ramps()

    def _obey_motion(self, command: Command, value: int) -> None:
        heading = self.odometry.heading
        match command:
            case Command.VEL:
                self.servo.drive(value / 1e3)
            case Command.MOVE:
                if self.parameters.has_move:
                    self.servo.move(value / 1e3)
            case Command.RVEL | Command.ROTATE:
                self.servo.rotate(math.radians(value))
            case Command.HEAD:
                self.servo.head(math.radians(value))
            case Command.DHEAD:
                self.servo.head(heading + math.radians(value))
            case Command.DCHEAD:
                commanded = self.servo.heading
                self.servo.head((heading if commanded is None else commanded) + math.radians(value))

    def _drive_wheels(self, payload: bytes) -> None:
        """VEL2: after the argument's type the right wheel's speed, then the left one's.

        With the type of a negative number the two bytes are its magnitude.
        """
        kind, word = struct.unpack_from("<BH", payload)
        if kind == NEGATIVE:
            word = -word & 0xFFFF
        right, left = struct.unpack("<bb", struct.pack("<H", word))
        if self.motors:
            step = self.parameters.wheel_step
            self.servo.drive(step * (left + right) / 2)
            self.servo.rotate(step * (right - left) / self.body.track)

    def _set_origin(self, payload: bytes) -> None:
        """SETO: odometry becomes 0, 0, 0, or what three numbers say (mm, mm, degrees)."""
        x, y, degrees = 0, 0, 0
        if len(payload) >= 7:
            x, y, degrees = struct.unpack_from("<hhh", payload, 1)
        before, heading = self.odometry.heading, math.radians(degrees)
        self.odometry = Odometry(x / 1e3, y / 1e3, heading)
        self.servo.turn_frame(heading - before)


_MOTIONS = frozenset(
    {
        Command.VEL,
        Command.MOVE,
        Command.RVEL,
        Command.ROTATE,
        Command.HEAD,
        Command.DHEAD,
        Command.DCHEAD,
    }
)


def _nearer_zero(speed: float, change: float) -> float:
    return math.copysign(max(abs(speed) - change, 0.0), speed)
