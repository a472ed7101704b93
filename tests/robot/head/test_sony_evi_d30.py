"""The driver of Sony's heads on the simulated head, in simulated time, with all that goes wrong."""

import math
import random
from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.head.sony_evi_d30 import SonyEviD30
from facetlog.robot.head.sony_models import EVI_D30, EVI_D100
from facetlog.robot.head.visca import AbsoluteMove, to_bytes
from facetlog.robot.simulator.heads.sony import SonyHead
from tests.robot.head.simulated import Silence, SimulatedLine

STEP = math.radians(1 / 8.8)


def started(device: SonyHead | None = None) -> tuple[SonyEviD30, SimulatedLine]:
    line = SimulatedLine(device or SonyHead())
    head = SonyEviD30(line, clock=line.clock)
    head.start()
    return head, line


def rad(degrees: float) -> float:
    return math.radians(degrees)


def test_a_look_to_the_left_and_down_is_the_bytes_of_the_fact_sheet() -> None:
    head, line = started()
    head.look(rad(-30), rad(-10))
    assert bytes.fromhex("81 01 06 02 18 14 00 01 00 08 0F 0F 08 08 FF") in line.sent


@settings(max_examples=40)
@given(st.floats(-100, 100), st.floats(-25, 25))
def test_it_ends_where_it_was_sent_and_stands_still(pan_deg: float, tilt_deg: float) -> None:
    head, line = started()
    state = head.look(rad(pan_deg), rad(tilt_deg))
    assert abs(state.pan - rad(pan_deg)) <= STEP / 2 * (1 + 1e-9)
    assert abs(state.tilt - rad(tilt_deg)) <= rad(1 / 12) / 2 * (1 + 1e-9)
    assert state.reported
    assert state.at == line.now
    true_pan, true_tilt, _ = line.device.angles(line.now)
    assert (true_pan, true_tilt) == pytest.approx((state.pan, state.tilt), abs=1e-12)


def test_answers_are_requested_in_two_pieces_at_most_the_shortest_first() -> None:
    head, line = started()
    head.look(rad(20), rad(5))
    lengths = {tuple(asked) for asked in line.asked}
    # A command: acknowledgement, completion. An inquiry: what an error has, then the rest.
    assert lengths <= {(3, 3), (3,), (4,), (4, 7), (4, 3), (4, 6)}
    for sent, asked in zip(line.sent, line.asked, strict=True):
        if sent == bytes.fromhex("81 09 06 12 FF"):
            assert asked == [4, 7]


def test_the_scale_is_that_of_the_model_which_the_head_says_it_is() -> None:
    head, line = started(SonyHead(EVI_D100))
    assert head.model is EVI_D100
    assert head.look(rad(50), rad(-20)).pan == pytest.approx(rad(50))
    assert to_bytes(AbsoluteMove(-720, -288)) in line.sent
    assert line.device.angles(line.now)[0] == pytest.approx(rad(50))


class Answering:
    """Answers each frame as a table says, others as a real head does."""

    def __init__(self, table: dict[str, str]) -> None:
        self.table = {bytes.fromhex(key): bytes.fromhex(text) for key, text in table.items()}
        self.head, self.said = SonyHead(), b""

    def receive(self, data: bytes, now: float) -> None:
        if data in self.table:
            self.said += self.table[data]
        else:
            self.head.receive(data, now)

    def pending(self, now: float) -> bytes:
        said, self.said = self.said + self.head.pending(now), b""
        return said

    def angles(self, now: float) -> tuple[float, float, float]:
        return self.head.angles(now)


def test_a_model_of_unknown_scale_is_refused_by_its_number() -> None:
    line = SimulatedLine(Answering({"81 09 00 02 FF": "90 50 00 20 05 0C 01 00 02 FF"}))
    with pytest.raises(DeviceError, match=r"model 050C.*EVI-D30 \(0402\)"):
        SonyEviD30(line, clock=line.clock).start()


def test_a_head_that_never_answers_ends_in_a_time_out_that_says_what_to_check() -> None:
    line = SimulatedLine(Silence())
    with pytest.raises(DeviceTimeout, match=r"power.*cable.*AUX1.*9600"):
        SonyEviD30(line, clock=line.clock).start()
    assert line.now - 100 < 10


def test_noise_on_the_line_ends_in_an_error_that_says_so() -> None:
    noise = random.Random(3)
    line = SimulatedLine(SonyHead(), lambda said: bytes(noise.randrange(256) for _ in said))
    with pytest.raises(DeviceError, match="cannot be read"):
        SonyEviD30(line, clock=line.clock).start()


def test_a_head_that_is_switched_off_meanwhile_is_reported() -> None:
    head, line = started()
    line.device.receive(bytes.fromhex("81 01 04 00 03 FF"), line.now)
    line.sleep(1.0)
    with pytest.raises(DeviceError, match="start it again"):
        head.look(rad(10), 0.0)


