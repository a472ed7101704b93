"""Reports besides the server information: round trips, order of fields, short ones."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.packet import Packet, PacketError
from facetlog.robot.pioneer.packets.reports import (
    LAYOUT,
    Configuration,
    Names,
    TruePose,
)
from facetlog.robot.pioneer.parameters import MODELS, find_parameters
from facetlog.robot.pose2 import Pose2

WORDS = st.text("abcdefgh-0123", max_size=10)


@given(WORDS, WORDS, WORDS)
def test_names_come_back(name: str, kind: str, subclass: str) -> None:
    names = Names(name, kind, subclass)
    assert Names.from_packet(names.to_packet()) == names


@pytest.mark.parametrize("reader", [Configuration, TruePose])
@given(payload=st.binary(max_size=252))
def test_any_payload_is_read_or_a_packet_error(reader: type, payload: bytes) -> None:
    try:
        value = reader.from_packet(Packet(0, payload))
    except PacketError:
        return
    assert isinstance(value, reader)


@st.composite
def configurations(draw: st.DrawFn) -> Configuration:
    known = draw(st.integers(2, len(LAYOUT)))
    bounds = {"B": (0, 255), "H": (0, 65535), "h": (-32768, 32767)}
    values = {
        name: draw(WORDS) if form == "s" else draw(st.integers(*bounds[form]))
        for name, form in LAYOUT[:known]
    }
    return Configuration(**values)


@given(configurations())
def test_configurations_come_back_however_many_fields_the_firmware_knows(
    configuration: Configuration,
) -> None:
    assert Configuration.from_packet(configuration.to_packet()) == configuration


def test_the_watchdog_stands_where_clients_in_use_look_for_it() -> None:
    """Three texts, a byte, five words, the name, three bytes, two words, a byte, two words."""
    payload = b"Pioneer\0p2de\0SIM\0" + bytes(11) + b"x\0" + bytes(3 + 4 + 1 + 4) + b"\xd0\x07"
    assert Configuration.from_packet(Packet(0x20, payload)).watchdog_ms == 2000


def test_a_true_pose_stands_where_the_simulator_puts_it() -> None:
    payload = bytes(2 + 10) + b"".join(
        value.to_bytes(4, "little", signed=True) for value in (1500, -250, 7, -90)
    )
    pose = TruePose.from_packet(Packet(0x62, payload)).pose
    assert pose == Pose2(1.5, -0.25, -math.pi / 2)
    assert TruePose.from_packet(TruePose(pose).to_packet()).pose == pose


def test_models_are_found_in_any_case_and_keep_their_figures() -> None:
    assert find_parameters(" P3DX ").distance == pytest.approx(0.485e-3)
    assert find_parameters("p2dx").angle == 2 * math.pi / 4096
    assert find_parameters("pion1m").angle == 2 * math.pi / 1024
    assert MODELS["p3dx"].position_bits == 12
    assert MODELS["pionat"].position_bits == 15
    with pytest.raises(KeyError):
        find_parameters("roomba")


def test_sonars_of_the_pioneer_2_look_where_its_manual_says() -> None:
    sonars = find_parameters("p2dx").sonars
    assert len(sonars) == 16
    first, last_front, first_rear = sonars[0], sonars[7], sonars[8]
    assert (first.x, first.y, math.degrees(first.heading)) == (0.115, 0.130, 90)
    assert (last_front.x, last_front.y, math.degrees(last_front.heading)) == (0.115, -0.130, -90)
    assert (first_rear.x, first_rear.y) == (-0.115, -0.130)
    for front, rear in zip(sonars[:8], reversed(sonars[8:]), strict=True):
        assert (rear.x, rear.y) == (-front.x, front.y)
        assert math.isclose(math.cos(rear.heading), -math.cos(front.heading), abs_tol=1e-12)
        assert math.isclose(math.sin(rear.heading), math.sin(front.heading), abs_tol=1e-12)
