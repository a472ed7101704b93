"""The simulated Sony head against the maker's manual, in simulated time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.head.sony_models import EVI_D30
from facetlog.robot.head.visca import (
    AbsoluteMove,
    Drive,
    Fixed,
    Information,
    Inquiry,
    encode_nibbles,
    parse_position,
    parse_reply,
    to_bytes,
)
from facetlog.robot.simulator.heads.sony import STARTING_S, SonyHead

SOON = 0.1
"""Seconds after which an answer of up to 16 bytes is in."""


class Talk:
    """A head, and the time of those who talk with it."""

    def __init__(self, head: SonyHead | None = None) -> None:
        self.head, self.now = head or SonyHead(), 10.0
        self.head.pending(self.now)

    def say(self, frame: str) -> None:
        self.head.receive(bytes.fromhex(frame), self.now)

    def hear(self, after: float = SOON) -> str:
        self.now += after
        return self.head.pending(self.now).hex(" ").upper()

    def ask(self, frame: str) -> str:
        self.say(frame)
        return self.hear()

    def place(self) -> tuple[int, int]:
        self.hear()
        reply = parse_reply(bytes.fromhex(self.ask("81 09 06 12 FF")))
        assert isinstance(reply, Information)
        return parse_position(reply.data)

    def angles_deg(self) -> tuple[float, float]:
        pan, tilt, _ = self.head.angles(self.now)
        return math.degrees(pan), math.degrees(tilt)


def test_a_move_is_acknowledged_and_completed_when_it_stands_there() -> None:
    talk = Talk()
    # +30° (right) and -10°: 30° at 80°/s take 0.375 s.
    talk.say("81 01 06 02 18 14 00 01 00 08 0F 0F 08 08 FF")
    assert talk.hear(0.3) == "90 41 FF"
    assert talk.angles_deg()[0] == pytest.approx(-0.3 * 80)
    assert talk.hear(0.2) == "90 51 FF"
    assert talk.angles_deg() == pytest.approx((-30, -10))
    assert talk.place() == (0x108, -0x78)


def test_two_commands_run_in_two_sockets_and_a_third_is_refused() -> None:
    talk = Talk()
    assert talk.ask("81 01 06 02 18 14 00 03 07 00 00 00 00 00 FF") == "90 41 FF"
    assert talk.ask("81 01 04 47 00 03 0F 0F FF") == "90 42 FF"
    assert talk.ask("81 01 06 04 FF") == "90 60 03 FF"
    # Pan 100° in 1.25 s, the zoom in 4 s: each completes for itself.
    assert talk.hear(1.2) == "90 51 FF"
    assert talk.hear(5.0) == "90 52 FF"
    assert talk.ask("81 09 04 47 FF") == "90 50 00 03 0F 0F FF"


def test_a_second_move_waits_for_the_first() -> None:
    talk = Talk()
    talk.say(to_bytes(AbsoluteMove(0x370, 0)).hex())
    talk.say(to_bytes(AbsoluteMove(0, 0)).hex())
    assert talk.hear(0.6) == "90 41 FF 90 42 FF"
    assert talk.hear(0.8) == "90 51 FF"
    assert talk.hear(1.3) == "90 52 FF"
    assert talk.place() == (0, 0)


@pytest.mark.parametrize(
    "frame",
    [
        "81 01 06 02 19 14 00 00 00 00 00 00 00 00 FF",  # too fast
        "81 01 06 02 18 00 00 00 00 00 00 00 00 00 FF",  # without a speed
        "81 01 06 02 18 14 00 03 07 01 00 00 00 00 FF",  # beyond 100°
        "81 01 06 02 18 14 00 00 00 00 0F 0E 0D 03 FF",  # below -25°
        "81 01 06 02 18 14 00 01 10 08 00 00 00 00 FF",  # more than half a byte
        "81 01 06 02 18 14 FF",
        "81 01 04 47 00 04 00 00 FF",  # beyond the zoom
        "81 09 05 38 FF",
        "81 01 38 FF",
        "81 FF",
    ],
)
def test_what_is_no_command_of_its_own_is_a_syntax_error(frame: str) -> None:
    talk = Talk()
    assert talk.ask(frame) == "90 60 02 FF"
    assert talk.place() == (0, 0)


def test_clear_and_address_set_are_answered_as_the_broadcasts_they_are() -> None:
    talk = Talk()
    # As ARIA sends them: both at once.
    assert talk.ask("88 01 00 01 FF 88 30 01 FF") == "88 01 00 01 FF 88 30 02 FF"
    assert talk.ask("81 01 00 01 FF") == "90 50 FF"


def test_switching_on_takes_its_time_and_ends_straight_ahead() -> None:
    talk = Talk()
    talk.ask(to_bytes(AbsoluteMove(0x370, 0x12C)).hex())
    talk.hear(3.0)
    assert talk.ask("81 01 04 00 03 FF") == "90 41 FF 90 51 FF"
    assert talk.angles_deg() == pytest.approx((-100, 25))
    assert talk.ask("81 01 04 00 02 FF") == "90 41 FF"
    assert talk.ask("81 09 04 00 FF") == "90 50 02 FF"
    assert talk.ask("81 09 06 12 FF") == "90 60 41 FF"
    assert talk.ask("81 01 06 04 FF") == "90 62 41 FF"
    assert talk.hear(STARTING_S) == "90 51 FF"
    assert talk.place() == (0, 0)
    assert talk.ask("81 01 04 00 02 FF") == "90 41 FF 90 51 FF"


frames = st.one_of(
    st.builds(
        lambda kind, pan_speed, tilt_speed, pan, tilt: (
            bytes([0x81, 1, 6, kind, pan_speed])
            + bytes([tilt_speed])
            + encode_nibbles(pan)
            + encode_nibbles(tilt)
            + b"\xff"
        ),
        st.just(2),
        st.integers(0, 0x19),
        st.integers(0, 0x15),
        st.integers(-1200, 1200),
        st.integers(-400, 400),
    ),
    st.builds(Drive, *(st.sampled_from([-1, 0, 1]),) * 2).map(to_bytes),
    st.sampled_from([*Fixed, *Inquiry]).map(to_bytes),
    st.integers(-10, 1100).map(lambda zoom: b"\x81\x01\x04\x47" + encode_nibbles(zoom) + b"\xff"),
    st.sampled_from([b"\x81\x01\x04\x00\x02\xff", b"\x81\x01\x04\x00\x03\xff"]),
    st.binary(max_size=20),
)


@given(st.lists(st.tuples(frames, st.floats(0, 3)), max_size=30))
def test_no_commands_bring_it_beyond_its_limits(talks: list[tuple[bytes, float]]) -> None:
    head, now, limits = SonyHead(), 0.0, EVI_D30.limits
    said = b""
    for frame, pause in talks:
        head.receive(frame, now)
        now += pause
        pan, tilt, zoom = head.angles(now)
        limits.check(pan, tilt)
        assert 0 <= zoom <= limits.zoom_max
        said += head.pending(now)
    # Once it has nothing left to say, what it said is made of whole frames of its own.
    said += head.pending(now + 3600)
    assert said[-1:] == b"\xff"
    for whole in said.split(b"\xff")[:-1]:
        parse_reply(whole + b"\xff")
