"""VISCA, the serial language of Sony's camera heads, to bytes and back.

A frame is ``8x … FF`` for the camera with address x (``88``: all of them), answered by ``90 … FF``
from camera 1 (``A0`` camera 2, …). A command is acknowledged with the socket that it runs in, and
completed or failed later with the same socket; an inquiry is answered at once. Numbers of 16 bits
go as four bytes, a half byte in each, in two's complement. Counts are the device's own: pan to the
*right* and tilt up are positive.

Sources: Sony EVI-D70 technical manual, pages 34-42; EVI-D100 manual, pages 23-28.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final

END: Final = 0xFF
BROADCAST: Final = 8
"""The address that means every camera on the line."""
FASTEST_PAN: Final = 0x18
FASTEST_TILT: Final = 0x14
LONGEST_FRAME: Final = 16
"""Bytes of a frame with header and end (EVI-D70 manual, page 32)."""


class ViscaSyntaxError(ValueError):
    """A frame that is not valid VISCA, or has a parameter out of range."""


@dataclass(frozen=True, slots=True)
class AbsoluteMove:
    """To a place, in counts from straight ahead; speeds are steps, 1 … 18h and 1 … 14h."""

    pan: int
    tilt: int
    pan_speed: int = FASTEST_PAN
    tilt_speed: int = FASTEST_TILT


@dataclass(frozen=True, slots=True)
class Drive:
    """Continuous motion until stopped: pan 1 right, -1 left, tilt 1 up, -1 down, 0 stop."""

    pan: int
    tilt: int
    pan_speed: int = FASTEST_PAN
    tilt_speed: int = FASTEST_TILT


@dataclass(frozen=True, slots=True)
class ZoomTo:
    """To a zoom in counts, 0 the widest."""

    counts: int


@dataclass(frozen=True, slots=True)
class Power:
    """On, or off (stand-by: it still answers)."""

    on: bool


@dataclass(frozen=True, slots=True)
class AddressSet:
    """Number the cameras of a chain: the first takes 1, and hands on the next number."""


class Fixed(Enum):
    """Commands that take no argument."""

    HOME = bytes.fromhex("01 06 04")
    CLEAR = bytes.fromhex("01 00 01")
    """Clears the commands in progress."""


class Inquiry(Enum):
    """Inquiries; each is answered by `Information`."""

    VERSION = bytes.fromhex("09 00 02")
    POWER = bytes.fromhex("09 04 00")
    ZOOM = bytes.fromhex("09 04 47")
    POSITION = bytes.fromhex("09 06 12")


Command = AbsoluteMove | Drive | ZoomTo | Power | AddressSet | Fixed | Inquiry

ABSOLUTE, DRIVE = bytes.fromhex("01 06 02"), bytes.fromhex("01 06 01")
ZOOM_TO, POWER = bytes.fromhex("01 04 47"), bytes.fromhex("01 04 00")
ADDRESS_ONE = bytes.fromhex("30 01")
ON, OFF = 2, 3
STOPPED = 3
PAN_WAYS: Final = {-1: 1, 1: 2, 0: STOPPED}  # left, right
TILT_WAYS: Final = {1: 1, -1: 2, 0: STOPPED}  # up, down


def encode_nibbles(value: int) -> bytes:
    """Return four bytes with a half byte each, of a number of 16 bits with or without a sign.

    >>> encode_nibbles(-120).hex(" ")
    '0f 0f 08 08'
    """
    if not -0x8000 <= value <= 0xFFFF:
        raise ValueError(f"{value} does not go into 16 bits")
    return bytes(value >> shift & 0xF for shift in (12, 8, 4, 0))


def number(data: bytes) -> int:
    """Return the signed number of 16 bits in four half bytes; ViscaSyntaxError if they are not
    that.
    """
    if len(data) != 4 or any(byte > 0xF for byte in data):
        raise ViscaSyntaxError(f"{data.hex(' ')} is no number in four half bytes")
    value = sum(byte << shift for byte, shift in zip(data, (12, 8, 4, 0), strict=True))
    return value - 0x10000 if value >= 0x8000 else value


def to_bytes(command: Command, *, broadcast: bool = False) -> bytes:
    """Return the frame of a command for camera 1, or for all cameras.

    >>> to_bytes(AbsoluteMove(pan=264, tilt=-120)).hex(" ")
    '81 01 06 02 18 14 00 01 00 08 0f 0f 08 08 ff'
    """
    address = BROADCAST if broadcast or isinstance(command, AddressSet) else 1
    return bytes([0x80 | address]) + _body(command) + bytes([END])


def _body(command: Command) -> bytes:
    match command:
        case AbsoluteMove(pan, tilt, pan_speed, tilt_speed):
            return (
                ABSOLUTE
                + bytes([pan_speed, tilt_speed])
                + encode_nibbles(pan)
                + encode_nibbles(tilt)
            )
        case Drive(pan, tilt, pan_speed, tilt_speed):
            return DRIVE + bytes([pan_speed, tilt_speed, PAN_WAYS[pan], TILT_WAYS[tilt]])
        case ZoomTo(counts):
            return ZOOM_TO + encode_nibbles(counts)
        case Power(on):
            return POWER + bytes([ON if on else OFF])
        case AddressSet():
            return ADDRESS_ONE
        case Fixed() | Inquiry():
            return bytes(command.value)


def parse_command(frame: bytes) -> tuple[int, Command]:
    """Return the address and command of a frame; ViscaSyntaxError if it is no known command.

    >>> parse_command(bytes.fromhex("81 09 06 12 FF"))
    (1, <Inquiry.POSITION: b'\\t\\x06\\x12'>)
    """
    if len(frame) < 3 or not 0x81 <= frame[0] <= 0x88 or frame[-1] != END:
        raise ViscaSyntaxError(f"{frame.hex(' ')} is no frame for a camera")
    address, command = frame[0] & 0xF, _command(frame[1:-1])
    if isinstance(command, AddressSet) and address != BROADCAST:
        raise ViscaSyntaxError("cameras are numbered all together")
    return address, command


def _command(body: bytes) -> Command:
    for kind in (Fixed, Inquiry):
        for member in kind:
            if member.value == body:
                return member
    if body == ADDRESS_ONE:
        return AddressSet()
    reader = READERS.get(body[:3])
    if reader is None:
        raise ViscaSyntaxError(f"no command begins with {body[:3].hex(' ')}")
    return reader(body[3:])


def _move(data: bytes) -> AbsoluteMove:
    if len(data) != 10:
        raise ViscaSyntaxError(f"a move has 10 bytes, not {len(data)}")
    return AbsoluteMove(number(data[2:6]), number(data[6:]), *_parse_speeds(data))


def _drive(data: bytes) -> Drive:
    if len(data) != 4 or data[2] not in PAN_WAYS.values() or data[3] not in TILT_WAYS.values():
        raise ViscaSyntaxError(f"{data.hex(' ')} is no way to drive")
    pan = next(way for way, byte in PAN_WAYS.items() if byte == data[2])
    tilt = next(way for way, byte in TILT_WAYS.items() if byte == data[3])
    return Drive(pan, tilt, *_parse_speeds(data))


def _parse_speeds(data: bytes) -> tuple[int, int]:
    if not (1 <= data[0] <= FASTEST_PAN and 1 <= data[1] <= FASTEST_TILT):
        raise ViscaSyntaxError(f"speeds {data[0]:02X}h, {data[1]:02X}h are out of range")
    return data[0], data[1]


def _power(data: bytes) -> Power:
    if len(data) != 1 or data[0] not in (ON, OFF):
        raise ViscaSyntaxError(f"{data.hex(' ')} is neither on nor off")
    return Power(data[0] == ON)


READERS: Final[dict[bytes, Callable[[bytes], Command]]] = {
    ABSOLUTE: _move,
    DRIVE: _drive,
    ZOOM_TO: lambda data: ZoomTo(number(data)),
    POWER: _power,
}


ACK_BYTES: Final = 3
"""Length of an acknowledgement and of a completion."""
ERROR_BYTES: Final = 4
"""The shortest answer to an inquiry is an error."""
POWER_BYTES: Final = 4
ZOOM_BYTES: Final = 7
VERSION_BYTES: Final = 10
POSITION_BYTES: Final = 11

CAMERA_1 = 0x90
"""The first byte of what camera 1 sends."""
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
        """Parse the answer's data; raise ViscaSyntaxError if it has not seven bytes."""
        if len(data) != 7:
            raise ViscaSyntaxError(f"a version has 7 bytes, not {len(data)}")
        vendor, model, firmware = (int.from_bytes(data[i : i + 2]) for i in (0, 2, 4))
        return cls(vendor, model, firmware, sockets=data[6])

    def to_bytes(self) -> bytes:
        """Return the bytes of the answer."""
        words = (self.vendor, self.model, self.firmware)
        return b"".join(word.to_bytes(2) for word in words) + bytes([self.sockets])


def parse_position(data: bytes) -> tuple[int, int]:
    """Parse pan and tilt in counts, of a position inquiry's data; ViscaSyntaxError if none."""
    if len(data) != 8:
        raise ViscaSyntaxError(f"a position has 8 bytes, not {len(data)}")
    return number(data[:4]), number(data[4:])


def encode_reply(reply: Reply) -> bytes:
    """Return the frame of an answer from camera 1.

    >>> encode_reply(Information(bytes.fromhex("00 01 00 08 0F 0F 08 08"))).hex(" ")
    '90 50 00 01 00 08 0f 0f 08 08 ff'
    """
    sender = CAMERA_1
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


def parse_reply(frame: bytes) -> Reply:
    """Return the reply in a frame; ViscaSyntaxError if it is no answer from camera 1.

    >>> parse_reply(bytes.fromhex("90 61 04 FF"))
    Failed(error=<ViscaError.CANCELLED: 4>, socket=1)
    """
    if len(frame) >= 3 and frame[-1] == END and END not in frame[:-1]:
        head, body = frame[0], frame[1:-1]
        if head == CAMERA_1:
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
