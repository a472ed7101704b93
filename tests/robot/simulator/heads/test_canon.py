"""The simulated Canon heads against the maker's manual and drivers in use, in simulated time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.head.canon import (
    VC_C4,
    VC_C50I,
    CanonCommand,
    CanonError,
    CanonModel,
    encode_angle,
    encode_command,
    move,
    parse_answer,
    parse_position,
)
from facetlog.robot.simulator.heads.canon import MIDDLE_S, SWITCHING_S, CanonHead


def encode_tilt_range(lowest: int, highest: int) -> bytes:
    return encode_command(CanonCommand.RANGE, b"1" + encode_angle(lowest) + encode_angle(highest))


OK, BUSY, WRONG, MODE = (f"FE 30 30 {error} 30 EF" for error in ("30", "31", "35", "39"))
CONTROL, POWER_ON, POWER_OFF = "FF303000 90 30 EF", "FF303000 A0 31 EF", "FF303000 A0 30 EF"
INITIALIZE, STOP, WHERE = "FF303000 58 30 EF", "FF303000 53 30 EF", "FF303000 63 EF"
SOON = 0.1


class Talk:
    """A head, and the time of those who talk with it."""

    def __init__(self, head: CanonHead | None = None) -> None:
        self.head, self.now = head or CanonHead(), 10.0

    def ask(self, frame: str | bytes) -> str:
        data = bytes.fromhex(frame) if isinstance(frame, str) else frame
        self.head.receive(data, self.now)
        self.now += SOON
        return self.head.pending(self.now).hex(" ").upper()

    def place(self) -> tuple[int, int]:
        answer = parse_answer(bytes.fromhex(self.ask(WHERE)))
        assert answer.error is CanonError.NONE
        return parse_position(answer.data)


def ready(model: CanonModel = VC_C4) -> Talk:
    talk = Talk(CanonHead(model))
    talk.ask(CONTROL)
    assert talk.ask(POWER_ON) == OK
    talk.now += SWITCHING_S
    assert talk.ask(INITIALIZE) == OK
    talk.now += MIDDLE_S
    return talk


def test_a_move_is_answered_at_once_and_ends_where_it_was_sent() -> None:
    talk = ready()
    # Right 90°, down 30°: 800 counts at 800 a second.
    assert talk.ask("FF 30 30 00 62 38 33 32 30 37 45 46 35 EF") == OK
    begun = talk.place()
    assert 0 < begun[0] < 800
    talk.now += 1.0
    assert talk.ask(WHERE) == "FE 30 30 30 30 38 33 32 30 37 45 46 35 EF"
    pan, tilt, _ = talk.head.angles(talk.now)
    assert math.degrees(pan) == pytest.approx(-90)
    assert math.degrees(tilt) == pytest.approx(-30, abs=0.06)


def test_while_it_moves_it_takes_no_move_and_says_so() -> None:
    talk = ready()
    assert talk.ask(move(875, 0)) == OK
    assert talk.ask(move(0, 0)) == BUSY
    assert talk.ask(INITIALIZE) == BUSY
    assert talk.ask(STOP) == OK
    here = talk.place()
    assert 0 < here[0] < 875
    assert talk.ask(move(0, 0)) == OK


def test_a_c50i_is_switched_on_and_homes_only_when_commanded() -> None:
    talk = Talk(CanonHead(VC_C50I))
    assert talk.ask(POWER_ON) == MODE
    assert talk.ask(CONTROL) == OK
    assert talk.ask(POWER_ON) == OK
    assert talk.ask(POWER_ON) == BUSY
    talk.now += SWITCHING_S
    assert talk.ask(WHERE) == MODE
    assert talk.ask(move(0, 0)) == MODE
    assert talk.ask(INITIALIZE) == OK
    assert talk.ask(WHERE) == BUSY
    assert talk.ask(move(0, 0)) == BUSY
    talk.now += MIDDLE_S
    assert talk.place() == (0, 0)


@pytest.mark.parametrize("model", [VC_C4, VC_C50I])
def test_it_obeys_the_order_of_aria_which_homes_twice(model: CanonModel) -> None:
    talk = Talk(CanonHead(model))
    # What is busy is sent again, after a mode error of power comes control; the second homing is
    # given up after two seconds.
    if talk.ask(POWER_ON) == MODE:
        assert talk.ask(CONTROL) == OK
        assert talk.ask(POWER_ON) == OK
    for frame in (CONTROL, INITIALIZE):
        while (answer := talk.ask(frame)) == BUSY:
            pass
        assert answer == OK
    homing_since = talk.now
    for frame in ("FF303000 50 323635 EF", "FF303000 51 323635 EF", encode_tilt_range(-267, 782)):
        assert talk.ask(frame) == OK
    assert talk.ask(INITIALIZE) == OK
    assert talk.now < homing_since + 2.0
    # It does not home longer for that.
    talk.now = homing_since + MIDDLE_S
    assert talk.place() == (0, 0)
    assert talk.ask(move(-100, 300)) == OK


@pytest.mark.parametrize(
    "frame",
    [
        move(876, 0),
        move(0, -268),
        encode_command(CanonCommand.MOVE, b"8000"),
        encode_command(CanonCommand.PAN_SPEED, b"007"),
        encode_command(CanonCommand.ZOOM, b"07A9"),
        encode_command(CanonCommand.ZOOM_REQUEST, b"1"),
        encode_command(CanonCommand.RANGE, b"180007F00"),
        encode_command(CanonCommand.INITIALIZE, b"7"),
        bytes.fromhex("FF303000 44 EF"),
    ],
)
def test_what_it_cannot_do_is_a_parameter_error(frame: bytes) -> None:
    talk = ready()
    assert talk.ask(frame) == WRONG
    assert talk.place() == (0, 0)


def test_it_is_silent_to_what_is_not_for_it_and_hears_what_comes_after() -> None:
    talk = ready()
    assert talk.ask("FF 30 31 00 63 EF") == ""
    assert talk.ask("00 EF EF 12") == ""
    assert talk.ask("FF 30 30 00 B4 30") == ""
    assert talk.ask(WHERE) == "FE 30 30 30 30 38 30 30 30 38 30 30 30 EF"


digits = st.text("0123456789ABCDEF", max_size=9).map(str.encode)
frames = st.one_of(
    st.builds(move, st.integers(-1000, 1000), st.integers(-400, 900)),
    st.builds(encode_command, st.sampled_from(CanonCommand), digits),
    st.builds(encode_command, st.sampled_from(CanonCommand), st.sampled_from([b"0", b"1"])),
    st.builds(
        lambda low, high: encode_tilt_range(low, high),
        st.integers(-300, 900),
        st.integers(-300, 900),
    ),
    st.binary(max_size=24),
)


@given(
    st.sampled_from([VC_C4, VC_C50I]),
    st.booleans(),
    st.lists(st.tuples(frames, st.floats(0, 6)), max_size=30),
)
def test_no_commands_bring_it_beyond_its_limits(
    model: CanonModel, under_control: bool, talks: list[tuple[bytes, float]]
) -> None:
    talk = ready(model) if under_control else Talk(CanonHead(model))
    talk.head.pending(talk.now)
    for frame, pause in talks:
        talk.head.receive(frame, talk.now)
        talk.now += pause
        pan, tilt, zoom = talk.head.angles(talk.now)
        model.limits.check(pan, tilt)
        assert 0 <= zoom <= model.zoom_highest
        talk.now += 0.2
        said = talk.head.pending(talk.now)
        for whole in said.split(b"\xef")[:-1]:
            parse_answer(whole + b"\xef")
        assert said[-1:] in (b"", b"\xef")
