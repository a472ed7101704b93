"""Reports of the robot: what their bytes mean, read and written with one table of fields."""

import math
import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Any, get_args, get_origin, get_type_hints

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
    SERAUX = 0xB0
    """Bytes that came in at AUX1, as many as were requested."""
    SERAUX2 = 0xB8
    SERAUX3 = 0xC8
    RESET_1 = 0xFE
    """The controller was reset: the session is over."""
    RESET_2 = 0xFF
    """The same; during the handshake: a synchronisation packet was out of order."""


TEXT = "s"
Byte = Annotated[int, "B"]
SignedByte = Annotated[int, "b"]
Word = Annotated[int, "H"]
SignedWord = Annotated[int, "h"]
Long = Annotated[int, "I"]
Text = Annotated[str, TEXT]
"""Types of fields with their form on the line; `Text` ends with a zero byte."""

Layout = tuple[tuple[str, str], ...]
"""Names of the fields in their order on the line, each with its form."""


def list_fields(record: type) -> Layout:
    """Return the fields of a dataclass whose types have a form on the line."""
    return tuple(
        (name, part.__metadata__[0])
        for name, hint in get_type_hints(record, include_extras=True).items()
        for part in (hint, *get_args(hint))
        if get_origin(part) is Annotated
    )


def read_fields(layout: Layout, data: bytes) -> dict[str, Any]:
    """Decode fields down to the first that is missing or incomplete."""
    found: dict[str, Any] = {}
    at = 0
    for name, form in layout:
        if form == TEXT:
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
    return found


def write_fields(layout: Layout, record: object) -> bytes:
    """Encode the fields of a record down to the first that is None."""
    data = b""
    for name, form in layout:
        value = getattr(record, name)
        if value is None:
            break
        data += value.encode("latin-1") + b"\0" if form == TEXT else struct.pack("<" + form, value)
    return data


@dataclass(frozen=True, slots=True)
class Names:
    """The robot's name, class and subclass in its answer to SYNC2."""

    name: str
    robot_class: str
    subclass: str

    @classmethod
    def from_packet(cls, packet: Packet) -> "Names":
        """Return the three strings of the answer; those that are missing are empty."""
        parts = [part.decode("latin-1") for part in packet.payload.split(b"\0")]
        name, robot_class, subclass, *_ = [*parts, "", "", ""]
        return cls(name, robot_class, subclass)

    def to_packet(self) -> Packet:
        parts = (self.name, self.robot_class, self.subclass)
        return Packet(Report.SYNC2, b"".join(part.encode("latin-1") + b"\0" for part in parts))


TEXTS = 2
POSE = struct.Struct("<IHHHiiii")
"""Flags, three intervals in ms, x, y, z (mm) and heading (degrees)."""
BEHIND_POSE = struct.Struct("<iiiiiii")
"""Place on earth with its uncertainty, errors of the odometry as shares of `ERROR_UNIT`."""
NO_FIX = -1
HAS_ODOMETRY_ERROR = 1 << 2
ERROR_UNIT = 1e-7


@dataclass(frozen=True, slots=True)
class TruePose:
    """The pose in the simulator's world, in metres and radians (SIM_STAT in AMRISim's layout)."""

    pose: Pose2

    @classmethod
    def from_packet(cls, packet: Packet) -> "TruePose":
        """Decode a packet. Raise PacketError if it ends before the pose does."""
        data, at = packet.payload, 0
        for _ in range(TEXTS):
            at = data.find(b"\0", at) + 1
            if not at:
                raise PacketError("a SIM_STAT packet without its two texts")
        if len(data) < at + POSE.size:
            raise PacketError(f"a SIM_STAT packet of {len(data)} bytes ends before the pose")
        *_, x, y, _, heading = POSE.unpack_from(data, at)
        return cls(Pose2(x / 1e3, y / 1e3, math.radians(heading)))

    def to_packet(
        self, interval_ms: int = 0, errors: tuple[float, float, float] | None = None
    ) -> Packet:
        """Encode the pose in whole millimetres and degrees.

        `errors` are those of the left wheel, the right wheel and the track, as shares.
        """
        x, y = round(self.pose.x * 1e3), round(self.pose.y * 1e3)
        heading = round(math.degrees(self.pose.heading))
        flags = 0 if errors is None else HAS_ODOMETRY_ERROR
        counts = (round(share / ERROR_UNIT) for share in errors or (0.0, 0.0, 0.0))
        return Packet(
            Report.SIM_STAT,
            bytes(TEXTS)
            + POSE.pack(flags, *(interval_ms,) * 3, x, y, 0, heading)
            + BEHIND_POSE.pack(0, 0, 0, NO_FIX, *counts),
        )


AUTOBAUD = 2
"""Value of `autobaud` of a port that takes a change of its speed."""

