"""The serial language of Canon's VC-C4 and VC-C50i: commands and answers to bytes and back.

A command is ``FF 30 30 00 command parameters EF``, its answer ``FE 30 30 error 30 data EF``.
Numbers are hexadecimal in ASCII. Angles are in counts of 0.1125° with 8000h added, pan to the
*right* and tilt up positive.

Sources: Canon VC-C50i programmer's manual, pages 11-12, 20-78 (page numbers as printed); ArVCC4 of
ARIA and canonvcc4 of Player for what the VC-C4 is sent.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from facetlog.robot.head.head import HeadLimits

COMMAND_HEADER: Final = bytes.fromhex("FF 30 30 00")
ANSWER_HEADER: Final = bytes.fromhex("FE 30 30")
END: Final = 0xEF
COUNTS_PER_DEGREE: Final = 1 / 0.1125
MIDDLE: Final = 0x8000

ACK_BYTES: Final = 6
"""The shortest answer: done, or an error."""
POSITION_BYTES: Final = 14
ZOOM_BYTES: Final = 10


class CanonSyntaxError(ValueError):
    """Bytes that are no command and no answer of this language."""


class CanonCommand(IntEnum):
    """Commands by number; where noted, a parameter of one digit selects the variant."""

    PAN_SPEED = 0x50
    """Three digits, counts a second."""
    TILT_SPEED = 0x51
    DRIVE = 0x53
    """0 stop, 1 right, 2 left, 3 up, 4 down."""
    HOME = 0x57
    INITIALIZE = 0x58
    """0: homes (finds its middle) and stays there."""
    MOVE = 0x62
    """Pan and tilt, four digits each."""
    POSITION_REQUEST = 0x63
    RANGE = 0x64
    """0 pan or 1 tilt, then the least and the largest angle."""
    CONTROL = 0x90
    """0 by this line, 1 by the remote control."""
    POWER = 0xA0
    """1 on, 0 off."""
    FOCUS = 0xA1
    GAIN = 0xA5
    FOCUS_PLACE = 0xB0
    ZOOM = 0xB3
    """Four digits, 0 the widest."""
    ZOOM_REQUEST = 0xB4
    """0 where it is, 3 the largest."""
    INFRARED_FILTER = 0xB5
    DIGITAL_ZOOM = 0xB7
    INFRARED_LIGHT = 0x76
    LAMP = 0x8E


class CanonError(IntEnum):
    """The result of a command, in its answer."""

    NONE = 0x30
    BUSY = 0x31
    """Something moves, or it is being switched on: try again."""
    PARAMETER = 0x35
    MODE = 0x39
    """It is off, under its remote control, or has not found its middle."""


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a command: whether it was accepted, and the data requested."""

    error: CanonError
    data: bytes = b""

    def to_bytes(self) -> bytes:
        """Return the bytes that go over the line.

        >>> Answer(CanonError.BUSY).to_bytes().hex(" ")
        'fe 30 30 31 30 ef'
        """
        return ANSWER_HEADER + bytes([self.error, 0x30]) + self.data + bytes([END])


def encode_hexadecimal(value: int, digits: int) -> bytes:
    """Return a number in ASCII; ValueError if it needs more digits.

    >>> encode_hexadecimal(613, 3)
    b'265'
    """
    if not 0 <= value < 16**digits:
        raise ValueError(f"{value} does not go into {digits} hexadecimal digits")
    return f"{value:0{digits}X}".encode()


def number(text: bytes) -> int:
    """Return the number that hexadecimal digits say; CanonSyntaxError if they are none."""
    try:
        digits = text.decode("ascii")
    except UnicodeDecodeError:
        digits = ""
    if not digits or any(digit not in "0123456789ABCDEFabcdef" for digit in digits):
        raise CanonSyntaxError(f"{text!r} is no hexadecimal number")
    return int(digits, 16)


def encode_angle(counts: int) -> bytes:
    """Count from the middle as they are sent.

    >>> encode_angle(800)
    b'8320'
    """
    return encode_hexadecimal(MIDDLE + counts, 4)


def parse_position(data: bytes) -> tuple[int, int]:
    """Parse pan and tilt in counts, of eight digits; CanonSyntaxError if they are not that."""
    if len(data) != 8:
        raise CanonSyntaxError(f"a position has 8 digits, not {len(data)}")
    return number(data[:4]) - MIDDLE, number(data[4:]) - MIDDLE


def encode_command(command: CanonCommand, parameters: bytes = b"") -> bytes:
    """Return the frame of a command.

    >>> encode_command(CanonCommand.POSITION_REQUEST).hex(" ")
    'ff 30 30 00 63 ef'
    """
    return COMMAND_HEADER + bytes([command]) + parameters + bytes([END])


