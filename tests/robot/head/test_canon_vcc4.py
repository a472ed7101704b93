"""The driver of Canon's heads on the simulated heads, in simulated time, and what goes wrong."""

import logging
import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.head.canon import (
    VC_C4,
    VC_C50I,
    CanonCommand,
    CanonModel,
    encode_command,
    encode_hexadecimal,
    move,
)
from facetlog.robot.head.canon_vcc4 import CanonVcC4
from facetlog.robot.simulator.heads.canon import CanonHead
from tests.robot.head.simulated import Silence, SimulatedLine

HALF_A_COUNT = math.radians(0.1125) / 2 * (1 + 1e-9)
models = pytest.mark.parametrize("model", [VC_C4, VC_C50I], ids=lambda model: model.name)


def rad(degrees: float) -> float:
    return math.radians(degrees)


def started(model: CanonModel = VC_C4) -> tuple[CanonVcC4, SimulatedLine]:
    line = SimulatedLine(CanonHead(model))
    head = CanonVcC4(line, clock=line.clock)
    head.start()
    return head, line


@models
def test_it_is_brought_from_off_to_ready(model: CanonModel) -> None:
    head, line = started(model)
    assert head.answers
    assert 4 <= line.now - 100 < 25
    state = head.look(rad(-90), rad(-30))
    assert move(800, -267) in line.sent
    assert state.reported
    assert state.pan == pytest.approx(rad(-90))


@settings(max_examples=40)
@given(st.floats(-98, 98), st.floats(-30, 87.9))
def test_it_ends_where_it_was_sent_and_stands_still(pan_deg: float, tilt_deg: float) -> None:
    head, line = started()
    state = head.look(rad(pan_deg), rad(tilt_deg))
    assert abs(state.pan - rad(pan_deg)) <= HALF_A_COUNT
    assert abs(state.tilt - rad(tilt_deg)) <= HALF_A_COUNT
    true_pan, true_tilt, _ = line.device.angles(line.now)
    assert (true_pan, true_tilt) == pytest.approx((state.pan, state.tilt), abs=1e-12)


def test_answers_are_requested_in_two_pieces_at_most_six_bytes_first() -> None:
    head, line = started()
    head.look(rad(20), rad(5))
    assert {tuple(asked) for asked in line.asked} == {(6,), (6, 8), (6, 4)}


def test_speeds_range_and_zoom_are_set_at_the_start() -> None:
    head, line = started()
    for frame in (
        "FF 30 30 00 50 33 32 30 EF",
        "FF 30 30 00 51 32 36 35 EF",
        "FF 30 30 00 64 31 37 45 46 35 38 33 30 45 EF",
        "FF 30 30 00 B3 30 30 30 30 EF",
    ):
        assert bytes.fromhex(frame) in line.sent
    assert head.look(0.0, 0.0).zoom == 0


def test_without_answers_it_is_moved_open_loop_with_a_warning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    line = SimulatedLine(CanonHead(answers=False))
    head = CanonVcC4(line, clock=line.clock)
    with caplog.at_level(logging.WARNING):
        head.start()
    assert "CTS" in caplog.text
    assert "its moves are not confirmed" in caplog.text
    assert not head.answers
    for pan, tilt in ((90, 40), (-90, -25), (3, 0), (3, 0)):
        state = head.look(rad(pan), rad(tilt))
        assert not state.reported
        true_pan, true_tilt, true_zoom = line.device.angles(line.now)
        # The head stands there in truth, though it could not say so.
        assert (true_pan, true_tilt) == pytest.approx((state.pan, state.tilt), abs=1e-12)
        assert true_zoom == state.zoom == 0


def test_without_answers_too_little_time_is_refused() -> None:
    line = SimulatedLine(CanonHead(answers=False))
    head = CanonVcC4(line, answers=False, clock=line.clock)
    head.start()
    before = len(line.sent)
    with pytest.raises(DeviceTimeout, match=r"needs 1\.5 s"):
        head.look(rad(90), 0.0, timeout=1.0)
    assert len(line.sent) == before


def test_a_head_that_must_answer_and_does_not_ends_in_a_time_out() -> None:
    line = SimulatedLine(Silence())
    with pytest.raises(DeviceTimeout, match=r"power.*cable.*AUX1.*9600.*CTS"):
        CanonVcC4(line, answers=True, clock=line.clock).start()
    assert line.now - 100 < 10


def test_noise_on_the_line_ends_in_an_error_that_says_so() -> None:
    noise = random.Random(3)
    line = SimulatedLine(CanonHead(), lambda said: bytes(noise.randrange(256) for _ in said))
    with pytest.raises(DeviceError, match="cannot be read"):
        CanonVcC4(line, clock=line.clock).start()


@models
def test_a_head_that_is_switched_off_meanwhile_is_reported(model: CanonModel) -> None:
    head, line = started(model)
    line.device.receive(encode_command(CanonCommand.POWER, b"0"), line.now)
    line.sleep(6.0)
    with pytest.raises(DeviceError, match="start it again"):
        head.look(0.5, 0.1)
    head.start()
    assert head.look(0.5, 0.1).pan == pytest.approx(0.5, abs=HALF_A_COUNT)


def test_a_head_that_is_slowed_down_is_waited_for_until_the_timeout() -> None:
    head, line = started()
    line.device.receive(encode_command(CanonCommand.PAN_SPEED, encode_hexadecimal(8, 3)), line.now)
    line.sleep(0.2)
    before = line.now
    with pytest.raises(DeviceTimeout, match="not still"):
        head.look(rad(90), 0.0, timeout=6.0)
    assert line.now - before < 8


def test_what_it_cannot_reach_is_refused_before_a_byte_is_sent() -> None:
    head, line = started()
    before = len(line.sent)
    for act in (
        lambda: head.look(rad(99), 0.0),
        lambda: head.look(math.nan, 0.0),
        lambda: head.look(0.0, rad(-31)),
    ):
        with pytest.raises(InputError):
            act()
    assert len(line.sent) == before
