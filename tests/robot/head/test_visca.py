"""Bytes of the maker's manuals and of drivers in use, and properties of the codec."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.head.visca import (
    AbsoluteMove,
    Ack,
    AddressesSet,
    AddressSet,
    Cleared,
    Command,
    Completed,
    Drive,
    Failed,
    Fixed,
    Information,
    Inquiry,
    NetworkChange,
    Power,
    Reply,
    Version,
    ViscaError,
    ViscaSyntaxError,
    ZoomTo,
    encode_nibbles,
    encode_reply,
    parse_command,
    parse_reply,
    to_bytes,
)

COMMANDS: list[tuple[Command, str]] = [
    # +30° and -10° of an EVI-D30, at full speed.
    (AbsoluteMove(0x108, -0x78), "81 01 06 02 18 14 00 01 00 08 0F 0F 08 08 FF"),
    (Fixed.HOME, "81 01 06 04 FF"),
    (Fixed.CLEAR, "81 01 00 01 FF"),
    (Drive(-1, 1, 3, 4), "81 01 06 01 03 04 01 01 FF"),
    (Drive(1, -1, 3, 4), "81 01 06 01 03 04 02 02 FF"),
    (Drive(0, 0), "81 01 06 01 18 14 03 03 FF"),
    (ZoomTo(0x3FF), "81 01 04 47 00 03 0F 0F FF"),
    (Power(True), "81 01 04 00 02 FF"),
    (Power(False), "81 01 04 00 03 FF"),
    (Inquiry.POSITION, "81 09 06 12 FF"),
    (Inquiry.ZOOM, "81 09 04 47 FF"),
    (Inquiry.POWER, "81 09 04 00 FF"),
    (Inquiry.VERSION, "81 09 00 02 FF"),
]
REPLIES: list[tuple[Reply, str]] = [
    (Ack(1), "90 41 FF"),
    (Completed(2), "90 52 FF"),
    (Failed(ViscaError.SYNTAX), "90 60 02 FF"),
    (Failed(ViscaError.BUFFER_FULL), "90 60 03 FF"),
    (Failed(ViscaError.CANCELLED, 1), "90 61 04 FF"),
    (Failed(ViscaError.NOT_EXECUTABLE, 1), "90 61 41 FF"),
    (Information(b"\x02"), "90 50 02 FF"),
    (Information(b""), "90 50 FF"),
    (Information(encode_nibbles(-880) + encode_nibbles(300)), "90 50 0F 0C 09 00 00 01 02 0C FF"),
    (Cleared(), "88 01 00 01 FF"),
    (AddressesSet(2), "88 30 02 FF"),
    (NetworkChange(), "90 38 FF"),
]

words = st.integers(-0x8000, 0x7FFF)
pan_speeds, tilt_speeds = st.integers(1, 0x18), st.integers(1, 0x14)
ways = st.sampled_from([-1, 0, 1])
commands = st.one_of(
    st.builds(AbsoluteMove, words, words, pan_speeds, tilt_speeds),
    st.builds(Drive, ways, ways, pan_speeds, tilt_speeds),
    st.builds(ZoomTo, words),
    st.builds(Power, st.booleans()),
    st.sampled_from(Fixed),
    st.sampled_from(Inquiry),
)
sockets = st.integers(1, 15)
replies = st.one_of(
    st.builds(Ack, sockets),
    st.builds(Completed, sockets),
    st.builds(Failed, st.sampled_from(ViscaError), st.integers(0, 15)),
    st.builds(Information, st.binary(max_size=13).filter(lambda data: 0xFF not in data)),
    st.builds(AddressesSet, st.integers(0, 254)),
    st.sampled_from([Cleared(), NetworkChange()]),
)


@pytest.mark.parametrize(("command", "frame"), COMMANDS)
def test_commands_are_the_bytes_of_the_manual(command: Command, frame: str) -> None:
    assert to_bytes(command) == bytes.fromhex(frame)
    assert parse_command(bytes.fromhex(frame)) == (1, command)


@pytest.mark.parametrize(("reply", "frame"), REPLIES)
def test_replies_are_the_bytes_of_the_manual(reply: Reply, frame: str) -> None:
    assert encode_reply(reply) == bytes.fromhex(frame)
    assert parse_reply(bytes.fromhex(frame)) == reply


def test_what_is_for_all_cameras_goes_to_address_8() -> None:
    assert to_bytes(AddressSet()) == bytes.fromhex("88 30 01 FF")
    assert to_bytes(Fixed.CLEAR, broadcast=True) == bytes.fromhex("88 01 00 01 FF")
    assert parse_command(bytes.fromhex("88 30 01 FF")) == (8, AddressSet())


def test_the_version_gives_the_model() -> None:
    reply = parse_reply(bytes.fromhex("90 50 00 20 04 02 01 00 02 FF"))
    assert isinstance(reply, Information)
    version = Version.of(reply.data)
    assert version == Version(vendor=0x20, model=0x402, firmware=0x100, sockets=2)
    assert version.to_bytes() == reply.data


@given(commands)
def test_reading_a_command_gives_what_was_written(command: Command) -> None:
    frame = to_bytes(command)
    assert parse_command(frame) == (1, command)
    assert len(frame) <= 16
    # Its end and its header are nowhere else: a stream of frames can be cut at them.
    assert all(byte < 0x80 for byte in frame[1:-1])


@given(replies)
def test_reading_a_reply_gives_what_was_written(reply: Reply) -> None:
    assert parse_reply(encode_reply(reply)) == reply


@given(st.binary(max_size=20) | st.binary(max_size=16).map(lambda data: b"\x81" + data + b"\xff"))
def test_no_bytes_crash_the_reader_of_commands(data: bytes) -> None:
    try:
        address, command = parse_command(data)
    except ViscaSyntaxError:
        return
    assert to_bytes(command, broadcast=address == 8)[1:] == data[1:]


@given(st.binary(max_size=20) | st.binary(max_size=14).map(lambda data: b"\x90" + data + b"\xff"))
def test_no_bytes_crash_the_reader_of_replies(data: bytes) -> None:
    try:
        reply = parse_reply(data)
    except ViscaSyntaxError:
        return
    assert encode_reply(reply) == data
