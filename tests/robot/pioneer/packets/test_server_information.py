"""The server information packet: a vector byte by byte, round trips, and short ones."""

from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.packet import Packet, PacketError
from facetlog.robot.pioneer.packets.reports import (
    TAIL,
    ServerInformation,
    SonarReading,
)

BOUNDS = {
    "B": (0, 255),
    "b": (-128, 127),
    "H": (0, 65535),
    "h": (-32768, 32767),
    "I": (0, 2**32 - 1),
}


@st.composite
def reports(draw: st.DrawFn) -> ServerInformation:
    def number(form: str) -> int:
        return draw(st.integers(*BOUNDS[form]))

    tail = {name: number(form) for name, form in TAIL[: draw(st.integers(0, len(TAIL)))]}
    sonar = tuple(SonarReading(number("B"), number("H")) for _ in range(draw(st.integers(0, 16))))
    return ServerInformation(
        x=number("H"),
        y=number("H"),
        heading=number("h"),
        left=number("h"),
        right=number("h"),
        battery=number("B"),
        stall_left=draw(st.booleans()),
        stall_right=draw(st.booleans()),
        rear_bumpers=draw(st.integers(0, 127)),
        front_bumpers=draw(st.integers(0, 127)),
        control=number("h"),
        flags=number("H"),
        compass=number("B"),
        sonar=sonar,
        **tail,
    )


@given(reports())
def test_reports_come_back_with_every_field(report: ServerInformation) -> None:
    assert ServerInformation.from_packet(report.to_packet()) == report


def test_fields_stand_where_the_manuals_have_them() -> None:
    payload = bytes.fromhex(
        "2C 01"  # 1: XPOS 300
        "FF 7F"  # 3: YPOS 32767
        "00 FC"  # 5: THPOS -1024, a quarter turn right
        "C8 00"  # 7: left 200
        "38 FF"  # 9: right -200
        "7D"  # 11: 12.5 V
        "05 02"  # 12: left stall and rear bumper 2; front bumper 1
        "00 00 21 00"  # control; flags: motors on, STOP button
        "00 01 07 E8 03"  # compass; one sonar: 7, 1000
        "00 00 80 0F F0"  # gripper, analog, inputs, outputs
        "82 00 01 9C FF"  # 13.0 V, bulk charge, -10.0 degrees/s
    )
    report = ServerInformation.from_packet(Packet(0x33, payload))
    assert (report.x, report.y, report.heading) == (300, 32767, -1024)
    assert (report.left, report.right, report.battery) == (200, -200, 125)
    assert (report.stall_left, report.stall_right) == (True, False)
    assert (report.rear_bumpers, report.front_bumpers) == (0b10, 0b1)
    assert report.flags == 0x21
    assert report.sonar == (SonarReading(7, 1000),)
    assert (report.analog, report.digital_in, report.digital_out) == (0x80, 0x0F, 0xF0)
    assert (report.battery_10, report.charge_state, report.turning) == (130, 1, -100)
    assert report.faults is None


def test_the_report_of_the_p3dx_simulator_has_its_84_bytes() -> None:
    """16 sonars, and all fields down to the state of charge (measured against a simulator)."""
    zeros = dict.fromkeys([name for name, _ in TAIL[: -len(("timer", "flags_3"))]], 0)
    sonar = tuple(SonarReading(i, 5000) for i in range(16))
    report = ServerInformation(0, 0, 0, 0, 0, 125, False, False, 0, 0, 0, 1, 0, sonar, **zeros)
    assert len(report.to_packet().payload) + 1 == 84


@given(st.binary(max_size=252))
def test_any_payload_is_a_report_or_a_packet_error(payload: bytes) -> None:
    try:
        report = ServerInformation.from_packet(Packet(0x32, payload))
    except PacketError:
        return
    assert report.to_packet().payload == payload[: len(report.to_packet().payload)]
