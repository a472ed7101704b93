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
    client.command(Command.MOVE, way)
    client.wait_pulsing(way / 300 + 4.0)
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


def test_a_circle_has_the_radius_of_speed_over_turning() -> None:
    client = connected(make_firmware())
    client.command(Command.VEL, 200)
    client.command(Command.RVEL, 20)
    client.wait_pulsing(3.0)
    places = []
    for _ in range(60):
        client.command(Command.PULSE)
        client.wait(0.3)
        places.append((client.truth.x, client.truth.y))
    x, y = np.array(places).T
    # circle through all places: x² + y² = 2 a x + 2 b y + c
    a, b, c = np.linalg.lstsq(np.column_stack([2 * x, 2 * y, np.ones(60)]), x**2 + y**2)[0]
    assert math.sqrt(c + a**2 + b**2) == pytest.approx(0.2 / math.radians(20), rel=1e-3)


def test_unequal_wheels_bend_a_straight_way() -> None:
    client = driven(MotionErrors(left=0.01, right=-0.01))
    track = client.firmware.drive.body.track
    assert client.truth.heading == pytest.approx(-0.02 * 2.0 / track, rel=0.01)
    assert client.firmware.drive.odometry.heading == 0.0


def test_larger_wheels_go_further_than_they_count() -> None:
    client = driven(MotionErrors(left=0.02, right=0.02))
    assert client.truth.x == pytest.approx(2.0 * 1.02, abs=2e-3)


def test_a_wider_track_turns_less_than_it_counts() -> None:
    client = connected(make_firmware(errors=MotionErrors(track=0.05)))
    client.command(Command.HEAD, 170)
    client.wait_pulsing(6.0)
    assert math.degrees(client.truth.heading) == pytest.approx(170 / 1.05, abs=0.2)


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


def test_the_same_seed_drives_the_same_way_and_another_one_does_not() -> None:
    errors = MotionErrors(slip=0.005, encoder=0.002)
    first, again, other = (driven(errors, seed, 500).truth for seed in (1, 1, 2))
    assert first == again
    assert first != other


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
