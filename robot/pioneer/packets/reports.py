"""Reports of the robot: what their bytes mean, read and written with one table of fields."""

import math
import struct
from dataclasses import dataclass
from enum import IntEnum

from facetlog.robot.pioneer.packets.packet import Packet, PacketError
from facetlog.robot.pose2 import Pose2


class Report(IntEnum):
    """Kinds of packets that the robot sends."""

    SYNC0 = 0
    SYNC1 = 1
    SYNC2 = 2
    CONFIG = 0x20
    SIM_STAT = 0x62
    """Where a simulated robot truly is."""
    ENCODER = 0x90
    GYRO = 0x98
    SERAUX = 0xB0
    """Bytes that came in at AUX1, as many as were requested."""
    SERAUX2 = 0xB8
    TCM2 = 0xC0
    SERAUX3 = 0xC8
    PLAYLIST = 0xD0
    GRIPPER = 0xE0
    IO = 0xF0
    JOYSTICK = 0xF8
    BATTERY = 0xFA
    RESET_1 = 0xFE
    """The controller was reset: the session is over."""
    RESET_2 = 0xFF
    """The same; during the handshake: a synchronisation packet was out of order."""


@dataclass(frozen=True, slots=True)
class Names:
    """The robot's name, class and subclass in its answer to SYNC2."""

    name: str
    robot_class: str
    subclass: str

    @classmethod
    def from_packet(cls, packet: Packet) -> "Names":
        """The three strings of the answer; those that are missing are empty."""
        parts = [part.decode("latin-1") for part in packet.payload.split(b"\0")]
        name, robot_class, subclass, *_ = [*parts, "", "", ""]
        return cls(name, robot_class, subclass)

    def to_packet(self) -> Packet:
        """The answer to SYNC2."""
        parts = (self.name, self.robot_class, self.subclass)
        return Packet(Report.SYNC2, b"".join(part.encode("latin-1") + b"\0" for part in parts))


@dataclass(frozen=True, slots=True)
class Encoders:
    """Ticks of both wheels since the robot was switched on."""

    left: int
    right: int

    @classmethod
    def from_packet(cls, packet: Packet) -> "Encoders":
        """What an ENCODER packet says; PacketError if it is too short."""
        if len(packet.payload) < 8:
            raise PacketError(f"an ENCODER packet of {len(packet.payload)} bytes: 8 are needed")
        return cls(*struct.unpack_from("<ii", packet.payload))

    def to_packet(self) -> Packet:
        """As the robot sends it."""
        return Packet(Report.ENCODER, struct.pack("<ii", self.left, self.right))


@dataclass(frozen=True, slots=True)
class InputsOutputs:
    """Digital inputs and outputs (bytes), and analog inputs."""

    digital_in: bytes = b""
    digital_out: bytes = b""
    analog: tuple[int, ...] = ()

    @classmethod
    def from_packet(cls, packet: Packet) -> "InputsOutputs":
        """What an IO packet says; PacketError if it ends before what it counts."""
        data = packet.payload
        try:
            inputs = data[1 : 1 + data[0]]
            at = 1 + data[0]
            outputs = data[at + 1 : at + 1 + data[at]]
            at += 1 + data[at]
            analog = struct.unpack_from(f"<{data[at]}H", data, at + 1)
        except (IndexError, struct.error):
            raise PacketError(f"an IO packet that ends too early: {data.hex(' ')}") from None
        return cls(inputs, outputs, analog)

    def to_packet(self) -> Packet:
        """As the robot sends it."""
        data = bytes([len(self.digital_in)]) + self.digital_in
        data += bytes([len(self.digital_out)]) + self.digital_out
        data += struct.pack(f"<B{len(self.analog)}H", len(self.analog), *self.analog)
        return Packet(Report.IO, data)


TEXTS = 2
BEFORE = struct.Struct("<IHHH")
POSE = struct.Struct("<iiii")
BEHIND = struct.Struct("<iiiiiii")
NO_FIX = -1


@dataclass(frozen=True, slots=True)
class TruePose:
    """The pose in the simulator's world, in metres and radians."""

    pose: Pose2

    @classmethod
    def from_packet(cls, packet: Packet) -> "TruePose":
        """What the packet says; PacketError if it ends before the pose does."""
        data, at = packet.payload, 0
        for _ in range(TEXTS):
            at = data.find(b"\0", at) + 1
            if not at:
                raise PacketError("a SIM_STAT packet without its two texts")
        at += BEFORE.size
        if len(data) < at + POSE.size:
            raise PacketError(f"a SIM_STAT packet of {len(data)} bytes ends before the pose")
        x, y, _, heading = POSE.unpack_from(data, at)
        return cls(Pose2(x / 1e3, y / 1e3, math.radians(heading)))

    def to_packet(self) -> Packet:
        """As simulators send it: whole millimetres and degrees."""
        x, y = round(self.pose.x * 1e3), round(self.pose.y * 1e3)
        heading = round(math.degrees(self.pose.heading))
        return Packet(
            Report.SIM_STAT,
            bytes(TEXTS)
            + BEFORE.pack(0, 0, 0, 0)
            + POSE.pack(x, y, 0, heading)
            + BEHIND.pack(0, 0, 0, NO_FIX, 0, 0, 0),
        )


