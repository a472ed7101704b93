"""Arguments of commands: every value comes back, and what is too large is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import (
    LARGEST_TEXT,
    Command,
    make_integer_command,
    make_plain_command,
    make_text_command,
    name_command,
    read_argument,
)
from facetlog.robot.pioneer.packets.packet import Packet, PacketError


@given(st.sampled_from(Command), st.integers(-65535, 65535))
def test_integers_come_back(command: Command, value: int) -> None:
    assert read_argument(make_integer_command(command, value)) == value


@given(st.binary(max_size=LARGEST_TEXT))
def test_texts_come_back_zeros_and_all(text: bytes) -> None:
    assert read_argument(make_text_command(Command.TTY2, text)) == text


def test_a_text_or_a_number_beyond_its_room_is_refused() -> None:
    with pytest.raises(ValueError, match="more than a command holds"):
        make_text_command(Command.TTY2, bytes(LARGEST_TEXT + 1))
    with pytest.raises(ValueError, match="16 bits"):
        make_integer_command(Command.VEL, 65536)


@given(st.binary(max_size=252))
def test_any_payload_is_an_argument_or_a_packet_error(payload: bytes) -> None:
    try:
        value = read_argument(Packet(1, payload))
    except PacketError:
        return
    assert value is None or isinstance(value, int | bytes)


@pytest.mark.parametrize(
    ("packet", "name"),
    [
        (make_plain_command(Command.STOP), "STOP"),
        (make_integer_command(Command.RVEL, -10), "RVEL -10"),
        (make_text_command(Command.TTY2, b"\x81\xff"), "TTY2 81 ff"),
        (Packet(200, b"\x3b\x01\x00"), "command 200 1"),
        (Packet(11, b"\x00"), "VEL 00"),
    ],
)
def test_commands_have_names_for_people(packet: Packet, name: str) -> None:
    assert name_command(packet) == name
