"""Bytes of the maker's manual and of drivers in use, and properties of the codec."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.head.canon import (
    Answer,
    CanonCommand,
    CanonError,
    CanonSyntaxError,
    encode_angle,
    encode_command,
    encode_hexadecimal,
    move,
    number,
    parse_answer,
    parse_command,
    parse_position,
)

FRAMES = [
    (encode_command(CanonCommand.CONTROL, b"0"), "FF 30 30 00 90 30 EF"),
    (encode_command(CanonCommand.POWER, b"1"), "FF 30 30 00 A0 31 EF"),
    (encode_command(CanonCommand.INITIALIZE, b"0"), "FF 30 30 00 58 30 EF"),
    (encode_command(CanonCommand.DRIVE, b"0"), "FF 30 30 00 53 30 EF"),
    (encode_command(CanonCommand.POSITION_REQUEST), "FF 30 30 00 63 EF"),
    (encode_command(CanonCommand.ZOOM_REQUEST, b"0"), "FF 30 30 00 B4 30 EF"),
    (encode_command(CanonCommand.ZOOM_REQUEST, b"3"), "FF 30 30 00 B4 33 EF"),
    # Pan right 90°, tilt down 30° (manual, page 52).
    (move(800, -267), "FF 30 30 00 62 38 33 32 30 37 45 46 35 EF"),
    (
        encode_command(CanonCommand.ZOOM, encode_hexadecimal(256, 4)),
        "FF 30 30 00 B3 30 31 30 30 EF",
    ),
    # 350 counts a second (manual, page 27).
    (
        encode_command(CanonCommand.TILT_SPEED, encode_hexadecimal(350, 3)),
        "FF 30 30 00 51 31 35 45 EF",
    ),
    # The range of tilt that ARIA and p2os set.
    (
        encode_command(CanonCommand.RANGE, b"1" + encode_angle(-267) + encode_angle(782)),
        "FF 30 30 00 64 31 37 45 46 35 38 33 30 45 EF",
    ),
]


@pytest.mark.parametrize(("frame", "expected"), FRAMES)
def test_commands_are_the_bytes_of_the_manual(frame: bytes, expected: str) -> None:
    assert frame == bytes.fromhex(expected)


def test_answers_are_the_bytes_of_the_manual() -> None:
    position = bytes.fromhex("FE 30 30 30 30 38 33 32 30 37 45 46 35 EF")
    answer = parse_answer(position)
    assert answer.error is CanonError.NONE
    assert parse_position(answer.data) == (800, -267)
    assert answer.to_bytes() == position
    assert parse_answer(bytes.fromhex("FE 30 30 31 30 EF")) == Answer(CanonError.BUSY)
    zoom = parse_answer(bytes.fromhex("FE 30 30 30 30 30 31 30 30 EF"))
    assert number(zoom.data) == 256


@given(st.sampled_from(CanonCommand), st.text("0123456789ABCDEF", max_size=9).map(str.encode))
def test_reading_a_command_gives_what_was_written(command: CanonCommand, data: bytes) -> None:
    assert parse_command(encode_command(command, data)) == (command, data)


framed = st.binary(max_size=16).map(lambda data: b"\xfe00" + data + b"\xef")


@given(st.binary(max_size=24) | framed)
def test_no_bytes_crash_the_reader_of_answers(data: bytes) -> None:
    try:
        answer = parse_answer(data)
    except CanonSyntaxError:
        return
    try:
        parse_position(answer.data)
    except CanonSyntaxError:
        return
    assert len(answer.data) == 8