def move(pan: int, tilt: int) -> bytes:
    """Return the frame that turns it to a place in counts.

    >>> move(800, -267)
    b'\\xff00\\x00b83207EF5\\xef'
    """
    return encode_command(CanonCommand.MOVE, encode_angle(pan) + encode_angle(tilt))


def parse_command(frame: bytes) -> tuple[int, bytes]:
    """Return the number of a command and its parameters; CanonSyntaxError if it is no command."""
    if (
        len(frame) < len(COMMAND_HEADER) + 2
        or not frame.startswith(COMMAND_HEADER)
        or frame[-1] != END
    ):
        raise CanonSyntaxError(f"{frame.hex(' ')} is no command")
    return frame[len(COMMAND_HEADER)], frame[len(COMMAND_HEADER) + 1 : -1]


def parse_answer(frame: bytes) -> Answer:
    """Decode an answer; CanonSyntaxError if it is none.

    >>> parse_answer(bytes.fromhex("FE 30 30 39 30 EF"))
    Answer(error=<CanonError.MODE: 57>, data=b'')
    """
    if (
        len(frame) < ACK_BYTES
        or not frame.startswith(ANSWER_HEADER)
        or frame[-1] != END
        or frame[3] not in tuple(CanonError)
    ):
        raise CanonSyntaxError(f"{frame.hex(' ')} is no answer of a camera head")
    return Answer(CanonError(frame[3]), frame[5:-1])


@dataclass(frozen=True, slots=True)
class CanonModel:
    """A head: limits in counts, the fastest speeds in counts a second."""

    name: str
    pan_limit: int
    tilt_lowest: int
    tilt_highest: int
    fastest_pan: int
    fastest_tilt: int
    tilt_highest_at_first: int
    """After switching on, until the range is set."""
    obeys_under_remote_control: bool
    """Whether it can be switched on before it was put under control of the serial line."""
    finds_its_middle: bool
    """Whether it homes by itself when it is switched on."""
    zoom_highest: int = 1960
    slowest: int = 8

    @property
    def limits(self) -> HeadLimits:
        """How far it turns, in our signs and units."""
        pan, _ = counts_to_angles(-self.pan_limit, 0)
        step = math.radians(1 / COUNTS_PER_DEGREE)
        return HeadLimits(
            pan_min=-pan,
            pan_max=pan,
            tilt_min=counts_to_angles(0, self.tilt_lowest)[1],
            tilt_max=counts_to_angles(0, self.tilt_highest)[1],
            pan_step=step,
            tilt_step=step,
            zoom_max=self.zoom_highest,
        )


def angles_to_counts(pan: float, tilt: float) -> tuple[int, int]:
    """Return the nearest counts of angles in radians, pan left positive; within half a count."""
    return (
        round(-math.degrees(pan) * COUNTS_PER_DEGREE),
        round(math.degrees(tilt) * COUNTS_PER_DEGREE),
    )


def counts_to_angles(pan: float, tilt: float) -> tuple[float, float]:
    """Convert counts to radians, pan left positive."""
    return -math.radians(pan / COUNTS_PER_DEGREE), math.radians(tilt / COUNTS_PER_DEGREE)


VC_C50I: Final = CanonModel(
    # VC-C50i programmer's manual, pages 20, 24-27, 56-61: a mode error to all but the control mode
    # command until that mode is set, and to moves until it has homed.
    name="VC-C50i",
    pan_limit=889,
    tilt_lowest=-267,
    tilt_highest=800,
    fastest_pan=800,
    fastest_tilt=622,
    tilt_highest_at_first=800,
    obeys_under_remote_control=False,
    finds_its_middle=False,
)

VC_C4: Final = CanonModel(
    # Limits and the first range of tilt as in ARIA (ArVCC4.h, ArVCC4.cpp). Player's driver for it
    # never commands it to home, and that of ROS (p2os) gives up if it does not obey its very first
    # command, power: so a VC-C4 does both.
    name="VC-C4",
    pan_limit=875,
    tilt_lowest=-267,
    tilt_highest=790,
    fastest_pan=800,
    fastest_tilt=662,
    tilt_highest_at_first=267,
    obeys_under_remote_control=True,
    finds_its_middle=True,
)

REACH: Final = CanonModel(
    # Tilt up to 88° is what all known drivers set a VC-C4 to (ARIA, Player, p2os); the fastest tilt
    # that they ask for is 69°/s.
    name="VC-C4 or VC-C50i",
    pan_limit=875,
    tilt_lowest=-267,
    tilt_highest=782,
    fastest_pan=800,
    fastest_tilt=613,
    tilt_highest_at_first=267,
    obeys_under_remote_control=False,
    finds_its_middle=False,
)
