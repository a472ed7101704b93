"""The half of the firmware that moves: motors, commands of motion, odometry, stalls."""

import math
import struct
from dataclasses import dataclass, field, replace

from facetlog.robot.pioneer.packets.commands import NEGATIVE, Command, argument_of
from facetlog.robot.pioneer.packets.configuration import SIMULATOR, Configuration
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.simulator.body.contacts import Contacts, pressed
from facetlog.robot.simulator.body.dynamics import STEP, Body, Truth
from facetlog.robot.simulator.firmware.generations import generation_of
from facetlog.robot.simulator.firmware.servo import Odometry, Servo
from facetlog.robot.simulator.firmware.settings import Settings

__all__ = ["Drive"]

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
        self.settings = Settings.of(self.configuration, generation_of(self.parameters.name))
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
                value = argument_of(packet)
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
