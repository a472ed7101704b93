"""Commands to the robot by name, and their arguments to bytes and back.

Numbers and meanings: Pioneer 2 manual (P2OS), Pioneer 3 manual (ARCOS). On the wire lengths are in
millimetres and angles in degrees.
"""

import struct
from enum import IntEnum

from facetlog.robot.pioneer.packets.packet import Packet, PacketError

POSITIVE, NEGATIVE, TEXT = 0x3B, 0x1B, 0x2B
LARGEST_INTEGER = 65535
LARGEST_TEXT = 195
"""Bytes of a text: P2OS ignores commands whose count exceeds 200 (manual of 1999, page 26)."""


class Command(IntEnum):
    """Kinds of packets that a client sends."""

    PULSE = 0
    """Feeds the watchdog, and nothing else."""
    OPEN = 1
    CLOSE = 2
    ENABLE = 4
    """Motors: 1 on, 0 off."""
    SETA = 5
    """Acceleration (positive) or deceleration (negative), mm/s²."""
    SETV = 6
    """Largest speed, mm/s."""
    SETRV = 10
    """Largest turning speed, degrees/s."""
    VEL = 11
    """mm/s."""
    DHEAD = 13
    """Degrees from the present heading."""
    CONFIG = 18
    RVEL = 21
    """Degrees a second, counter-clockwise positive."""
    SETRA = 23
    """Turning acceleration (positive) or deceleration (negative), degrees/s²."""
    SONAR = 28
    STOP = 29
    TTY2 = 42
    """Bytes out at AUX1."""
    GETAUX = 43
    """0: discard what came in at AUX1; n: report n bytes once they are there."""
    BUMPSTALL = 44
    HOSTBAUD = 50
    AUX1BAUD = 51
    AUX2BAUD = 52
    ESTOP = 55
    """Stops as hard as it can."""
    E_STALL = 56
    TTY4 = 60
    GETAUX3 = 61
    TTY3 = 66
    GETAUX2 = 67
    SIM_STAT = 237
    """Where a simulated robot truly is: once (1), with every report (2), no longer (0)."""


def make_plain_command(command: Command) -> Packet:
    """Return a command without an argument.

    >>> make_plain_command(Command.STOP).to_bytes().hex(" ")
    'fa fb 03 1d 00 1d'
    """
    return Packet(command)


def make_integer_command(command: Command, value: int) -> Packet:
    """Return a command with an integer: its magnitude, and its sign in the type of the argument.

    ValueError if the magnitude does not fit into 16 bits.

    >>> make_integer_command(Command.DHEAD, -45).to_bytes().hex(" ")
    'fa fb 06 0d 1b 2d 00 3a 1b'
    """
    if abs(value) > LARGEST_INTEGER:
        raise ValueError(f"{value} does not go into the 16 bits of a command's argument")
    return Packet(command, struct.pack("<BH", POSITIVE if value >= 0 else NEGATIVE, abs(value)))


def make_text_command(command: Command, text: bytes) -> Packet:
    """Return a command with bytes, their number before them; ValueError if there are too many.

    >>> make_text_command(Command.TTY2, bytes.fromhex("81 09 06 12 FF")).to_bytes().hex(" ")
    'fa fb 0a 2a 2b 05 81 09 06 12 ff 4b b1'
    """
    if len(text) > LARGEST_TEXT:
        raise ValueError(f"{len(text)} bytes are more than a command holds ({LARGEST_TEXT})")
    return Packet(command, bytes([TEXT, len(text)]) + text)


def read_argument(packet: Packet) -> int | bytes | None:
    """Return the argument of a received command; None without one. PacketError if it is malformed.

    An older text without a number of bytes, ended by a zero, is read as well.

    >>> read_argument(make_integer_command(Command.VEL, -200))
    -200
    """
    payload = packet.payload
    if not payload:
        return None
    kind, rest = payload[0], payload[1:]
    if kind in (POSITIVE, NEGATIVE) and len(rest) >= 2:
        value = int.from_bytes(rest[:2], "little")
        return value if kind == POSITIVE else -value
    if kind == TEXT and rest:
        if rest[0] == len(rest) - 1:
            return rest[1:]
        if rest[-1] == 0:
            return rest[:-1]
    raise PacketError(f"the argument of command {packet.kind} is malformed: {payload.hex(' ')}")


def name_command(packet: Packet) -> str:
    """Return a command to the robot as people write it.

    >>> name_command(Packet(11, bytes.fromhex("1B C8 00")))
    'VEL -200'
    """
    try:
        name = Command(packet.kind).name
    except ValueError:
        name = f"command {packet.kind}"
    try:
        argument = read_argument(packet)
    except PacketError:
        argument = packet.payload
    if argument is None:
        return name
    return f"{name} {argument.hex(' ') if isinstance(argument, bytes) else argument}"
