"""Packets: the manuals' vectors, and what a line may do to them."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
    make_text_command,
)
from facetlog.robot.pioneer.packets.packet import Decoder, Packet, Received

PACKETS = st.builds(Packet, st.integers(0, 255), st.binary(max_size=252))
ODDS = 2.0**-16  # of a checksum that fits by chance


def independent_checksum(body: bytes) -> int:
    """As the manual of 1999 describes it: pairs from the front, the last odd byte by xor."""
    total, at = 0, 0
    while len(body) - at > 1:
        total = (total + body[at] * 256 + body[at + 1]) % 65536
        at += 2
    return total ^ body[at] if at < len(body) else total


@pytest.mark.parametrize(
    ("packet", "wire"),
    [
        (make_integer_command(Command.VEL, 200), "FA FB 06 0B 3B C8 00 D3 3B"),
        (make_plain_command(Command.OPEN), "FA FB 03 01 00 01"),
        (make_integer_command(Command.OPEN, 1), "FA FB 06 01 3B 01 00 02 3B"),
        (make_integer_command(Command.DHEAD, -45), "FA FB 06 0D 1B 2D 00 3A 1B"),
        (make_plain_command(Command.ESTOP), "FA FB 03 37 00 37"),
        (
            make_text_command(Command.TTY2, bytes.fromhex("81 09 06 12 FF")),
            "FA FB 0A 2A 2B 05 81 09 06 12 FF 4B B1",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_packets_are_those_of_the_manuals_and_of_clients_in_use(packet: Packet, wire: str) -> None:
    assert packet.to_bytes() == bytes.fromhex(wire)
    assert [each.packet for each in Decoder().feed(bytes.fromhex(wire))] == [packet]


@given(st.lists(PACKETS, max_size=8), st.lists(st.integers(1, 40), min_size=1, max_size=30))
def test_packets_come_out_as_they_went_in_however_they_are_cut_up(
    packets: list[Packet], cuts: list[int]
) -> None:
    stream = b"".join(packet.to_bytes() for packet in packets)
    decoder, found, at, i = Decoder(), [], 0, 0
    while at < len(stream):
        found += decoder.feed(stream[at : at + cuts[i % len(cuts)]], float(i))
        at += cuts[i % len(cuts)]
        i += 1
    assert [each.packet for each in found] == packets
    assert (decoder.waiting, decoder.skipped, decoder.refused) == (0, 0, 0)


@given(st.binary(max_size=64), PACKETS)
def test_a_packet_behind_any_bytes_is_found_at_the_latest_when_the_line_falls_silent(
    noise: bytes, packet: Packet
) -> None:
    decoder = Decoder()
    found = decoder.feed(noise + packet.to_bytes()) + decoder.expire()
    assert packet in [each.packet for each in found]
    assert decoder.waiting == 0


def test_the_time_of_a_packet_is_that_of_its_first_byte() -> None:
    wire = make_plain_command(Command.STOP).to_bytes()
    decoder = Decoder()
    assert decoder.feed(b"\x00" + wire[:2], 1.0) == []
    assert decoder.feed(wire[2:], 2.0) == [Received(make_plain_command(Command.STOP), 1.0)]


def test_a_packet_inside_a_broken_one_is_not_lost() -> None:
    inner = make_integer_command(Command.VEL, 200)
    broken = b"\xfa\xfb" + bytes([len(inner.to_bytes()) + 2]) + inner.to_bytes() + b"\x00\x00"
    assert [each.packet for each in Decoder().feed(broken)] == [inner]


def test_of_many_bytes_with_damage_only_whole_packets_come_through() -> None:
    random_ = random.Random(8)
    original = [Packet(0x32, random_.randbytes(random_.randrange(20, 80))) for _ in range(4_000)]
    sent = {packet.to_bytes() for packet in original}
    stream = bytearray(b"".join(packet.to_bytes() for packet in original))
    for at in range(len(stream)):
        if random_.random() < 0.01:
            stream[at] = random_.randrange(256)
    damaged, decoder, found = bytes(stream), Decoder(), []
    for at in range(0, len(damaged), 61):
        found += decoder.feed(damaged[at : at + 61])
    found += decoder.expire()
    wires = [each.packet.to_bytes() for each in found]
    false = [wire for wire in wires if wire not in sent]
    # None is made up: each false one stands in the stream, and its checksum fits.
    assert all(wire in damaged for wire in false)
    assert all(independent_checksum(w[3:-2]) == int.from_bytes(w[-2:]) for w in false)
    # Two bytes of one column whose changes cancel each other are what a sum cannot see: half of
    # all pairs are of one column, and of those one in about 256 cancels (a third of packets here
    # have two or more damaged bytes, and fewer than all cancel).
    several = decoder.refused
    assert len(false) <= several * ODDS + several / 3 / 2 / 256 * 3
    # What was not touched comes through, but for packets swallowed by a damaged count of bytes.
    touched = 1 - 0.99 ** (len(damaged) / len(original))
    assert len(wires) - len(false) > 0.85 * (1 - touched) * len(original)
