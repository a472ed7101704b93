"""Whatever comes over the line, a driver ends in time, with a place or with a device's error."""

import math
import random

import pytest

from facetlog.errors import DeviceError
from facetlog.robot.head.canon_vcc4 import CanonVcC4
from facetlog.robot.head.head import PanTiltHead
from facetlog.robot.head.sony_evi_d30 import SonyEviD30
from facetlog.robot.simulator.heads.canon import CanonHead
from facetlog.robot.simulator.heads.sony import SonyHead
from tests.robot.head.simulated import SimulatedLine

LONGEST_S = 60.0
"""Simulated: twice what the slowest of them takes, a head that is started without answers."""
ANGLE = math.radians(20)


class BadLine:
    """Loses, garbles, doubles and makes up bytes, each by chance; or says anything at all."""

    def __init__(self, seed: int) -> None:
        self.chance = random.Random(seed)
        self.share = self.chance.choice([0.003, 0.02, 0.1, 0.5, 1.0])

    def __call__(self, said: bytes) -> bytes:
        heard = bytearray()
        for byte in said:
            if self.chance.random() >= self.share:
                heard.append(byte)
                continue
            match self.chance.randrange(4):
                case 0:
                    heard.append(self.chance.randrange(256))
                case 1:
                    heard += bytes([byte, byte])
                case 2:
                    heard += self.chance.choice([b"\xff", b"\x90", b"\xfe00", b"\xef", b"\x90\x50"])
        return bytes(heard)


def heads(seed: int, kind: str) -> tuple[PanTiltHead, SimulatedLine]:
    if kind == "sony":
        sony = SimulatedLine(SonyHead(powered=seed % 2 == 0), BadLine(seed))
        return SonyEviD30(sony, clock=sony.clock), sony
    canon = SimulatedLine(CanonHead(answers=seed % 5 != 0), BadLine(seed))
    return CanonVcC4(canon, clock=canon.clock), canon


@pytest.mark.parametrize("kind", ["sony", "canon"])
def test_a_driver_ends_in_time_with_a_place_or_an_error_of_the_device(kind: str) -> None:
    arrived, refused = 0, 0
    for seed in range(60):
        head, line = heads(seed, kind)
        try:
            head.start()
            state = head.look(ANGLE, 0.0, timeout=30.0)
        except DeviceError:
            refused += 1
        else:
            arrived += 1
            assert state.pan == pytest.approx(ANGLE, abs=math.radians(0.7))
        assert line.now - 100 < LONGEST_S
    # Both happen, or the lines are too good or too bad to show anything.
    assert arrived > 10
    assert refused > 10