CONFIGURATION_KIND = 0x20
AUTOBAUD = 2
"""Value of `autobaud` of a port that takes a change of its speed."""

SIMULATOR = "facetlog"
"""First word of the serial number of a robot that `facetlog simulate` is; its camera's address is
the second. Other simulators have "SIM"."""

STRING = "s"
LAYOUT = (
    ("robot_class", STRING),
    ("subclass", STRING),
    ("serial_number", STRING),
    ("four_motors", "B"),
    ("turning_top", "H"),
    ("speed_top", "H"),
    ("turning_acceleration_top", "H"),
    ("acceleration_top", "H"),
    ("pwm_max", "H"),
    ("name", STRING),
    ("cycle_ms", "B"),
    ("host_baud", "B"),
    ("aux1_baud", "B"),
    ("gripper", "H"),
    ("front_sonar", "H"),
    ("rear_sonar", "B"),
    ("low_battery", "H"),
    ("rev_count", "H"),
    ("watchdog_ms", "H"),
    ("normal_packets", "B"),
    ("stall_value", "H"),
    ("stall_count", "H"),
    ("joystick_speed", "H"),
    ("joystick_turning", "H"),
    ("turning_max", "H"),
    ("speed_max", "H"),
    ("turning_acceleration", "H"),
    ("turning_deceleration", "H"),
    ("rot_kp", "H"),
    ("rot_kv", "H"),
    ("rot_ki", "H"),
    ("acceleration", "H"),
    ("deceleration", "H"),
    ("trans_kp", "H"),
    ("trans_kv", "H"),
    ("trans_ki", "H"),
    ("front_bumpers", "B"),
    ("rear_bumpers", "B"),
    ("charger", "B"),
    ("sonar_cycle", "B"),
    ("autobaud", "B"),
    ("gyro", "B"),
    ("drift_factor", "h"),
    ("aux2_baud", "B"),
    ("aux3_baud", "B"),
    ("ticks_mm", "H"),
    ("shutdown_voltage", "H"),
    ("firmware", STRING),
    ("gyro_clockwise", "H"),
    ("gyro_counter_clockwise", "H"),
    ("kinematics_delay", "B"),
)


@dataclass(frozen=True, slots=True)
class Configuration:
    """The robot's make, its limits and its settings."""

    robot_class: str
    subclass: str
    serial_number: str | None = None
    four_motors: int | None = None
    turning_top: int | None = None
    """The robot never turns faster, whatever is commanded."""
    speed_top: int | None = None
    turning_acceleration_top: int | None = None
    acceleration_top: int | None = None
    pwm_max: int | None = None
    name: str | None = None
    cycle_ms: int | None = None
    """Between two reports."""
    host_baud: int | None = None
    aux1_baud: int | None = None
    gripper: int | None = None
    front_sonar: int | None = None
    rear_sonar: int | None = None
    low_battery: int | None = None
    """Tenths of a volt."""
    rev_count: int | None = None
    watchdog_ms: int | None = None
    normal_packets: int | None = None
    stall_value: int | None = None
    stall_count: int | None = None
    joystick_speed: int | None = None
    joystick_turning: int | None = None
    turning_max: int | None = None
    speed_max: int | None = None
    turning_acceleration: int | None = None
    turning_deceleration: int | None = None
    rot_kp: int | None = None
    rot_kv: int | None = None
    rot_ki: int | None = None
    acceleration: int | None = None
    deceleration: int | None = None
    trans_kp: int | None = None
    trans_kv: int | None = None
    trans_ki: int | None = None
    front_bumpers: int | None = None
    """How many there are."""
    rear_bumpers: int | None = None
    charger: int | None = None
    sonar_cycle: int | None = None
    autobaud: int | None = None
    gyro: int | None = None
    drift_factor: int | None = None
    aux2_baud: int | None = None
    aux3_baud: int | None = None
    ticks_mm: int | None = None
    shutdown_voltage: int | None = None
    firmware: str | None = None
    gyro_clockwise: int | None = None
    gyro_counter_clockwise: int | None = None
    kinematics_delay: int | None = None

    @property
    def simulated(self) -> bool:
        """Whether it is of `facetlog simulate`."""
        return (self.serial_number or "").split()[:1] == [SIMULATOR]

    @property
    def simulated_camera(self) -> str | None:
        """The address of the simulated camera; None of a real robot or another simulator."""
        words = (self.serial_number or "").split()
        return words[1] if self.simulated and len(words) > 1 else None

    @classmethod
    def from_packet(cls, packet: Packet) -> "Configuration":
        """The contents of a CONFIG packet; PacketError if not even class and subclass are in it."""
        data, at = packet.payload, 0
        found: dict[str, str | int] = {}
        for name, form in LAYOUT:
            if form == STRING:
                end = data.find(b"\0", at)
                if end < 0:
                    break
                found[name] = data[at:end].decode("latin-1")
                at = end + 1
                continue
            size = struct.calcsize("<" + form)
            if len(data) < at + size:
                break
            (found[name],) = struct.unpack_from("<" + form, data, at)
            at += size
        if "subclass" not in found:
            raise PacketError(f"a CONFIG packet without class and subclass: {data[:40].hex(' ')}")
        return cls(**found)  # type: ignore[arg-type]

    def to_packet(self) -> Packet:
        """As the robot sends it, with the fields down to the first that is None."""
        data = b""
        for name, form in LAYOUT:
            value = getattr(self, name)
            if value is None:
                break
            if form == STRING:
                data += value.encode("latin-1") + b"\0"
            else:
                data += struct.pack("<" + form, value)
        return Packet(CONFIGURATION_KIND, data)