def test_sockets_that_another_left_taken_are_cleared() -> None:
    head, line = started()
    for _ in range(2):
        line.device.receive(to_bytes(AbsoluteMove(800, 0, pan_speed=1)), line.now)
        line.sleep(0.05)
    assert head.look(rad(10), rad(5)).pan == pytest.approx(rad(10))


def test_a_head_that_is_held_is_reported_after_a_few_attempts() -> None:
    line = SimulatedLine(SonyHead())
    head = SonyEviD30(line, clock=line.clock)
    head.start()
    held = Answering({"81 09 06 12 FF": "90 50 00 00 00 00 00 00 00 00 FF"})
    line.device = held
    with pytest.raises(DeviceError, match=r"stands at \(0, 0\).*sent to \(-352, 0\)"):
        head.look(rad(40), 0.0, timeout=60)


def slow() -> SonyHead:
    """Pans at 10 counts a second, as one that is held."""
    return SonyHead(replace(EVI_D30, pan_speeds_deg=(10 / 8.8,) * 24))


def test_a_slow_head_is_waited_for_until_the_timeout() -> None:
    head, line = started(slow())
    before = line.now
    with pytest.raises(DeviceTimeout, match="not still"):
        head.look(rad(90), 0.0, timeout=6.0)
    assert line.now - before < 8


def test_what_it_cannot_reach_is_refused_before_a_byte_is_sent() -> None:
    head, line = started()
    before = len(line.sent)
    for act in (
        lambda: head.look(rad(101), 0.0),
        lambda: head.look(math.nan, 0.0),
        lambda: head.look(0.0, rad(-26)),
    ):
        with pytest.raises(InputError):
            act()
    assert len(line.sent) == before


class Garbling:
    """Turns a bit of a byte by chance."""

    def __init__(self, seed: int, share: float) -> None:
        self.chance, self.share, self.on = random.Random(seed), share, False

    def __call__(self, said: bytes) -> bytes:
        return bytes(
            byte ^ (1 << self.chance.randrange(8))
            if self.on and self.chance.random() < self.share
            else byte
            for byte in said
        )


@pytest.mark.parametrize("seed", range(4))
def test_garbled_bytes_in_both_directions_do_not_lead_astray(seed: int) -> None:
    garble = Garbling(seed, 0.01)
    line = SimulatedLine(SonyHead(), garble)
    head = SonyEviD30(line, clock=line.clock)
    head.start()
    line.spoil_sent, garble.on = garble, True
    for pan, tilt in ((40, 10), (-60, -20), (5, 0)):
        state = head.look(rad(pan), rad(tilt), timeout=60)
        true_pan, true_tilt, _ = line.device.angles(line.now)
        # To half a count: a garbled order may have sent it half a degree off, which it tells.
        assert true_pan == pytest.approx(state.pan, abs=STEP / 2 + 1e-9)
        assert true_tilt == pytest.approx(state.tilt, abs=STEP / 2 + 1e-9)
        assert state.pan == pytest.approx(rad(pan), abs=rad(0.6))
        assert state.tilt == pytest.approx(rad(tilt), abs=rad(0.6))


@pytest.mark.parametrize(
    "lose",
    [
        lambda said: said.replace(b"\x90\x41\xff", b"").replace(b"\x90\x42\xff", b""),
        lambda said: said.replace(b"\x90\x51\xff", b"").replace(b"\x90\x52\xff", b""),
    ],
    ids=["acknowledgements", "completions"],
)
def test_without_completions_two_equal_places_end_a_move(lose: Callable[[bytes], bytes]) -> None:
    whole = WholeAnswers(lose)
    line = SimulatedLine(SonyHead(), whole)
    head = SonyEviD30(line, clock=line.clock)
    head.start()
    whole.on = True
    if lose(b"\x90\x41\xff"):
        assert head.look(rad(90), rad(20), timeout=20).pan == pytest.approx(rad(90))
    else:
        # Never acknowledged: it cannot be told from one that does not hear.
        with pytest.raises(DeviceError):
            head.look(rad(90), rad(20), timeout=20)


class WholeAnswers:
    """Hands on answers once they are whole, changed."""

    def __init__(self, change: Callable[[bytes], bytes]) -> None:
        self.change, self.on, self.begun = change, False, b""

    def __call__(self, said: bytes) -> bytes:
        if not self.on:
            return said
        self.begun += said
        end = self.begun.rfind(b"\xff") + 1
        whole, self.begun = self.begun[:end], self.begun[end:]
        return b"".join(self.change(part + b"\xff") for part in whole.split(b"\xff")[:-1])


def test_a_completion_that_comes_late_is_not_taken_for_a_place() -> None:
    head, line = started(slow())
    state = head.look(rad(-10), 0.0, timeout=20)
    assert state.pan == pytest.approx(rad(-10))
    assert line.device.angles(line.now)[0] == pytest.approx(rad(-10))
