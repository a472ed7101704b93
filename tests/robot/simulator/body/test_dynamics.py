"""Motion errors: odometry and truth part as the figures say, and the same seed repeats itself."""

import math

import numpy as np
import pytest

from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.simulator.body import STEP, Body, MotionErrors
from tests.robot.simulator.clients import ORIGIN, Client, connected, make_firmware

TRACK = 0.35


def driven(errors: MotionErrors, seed: int = 0, way: int = 2000) -> Client:
    client = connected(make_firmware("p3dx", errors=errors, seed=seed))
    client.command(Command.VEL, 300)
    client.wait_pulsing(way / 300)
    return client


def test_without_errors_odometry_is_the_truth() -> None:
    client = connected(make_firmware())
    client.command(Command.VEL, 300)
    client.command(Command.RVEL, 20)
    client.wait_pulsing(20.0)
    odometry, truth = client.firmware.drive.odometry, client.truth
    assert (truth.x, truth.y, truth.heading) == pytest.approx(
        (odometry.x, odometry.y, odometry.heading), abs=1e-9
    )


def test_unequal_wheels_bend_a_straight_way() -> None:
    client = driven(MotionErrors(left=0.01, right=-0.01))
    track = client.firmware.drive.body.track
    way = client.firmware.drive.odometry.x
    assert client.truth.heading == pytest.approx(-0.02 * way / track, rel=0.01)
    assert client.firmware.drive.odometry.heading == 0.0


def test_a_wider_track_turns_less_than_it_counts() -> None:
    client = connected(make_firmware(errors=MotionErrors(track=0.05)))
    client.command(Command.RVEL, 30)
    client.wait_pulsing(4.0)
    counted = client.firmware.drive.odometry.heading
    assert client.truth.heading == pytest.approx(counted / 1.05, rel=1e-3)


@pytest.mark.parametrize("kind", ["slip", "encoder"])
def test_random_errors_grow_with_the_root_of_the_way(kind: str) -> None:
    sd = 0.004
    spread = {}
    for way in (500, 2000):
        headings = []
        for seed in range(40):
            rng = np.random.default_rng(seed)
            body = Body(TRACK, ORIGIN, errors=MotionErrors(**{kind: sd}), rng=rng, speed=0.5)
            turns = [body.step()[1] for _ in range(round(way / 0.5e3 / STEP))]
            headings.append((body.truth.heading - sum(turns)) * TRACK)
        spread[way] = float(np.std(headings))
    # the difference of two wheels: √2 sd √way; 40 draws tell a deviation to 11 %
    for way, found in spread.items():
        assert found == pytest.approx(math.sqrt(2 * way / 1e3) * sd, rel=0.35)


def test_the_way_does_not_depend_on_how_often_it_is_looked_at() -> None:
    errors = MotionErrors(slip=0.005)
    ends = []
    for pause in (0.5, 0.013):
        client = connected(make_firmware(errors=errors))
        client.command(Command.VEL, 300)
        begun = client.now
        while client.now < begun + 1.9:
            client.wait(min(pause, begun + 1.9 - client.now))
        ends.append(client.truth)
    assert ends[0] == ends[1]
