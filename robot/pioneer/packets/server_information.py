"""The server information packet (SIP) as it is on the wire; the robot sends ten a second.

All values are the robot's own integers; `state.py` gives them units. Later firmware adds fields at
the end: those that a packet does not have are None.
"""

import struct
from dataclasses import dataclass

from facetlog.robot.pioneer.packets.packet import Packet, PacketError

__all__ = ["MOVING", "SIP_KINDS", "STOPPED", "ServerInformation", "SonarReading"]

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
