"""Reports of the robot besides SIP and CONFIG: names, encoders, inputs, bytes of the AUX ports."""

import struct
from dataclasses import dataclass
from enum import IntEnum

from facetlog.robot.pioneer.packets.packet import Packet, PacketError

__all__ = ["Encoders", "InputsOutputs", "Names", "Report"]


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