STOPPED, MOVING = 0x32, 0x33
SIP_KINDS = frozenset(range(0x30, 0x35))
"""Manuals and simulators disagree on their meaning: motion is not read from them."""

HEAD = struct.Struct("<HHhhhBHhHBB")
SONAR = struct.Struct("<BH")
TAIL = (
    ("gripper", "H"),
    ("analog", "B"),
    ("digital_in", "B"),
    ("digital_out", "B"),
    ("battery_10", "H"),
    ("charge_state", "B"),
    ("turning", "h"),
    ("faults", "H"),
    ("sideways", "h"),
    ("temperature", "b"),
    ("charge_percent", "B"),
    ("timer", "I"),
    ("flags_3", "I"),
)
"""Fields behind the sonar readings, in their order."""


@dataclass(frozen=True, slots=True)
class SonarReading:
    """What one sonar measured: its number, and the range in the robot's unit."""

    index: int
    range: int


@dataclass(frozen=True, slots=True)
class ServerInformation:
    """One report of the robot."""

    x: int
    """Position: 15 bits (12 on some firmware), which wrap around."""
    y: int
    heading: int
    left: int
    """Speed of the left wheel."""
    right: int
    battery: int
    """Tenths of a volt."""
    stall_left: bool
    stall_right: bool
    rear_bumpers: int
    """A bit for each that is pressed, the rightmost lowest."""
    front_bumpers: int
    """A bit for each that is pressed, the leftmost lowest."""
    control: int
    flags: int
    """Bits of the state from AROS on; on P2OS a pulse width that means nothing here."""
    compass: int
    sonar: tuple[SonarReading, ...] = ()
    gripper: int | None = None
    analog: int | None = None
    digital_in: int | None = None
    digital_out: int | None = None
    battery_10: int | None = None
    """Tenths of a volt, of batteries beyond 25.5 V."""
    charge_state: int | None = None
    turning: int | None = None
    """Tenths of a degree a second."""
    faults: int | None = None
    sideways: int | None = None
    temperature: int | None = None
    charge_percent: int | None = None
    timer: int | None = None
    """Microseconds."""
    flags_3: int | None = None

    @classmethod
    def from_packet(cls, packet: Packet) -> "ServerInformation":
        """The contents of a packet of one of `SIP_KINDS`; PacketError if it is too short."""
        data = packet.payload
        if len(data) < HEAD.size:
            raise PacketError(f"a SIP of {len(data)} bytes is too short: {HEAD.size} at least")
        x, y, heading, left, right, battery, bumps, control, flags, compass, count = (
            HEAD.unpack_from(data)
        )
        end = HEAD.size + count * SONAR.size
        if len(data) < end:
            raise PacketError(f"a SIP of {len(data)} bytes is too short for {count} sonar readings")
        sonar = tuple(
            SonarReading(*SONAR.unpack_from(data, at)) for at in range(HEAD.size, end, SONAR.size)
        )
        tail: dict[str, int] = {}
        for name, form in TAIL:
            size = struct.calcsize("<" + form)
            if len(data) < end + size:
                break
            (tail[name],) = struct.unpack_from("<" + form, data, end)
            end += size
        low, high = bumps & 0xFF, bumps >> 8
        return cls(
            x, y, heading, left, right, battery,
            stall_left=bool(low & 1),
            stall_right=bool(high & 1),
            rear_bumpers=low >> 1,
            front_bumpers=high >> 1,
            control=control,
            flags=flags,
            compass=compass,
            sonar=sonar,
            **tail,
        )  # fmt: skip

    def to_packet(self, kind: int = STOPPED) -> Packet:
        """As the robot sends it, with the fields down to the first that is None."""
        low = self.rear_bumpers << 1 | self.stall_left
        high = self.front_bumpers << 1 | self.stall_right
        data = HEAD.pack(
            self.x, self.y, self.heading, self.left, self.right, self.battery, low | high << 8,
            self.control, self.flags, self.compass, len(self.sonar),
        )  # fmt: skip
        data += b"".join(SONAR.pack(reading.index, reading.range) for reading in self.sonar)
        for name, form in TAIL:
            value = getattr(self, name)
            if value is None:
                break
            data += struct.pack("<" + form, value)
        return Packet(kind, data)
