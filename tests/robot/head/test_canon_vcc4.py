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
    hexadecimal,
    move,
)
from facetlog.robot.head.canon_vcc4 import CanonVcC4
from facetlog.robot.head.open_head import open_head
from facetlog.robot.simulator.heads.canon import CanonHead
from tests.robot.head.simulated import Silence, SimulatedLine

HALF_A_COUNT = math.radians(0.1125) / 2 * (1 + 1e-9)
models = pytest.mark.parametrize("model", [VC_C4, VC_C50I], ids=lambda model: model.name)


def rad(degrees: float) -> float:
    return math.radians(degrees)


def started(model: CanonModel = VC_C4, zoom: int = 0) -> tuple[CanonVcC4, SimulatedLine]:
    line = SimulatedLine(CanonHead(model))
    head = CanonVcC4(line, zoom=zoom, clock=line.clock)
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


@models
def test_a_start_that_is_repeated_does_no_harm(model: CanonModel) -> None:
    head, _ = started(model)
    head.look(rad(40), 0.0)
    head.start()
    assert head.where().pan == pytest.approx(0.0)
    assert head.look(rad(40), rad(80)).tilt == pytest.approx(rad(80), abs=HALF_A_COUNT)


@settings(max_examples=40)
@given(st.floats(-98, 98), st.floats(-30, 87.9))
def test_it_ends_where_it_was_sent_and_stands_still(pan_deg: float, tilt_deg: float) -> None:
    head, line = started()
    state = head.look(rad(pan_deg), rad(tilt_deg))
    assert abs(state.pan - rad(pan_deg)) <= HALF_A_COUNT
    assert abs(state.tilt - rad(tilt_deg)) <= HALF_A_COUNT
    true_pan, true_tilt, _ = line.device.angles(line.now)
    assert (true_pan, true_tilt) == pytest.approx((state.pan, state.tilt), abs=1e-12)


def test_a_look_waits_until_the_move_is_done_not_only_taken() -> None:
    head, line = started()
    head.look(rad(95), 0.0)
    before = line.now
    head.look(rad(-95), 0.0)
    assert 190 / 90 <= line.now - before <= 190 / 90 + 0.6


def test_a_robot_that_hands_bytes_on_ten_times_a_second_only_makes_it_slower() -> None:
    line = SimulatedLine(CanonHead())
    line.cycle = 0.1
    head = CanonVcC4(line, clock=line.clock)
    head.start()
    before = line.now
    assert head.look(rad(90), rad(25)).pan == pytest.approx(rad(90))
    assert line.now - before < 1.0 + 2.0


def test_answers_are_requested_in_two_pieces_at_most_six_bytes_first() -> None:
    head, line = started()
    head.look(rad(20), rad(5), zoom=300)
    head.where()
    head.stop()
    assert {tuple(asked) for asked in line.asked} == {(6,), (6, 8), (6, 4)}


def test_speeds_range_and_zoom_are_set_at_the_start() -> None:
    head, line = started(zoom=700)
    for frame in (
        "FF 30 30 00 50 33 32 30 EF",
        "FF 30 30 00 51 32 36 35 EF",
        "FF 30 30 00 64 31 37 45 46 35 38 33 30 45 EF",
        "FF 30 30 00 B3 30 32 42 43 EF",
    ):
        assert bytes.fromhex(frame) in line.sent
    assert head.where().zoom == 700
    assert head.look(0.0, 0.0, zoom=20).zoom == 20
    assert line.device.angles(line.now)[2] == 20


def test_a_head_that_still_moves_is_waited_for() -> None:
    head, line = started()
    line.device.receive(move(-875, 0), line.now)
    line.sleep(0.2)
    assert head.look(rad(-50), 0.0).pan == pytest.approx(rad(-50), abs=HALF_A_COUNT)


def test_a_stop_stops_it_where_it_is() -> None:
    head, line = started()
    line.device.receive(move(-875, 0), line.now)
    line.sleep(0.3)
    head.stop()
    state = head.where()
    assert 0.2 < state.pan < rad(98)
    line.sleep(10)
    assert head.where().pan == state.pan


def test_without_answers_it_is_moved_open_loop_with_a_warning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    line = SimulatedLine(CanonHead(answers=False))
    head = CanonVcC4(line, zoom=500, clock=line.clock)
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
        assert true_zoom == state.zoom == 500
        assert head.where().pan == state.pan
        assert not head.where().reported


def test_without_answers_a_move_under_way_is_stopped_first() -> None:
    line = SimulatedLine(CanonHead(answers=False))
    head = CanonVcC4(line, answers=False, clock=line.clock)
    head.start()
    line.device.receive(move(875, 0), line.now)
    line.sleep(0.1)
    state = head.look(rad(10), rad(5))
    assert line.device.angles(line.now)[0] == pytest.approx(state.pan)


def test_without_answers_a_stop_leaves_the_place_unknown() -> None:
    line = SimulatedLine(CanonHead(answers=False))
    head = CanonVcC4(line, answers=False, clock=line.clock)
    with pytest.raises(DeviceError, match="not known"):
        head.where()
    head.start()
    head.stop()
    with pytest.raises(DeviceError, match="not known"):
        head.where()
    assert head.look(rad(-98), rad(80)).pan == pytest.approx(rad(-98), abs=HALF_A_COUNT)
    assert line.device.angles(line.now)[0] == pytest.approx(rad(-98), abs=HALF_A_COUNT)


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


def test_a_head_that_falls_silent_ends_in_a_time_out() -> None:
    head, line = started()
    line.device = Silence()
    for act in (lambda: head.look(0.5, 0.1), head.where, head.stop):
        before = line.now
        with pytest.raises(DeviceTimeout, match="does not answer"):
            act()
        assert line.now - before < 10


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
    for act in (lambda: head.look(0.5, 0.1), head.where):
        with pytest.raises(DeviceError, match="start it again"):
            act()
    head.start()
    assert head.look(0.5, 0.1).pan == pytest.approx(0.5, abs=HALF_A_COUNT)


def test_a_head_that_is_slowed_down_is_waited_for_until_the_timeout() -> None:
    head, line = started()
    line.device.receive(encode_command(CanonCommand.PAN_SPEED, hexadecimal(8, 3)), line.now)
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
        lambda: head.look(0.0, 0.0, zoom=1961),
    ):
        with pytest.raises(InputError):
            act()
    assert len(line.sent) == before


@pytest.mark.parametrize("seed", range(12))
def test_lost_bytes_are_requested_again(seed: int) -> None:
    chance = random.Random(seed)
    losing = False

    def lose(said: bytes) -> bytes:
        return bytes(byte for byte in said if not losing or chance.random() >= 0.02)

    line = SimulatedLine(CanonHead(), lose)
    head = CanonVcC4(line, clock=line.clock)
    head.start()
    losing = True
    for pan, tilt in ((40, 10), (-60, -20), (5, 0)):
        state = head.look(rad(pan), rad(tilt), timeout=60)
        assert abs(state.pan - rad(pan)) <= HALF_A_COUNT
        true_pan, true_tilt, _ = line.device.angles(line.now)
        assert true_pan == pytest.approx(state.pan, abs=1e-9)
        assert true_tilt == pytest.approx(state.tilt, abs=1e-9)


def test_by_its_name_it_must_answer_unless_that_is_waived() -> None:
    line = SimulatedLine(CanonHead(answers=False))
    with pytest.raises(DeviceTimeout, match="does not answer"):
        open_head("canon-vc-c4", line).start()
