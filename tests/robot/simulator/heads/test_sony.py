"""The simulated Sony head against the maker's manual, in simulated time."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.head.sony_models import EVI_D30, EVI_D70, EVI_D100, SonyModel
from facetlog.robot.head.visca import (
    AbsoluteMove,
    Drive,
    Fixed,
    Information,
    Inquiry,
    nibbles,
    parse_reply,
    position_of,
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
        return position_of(reply.data)

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


@pytest.mark.parametrize(("speed", "degrees_a_second"), [(1, 3.33), (0x0C, 40), (0x18, 80)])
def test_it_pans_at_the_commanded_speed(speed: int, degrees_a_second: float) -> None:
    talk = Talk()
    talk.say(to_bytes(AbsoluteMove(-0x370, 0, pan_speed=speed)).hex())
    talk.now += 1.0
    assert talk.angles_deg()[0] == pytest.approx(degrees_a_second, rel=0.002)


@pytest.mark.parametrize(("speed", "degrees_a_second"), [(1, 2.5), (0x14, 50)])
def test_it_tilts_at_the_commanded_speed(speed: int, degrees_a_second: float) -> None:
    talk = Talk()
    talk.say(to_bytes(AbsoluteMove(0, 0x12C, tilt_speed=speed)).hex())
    talk.now += 0.2
    assert talk.angles_deg()[1] == pytest.approx(0.2 * degrees_a_second)


def test_it_says_where_it_is_while_it_moves() -> None:
    talk = Talk()
    talk.say(to_bytes(AbsoluteMove(0x370, 0, pan_speed=1)).hex())
    assert talk.hear() == "90 41 FF"
    places = [talk.place()[0] for _ in range(5)]
    assert places == sorted(places)
    assert 0 < places[0] < places[-1] < 0x370


def test_no_byte_comes_faster_than_the_line_lets_it() -> None:
    talk = Talk()
    talk.say("81 09 06 12 FF")
    start = talk.now
    times = []
    while len(times) < 11:
        talk.now += 0.0001
        times += [talk.now - start] * len(talk.head.pending(talk.now))
    assert times[0] >= 1 / 60
    assert all(b - a >= 10 / 9600 - 0.00011 for a, b in pairwise(times))
    assert times[-1] >= 11 * 10 / 9600


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


def test_a_cancelled_move_stops_where_it_is_and_is_not_completed() -> None:
    talk = Talk()
    talk.say(to_bytes(AbsoluteMove(0x370, 0)).hex())
    assert talk.hear(0.5) == "90 41 FF"
    assert talk.ask("81 21 FF") == "90 61 04 FF"
    here = talk.place()
    assert 300 < here[0] < 600
    assert talk.hear(3.0) == ""
    assert talk.place() == here
    assert talk.ask("81 21 FF") == "90 61 05 FF"
    assert talk.ask("81 23 FF") == "90 63 05 FF"


def test_a_cancelled_move_lets_the_waiting_one_begin() -> None:
    talk = Talk()
    talk.say(to_bytes(AbsoluteMove(0x370, 0)).hex())
    talk.say(to_bytes(AbsoluteMove(-88, 12)).hex())
    assert talk.hear(0.2) == "90 41 FF 90 42 FF"
    assert talk.ask("81 21 FF") == "90 61 04 FF"
    assert talk.hear(2.0) == "90 52 FF"
    assert talk.place() == (-88, 12)


def test_a_drive_goes_on_until_it_is_stopped() -> None:
    talk = Talk()
    # Left and up; done as far as the command goes.
    assert talk.ask("81 01 06 01 0C 0A 01 01 FF") == "90 41 FF 90 51 FF"
    talk.now += 0.4
    pan, tilt = talk.angles_deg()
    assert pan == pytest.approx(20)
    assert tilt == pytest.approx(12.5)
    assert talk.ask("81 01 06 01 18 14 03 03 FF") == "90 41 FF 90 51 FF"
    stopped = talk.angles_deg()
    talk.now += 5
    assert talk.angles_deg() == stopped


def test_a_drive_ends_at_the_limit() -> None:
    talk = Talk()
    talk.ask("81 01 06 01 18 14 02 02 FF")
    talk.now += 60
    assert talk.angles_deg() == pytest.approx((-100, -25))


def test_a_drive_breaks_off_a_move() -> None:
    talk = Talk()
    talk.ask(to_bytes(AbsoluteMove(0x370, 0, pan_speed=1)).hex())
    assert talk.ask(to_bytes(Drive(0, 0)).hex()) == "90 42 FF 90 51 FF 90 52 FF"
    here = talk.place()
    talk.now += 5
    assert talk.place() == here


def test_relative_moves_add_up_and_end_at_the_limit() -> None:
    talk = Talk()
    for _ in range(3):
        talk.ask("81 01 06 03 18 14 00 00 05 08 00 00 00 00 FF")
        talk.now += 1
    assert talk.place() == (3 * 88, 0)
    talk.ask("81 01 06 03 18 14 00 07 00 00 00 00 00 00 FF")
    talk.now += 10
    assert talk.place() == (0x370, 0)


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


def test_a_frame_without_an_end_is_too_long() -> None:
    talk = Talk()
    assert talk.ask("81 01 06 02" + " 00" * 20 + " FF") == "90 60 01 FF"


def test_it_is_silent_to_what_is_not_for_it() -> None:
    talk = Talk()
    assert talk.ask("82 09 06 12 FF") == ""
    assert talk.ask("00 01 02 FF") == ""
    assert talk.ask("FF FF FF") == ""
    assert talk.ask("88 01 06 04 FF") == ""


def test_a_frame_that_lost_its_end_does_not_spoil_the_next() -> None:
    talk = Talk()
    assert talk.ask("81 01 06 81 09 04 00 FF") == "90 50 02 FF"
    assert talk.ask("12 34 81 09 04 00 FF") == "90 50 02 FF"


def test_frames_may_come_in_any_pieces() -> None:
    talk = Talk()
    for byte in bytes.fromhex("81 09 04 00"):
        talk.head.receive(bytes([byte]), talk.now)
        assert talk.hear(0.05) == ""
    assert talk.ask("FF") == "90 50 02 FF"
    assert talk.ask("81 09 04 00 FF 81 09 06 11 FF") == "90 50 02 FF 90 50 18 14 FF"


def test_clear_and_address_set_are_answered_as_the_broadcasts_they_are() -> None:
    talk = Talk()
    # As ARIA sends them: both at once.
    assert talk.ask("88 01 00 01 FF 88 30 01 FF") == "88 01 00 01 FF 88 30 02 FF"
    assert talk.ask("81 01 00 01 FF") == "90 50 FF"


def test_a_camera_with_another_number_answers_with_it() -> None:
    talk = Talk()
    assert talk.ask("88 30 03 FF") == "88 30 04 FF"
    assert talk.ask("81 09 04 00 FF") == ""
    assert talk.ask("83 09 04 00 FF") == "B0 50 02 FF"


def test_clear_stops_it_and_frees_the_sockets_without_a_word() -> None:
    talk = Talk()
    talk.ask(to_bytes(AbsoluteMove(0x370, 0, pan_speed=1)).hex())
    assert talk.ask(to_bytes(Fixed.CLEAR).hex()) == "90 50 FF"
    here = talk.place()
    assert talk.hear(60.0) == ""
    assert talk.place() == here
    assert talk.ask("81 01 06 05 FF") == "90 41 FF"


@pytest.mark.parametrize(("model", "word"), [(EVI_D30, "04 02"), (EVI_D100, "04 0D")])
def test_it_says_which_model_it_is(model: SonyModel, word: str) -> None:
    assert Talk(SonyHead(model)).ask("81 09 00 02 FF") == f"90 50 00 20 {word} 01 00 02 FF"


def test_a_model_of_unknown_speeds_is_not_simulated() -> None:
    with pytest.raises(ValueError, match="EVI-D70"):
        SonyHead(EVI_D70)


def test_in_standby_it_answers_and_does_not_move() -> None:
    talk = Talk(SonyHead(powered=False))
    assert talk.ask("81 09 04 00 FF") == "90 50 03 FF"
    assert talk.ask("81 01 06 04 FF") == "90 61 41 FF"
    assert talk.ask("81 09 06 12 FF") == "90 60 41 FF"


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


def test_a_head_that_gets_power_says_so() -> None:
    assert SonyHead().pending(1.0) == bytes.fromhex("90 38 FF")
    assert SonyHead(powered=False).pending(1.0) == b""


frames = st.one_of(
    st.builds(
        lambda kind, pan_speed, tilt_speed, pan, tilt: (
            bytes([0x81, 1, 6, kind, pan_speed])
            + bytes([tilt_speed])
            + nibbles(pan)
            + nibbles(tilt)
            + b"\xff"
        ),
        st.sampled_from([2, 3]),
        st.integers(0, 0x19),
        st.integers(0, 0x15),
        st.integers(-1200, 1200),
        st.integers(-400, 400),
    ),
    st.builds(Drive, *(st.sampled_from([-1, 0, 1]),) * 2).map(to_bytes),
    st.sampled_from([*Fixed, *Inquiry]).map(to_bytes),
    st.integers(0, 2).map(lambda socket: bytes([0x81, 0x20 | socket, 0xFF])),
    st.integers(-10, 1100).map(lambda zoom: b"\x81\x01\x04\x47" + nibbles(zoom) + b"\xff"),
    st.sampled_from([b"\x81\x01\x04\x00\x02\xff", b"\x81\x01\x04\x00\x03\xff"]),
    st.sampled_from([2, 3, 0, 0x27, 0x30]).map(lambda way: bytes([0x81, 1, 4, 7, way, 0xFF])),
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
        number = 1 if whole[0] == 0x88 else (whole[0] - 0x80) // 0x10
        parse_reply(whole + b"\xff", number)
