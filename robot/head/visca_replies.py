"""Replies of a Sony camera head, to bytes and back, and the lengths of its answers.

An answer comes from ``90`` (camera 1; ``A0`` camera 2, …). A command is acknowledged with the
socket that it runs in, and completed or failed later with the same socket; an inquiry is answered
at once. Sources: Sony EVI-D70 technical manual, pages 34 and 38; EVI-D100 manual, page 24.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from facetlog.robot.head.visca import BROADCAST, END, ViscaSyntaxError, number

__all__ = [
    "ACK_BYTES",
    "ERROR_BYTES",
    "POSITION_BYTES",
    "POWER_BYTES",
    "VERSION_BYTES",
    "ZOOM_BYTES",
    "Ack",
    "AddressesSet",
    "Cleared",
    "Completed",
    "Failed",
    "Information",
    "NetworkChange",
    "Reply",
    "Version",
    "ViscaError",
    "parse_reply",
    "position_of",
    "reply_to_bytes",
]

ACK_BYTES: Final = 3
"""Of an acknowledgement, and of a completion."""
ERROR_BYTES: Final = 4
"""The shortest answer to an inquiry is an error."""
POWER_BYTES: Final = 4
ZOOM_BYTES: Final = 7
VERSION_BYTES: Final = 10
POSITION_BYTES: Final = 11

INQUIRY_ANSWER = 0x50
NETWORK_CHANGE = 0x38
CLEAR_ECHO = bytes.fromhex("01 00 01")
ADDRESS_SET = 0x30


class ViscaError(IntEnum):
    """Why a command was refused or not carried out."""

    TOO_LONG = 0x01
    SYNTAX = 0x02
    BUFFER_FULL = 0x03
    """Both sockets are taken."""
    CANCELLED = 0x04
    NO_SOCKET = 0x05
    """There was nothing to cancel."""
    NOT_EXECUTABLE = 0x41
    """Not now: it is off, or starting."""


@dataclass(frozen=True, slots=True)
class Ack:
    """The command was accepted and runs in this socket."""

    socket: int


@dataclass(frozen=True, slots=True)
class Completed:
    """The command of this socket was carried out; the head stands still."""

    socket: int


@dataclass(frozen=True, slots=True)
class Failed:
    """A command or inquiry was refused or cancelled; the socket is 0 if it never had one."""

    error: ViscaError
    socket: int = 0


@dataclass(frozen=True, slots=True)
class Information:
    """The answer to an inquiry."""

    data: bytes


@dataclass(frozen=True, slots=True)
class Cleared:
    """Every camera cleared its commands (answer to a broadcast clear)."""


@dataclass(frozen=True, slots=True)
class AddressesSet:
    """The cameras were numbered; `following` is the number that a further one would get."""

    following: int


@dataclass(frozen=True, slots=True)
class NetworkChange:
    """A camera was switched on or joined the line."""


Reply = Ack | Completed | Failed | Information | Cleared | AddressesSet | NetworkChange


@dataclass(frozen=True, slots=True)
class Version:
    """Vendor, model and firmware of the head."""

    vendor: int
    model: int
    firmware: int
    sockets: int

    @classmethod
    def of(cls, data: bytes) -> "Version":
        """From the answer's data; ViscaSyntaxError if it has not seven bytes."""
        if len(data) != 7:
            raise ViscaSyntaxError(f"a version has 7 bytes, not {len(data)}")
        vendor, model, firmware = (int.from_bytes(data[i : i + 2]) for i in (0, 2, 4))
        return cls(vendor, model, firmware, sockets=data[6])

    def to_bytes(self) -> bytes:
        """As in the answer."""
        words = (self.vendor, self.model, self.firmware)
        return b"".join(word.to_bytes(2) for word in words) + bytes([self.sockets])


def position_of(data: bytes) -> tuple[int, int]:
    """Pan and tilt in counts, of a position inquiry's data; ViscaSyntaxError if it is none."""
    if len(data) != 8:
        raise ViscaSyntaxError(f"a position has 8 bytes, not {len(data)}")
    return number(data[:4]), number(data[4:])


def reply_to_bytes(reply: Reply, address: int = 1) -> bytes:
    """The frame of an answer from the camera with this address.

    >>> reply_to_bytes(Information(bytes.fromhex("00 01 00 08 0F 0F 08 08"))).hex(" ")
    '90 50 00 01 00 08 0f 0f 08 08 ff'
    """
    sender = 0x80 + 0x10 * address
    match reply:
        case Ack(socket):
            body = bytes([sender, 0x40 | socket])
        case Completed(socket):
            body = bytes([sender, 0x50 | socket])
        case Failed(error, socket):
            body = bytes([sender, 0x60 | socket, error])
        case Information(data):
            body = bytes([sender, INQUIRY_ANSWER]) + data
        case Cleared():
            body = bytes([0x80 | BROADCAST]) + CLEAR_ECHO
        case AddressesSet(following):
            body = bytes([0x80 | BROADCAST, ADDRESS_SET, following])
        case NetworkChange():
            body = bytes([sender, NETWORK_CHANGE])
    return body + bytes([END])


def parse_reply(frame: bytes, address: int = 1) -> Reply:
    """The reply in a frame; ViscaSyntaxError if it is no answer from that camera.

    >>> parse_reply(bytes.fromhex("90 61 04 FF"))
    Failed(error=<ViscaError.CANCELLED: 4>, socket=1)
    """
    if len(frame) >= 3 and frame[-1] == END and END not in frame[:-1]:
        head, body = frame[0], frame[1:-1]
        if head == 0x80 + 0x10 * address:
            return _answer(body)
        if head == 0x80 | BROADCAST:
            if body == CLEAR_ECHO:
                return Cleared()
            if len(body) == 2 and body[0] == ADDRESS_SET:
                return AddressesSet(body[1])
    raise ViscaSyntaxError(f"{frame.hex(' ')} is no answer of a camera head")


def _answer(body: bytes) -> Reply:
    kind, socket = body[0] >> 4, body[0] & 0xF
    if body == bytes([NETWORK_CHANGE]):
        return NetworkChange()
    if kind == 4 and len(body) == 1:
        return Ack(socket)
    # Without a socket and data it is the answer to a clear, which has neither.
    if kind == 5 and len(body) == 1 and socket:
        return Completed(socket)
    if kind == 5 and not socket:
        return Information(body[1:])
    if kind == 6 and len(body) == 2 and body[1] in tuple(ViscaError):
        return Failed(ViscaError(body[1]), socket)
    raise ViscaSyntaxError(f"{body.hex(' ')} is no answer of a camera head")