SIMULATOR = "facetlog"
"""First word of the serial number of a robot that `facetlog simulate` is; its camera's address is
the second. Other simulators have "SIM"."""


@dataclass(frozen=True, slots=True)
class Configuration:
    """The robot's make, its limits and its settings."""

    robot_class: Text
    subclass: Text
    serial_number: Text | None = None
    four_motors: Byte | None = None
    turning_top: Word | None = None
    """The robot never turns faster, whatever is commanded."""
    speed_top: Word | None = None
    turning_acceleration_top: Word | None = None
    acceleration_top: Word | None = None
    pwm_max: Word | None = None
    name: Text | None = None
    cycle_ms: Byte | None = None
    """Between two reports."""
    host_baud: Byte | None = None
    aux1_baud: Byte | None = None
    gripper: Word | None = None
    front_sonar: Word | None = None
    rear_sonar: Byte | None = None
    low_battery: Word | None = None
    """Tenths of a volt."""
    rev_count: Word | None = None
    watchdog_ms: Word | None = None
    normal_packets: Byte | None = None
    stall_value: Word | None = None
    stall_count: Word | None = None
    joystick_speed: Word | None = None
    joystick_turning: Word | None = None
    turning_max: Word | None = None
    speed_max: Word | None = None
    turning_acceleration: Word | None = None
    turning_deceleration: Word | None = None
    rot_kp: Word | None = None
    rot_kv: Word | None = None
    rot_ki: Word | None = None
    acceleration: Word | None = None
    deceleration: Word | None = None
    trans_kp: Word | None = None
    trans_kv: Word | None = None
    trans_ki: Word | None = None
    front_bumpers: Byte | None = None
    """How many there are."""
    rear_bumpers: Byte | None = None
    charger: Byte | None = None
    sonar_cycle: Byte | None = None
    autobaud: Byte | None = None
    gyro: Byte | None = None
    drift_factor: SignedWord | None = None
    aux2_baud: Byte | None = None
    aux3_baud: Byte | None = None
    ticks_mm: Word | None = None
    shutdown_voltage: Word | None = None
    firmware: Text | None = None
    gyro_clockwise: Word | None = None
    gyro_counter_clockwise: Word | None = None
    kinematics_delay: Byte | None = None

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
        """Return the contents of a CONFIG packet; PacketError if not even class and subclass are
        in it.
        """
        data = packet.payload
        found = read_fields(LAYOUT, data)
        if "subclass" not in found:
            raise PacketError(f"a CONFIG packet without class and subclass: {data[:40].hex(' ')}")
        return cls(**found)

    def to_packet(self) -> Packet:
        """Return the robot's packet, with the fields down to the first that is None."""
        return Packet(Report.CONFIG, write_fields(LAYOUT, self))


LAYOUT = list_fields(Configuration)


STOPPED, MOVING = 0x32, 0x33
SIP_KINDS = frozenset(range(0x30, 0x35))
"""Manuals and simulators disagree on their meaning: motion is not read from them."""

HEAD = struct.Struct("<HHhhhBHhHBB")
SONAR = struct.Struct("<BH")


@dataclass(frozen=True, slots=True)
class SonarReading:
    """One sonar's reading: its number, and the range in the robot's unit."""

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
    gripper: Word | None = None
    analog: Byte | None = None
    digital_in: Byte | None = None
    digital_out: Byte | None = None
    battery_10: Word | None = None
    """Tenths of a volt, of batteries beyond 25.5 V."""
    charge_state: Byte | None = None
    turning: SignedWord | None = None
    """Tenths of a degree a second."""
    faults: Word | None = None
    sideways: SignedWord | None = None
    temperature: SignedByte | None = None
    charge_percent: Byte | None = None
    timer: Long | None = None
    """Microseconds."""
    flags_3: Long | None = None

    @classmethod
    def from_packet(cls, packet: Packet) -> "ServerInformation":
        """Return the contents of a packet of one of `SIP_KINDS`; PacketError if it is too short."""
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
            **read_fields(TAIL, data[end:]),
        )  # fmt: skip

    def to_packet(self, kind: int = STOPPED) -> Packet:
        """Return the robot's packet, with the fields down to the first that is None."""
        low = self.rear_bumpers << 1 | self.stall_left
        high = self.front_bumpers << 1 | self.stall_right
        data = HEAD.pack(
            self.x, self.y, self.heading, self.left, self.right, self.battery, low | high << 8,
            self.control, self.flags, self.compass, len(self.sonar),
        )  # fmt: skip
        data += b"".join(SONAR.pack(reading.index, reading.range) for reading in self.sonar)
        return Packet(kind, data + write_fields(TAIL, self))


TAIL = list_fields(ServerInformation)
"""Fields behind the sonar readings, in their order."""
