"""Odometry through roll-over, lost reports and its own errors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from facetlog.perception.types import FloatArray
from facetlog.robot.pioneer.packets.reports import ServerInformation
from facetlog.robot.pioneer.parameters import MODELS, Parameters
from facetlog.robot.pioneer.state import Odometry, OdometryErrors
from facetlog.robot.pose2 import Pose2, wrapped

P3DX, P2DX, PION = MODELS["p3dx"], MODELS["p2dx"], MODELS["pion1m"]


def report(
    p: Parameters, pose: Pose2, speed: float = 0.3, turning: float = 0.0, bits: int | None = None
) -> ServerInformation:
    """As a robot sends it that stands at `pose` of its own odometry, anywhere in its range."""
    bits = p.position_bits if bits is None else bits
    difference = turning / p.turning_per_speed
    return ServerInformation(
        x=round(pose.x / p.distance) % (1 << bits),
        y=round(pose.y / p.distance) % (1 << bits),
        heading=round(wrapped(pose.heading) / p.angle),
        left=round((speed - difference) / p.speed),
        right=round((speed + difference) / p.speed),
        battery=120,
        stall_left=False,
        stall_right=False,
        rear_bumpers=0,
        front_bumpers=0,
        control=0,
        flags=1,
        compass=0,
    )


def test_the_frame_is_that_of_the_robot_at_the_first_report() -> None:
    odometry = Odometry(P3DX)
    start = Pose2(1.2, 0.3, math.radians(120))
    for i in range(11):
        odometry.update(report(P3DX, start.compose(Pose2(0.03 * i, 0.0))), i / 10)
    assert odometry.pose.x == pytest.approx(0.3, abs=0.001)
    assert odometry.pose.y == pytest.approx(0.0, abs=0.001)
    assert odometry.pose.heading == 0.0


@pytest.mark.parametrize(
    ("name", "bits"),
    [
        ("p2dx", 12),
        ("p3dx", 16),
        ("p2at", 15),
        ("pion1m", 15),
    ],
)
def test_long_ways_roll_over_many_times_unseen(name: str, bits: int) -> None:
    """On firmware that counts 12 bits or 15, and simulators that send 16."""
    p = MODELS[name]
    odometry = Odometry(p)
    for i in range(401):
        pose = Pose2(-0.05 * i, 0.03 * i, 0.0)
        assert odometry.update(report(p, pose, speed=0.6, bits=bits), i / 10) is None
    assert odometry.pose.x == pytest.approx(-20.0, abs=0.003)
    assert odometry.pose.y == pytest.approx(12.0, abs=0.003)


@given(st.lists(st.booleans(), min_size=60, max_size=60), st.floats(-0.4, 0.4))
def test_lost_reports_lose_no_way(lost: list[bool], speed: float) -> None:
    kept = [False, *lost[1:-1], False]
    odometry, last = Odometry(P2DX), 0
    for i, gone in enumerate(kept):
        if gone and i - last < 30:
            continue
        odometry.update(report(P2DX, Pose2(speed * i / 10, 0.0), speed), i / 10)
        last = i
    assert odometry.pose.x == pytest.approx(speed * (len(kept) - 1) / 10, abs=P2DX.distance)


def standing_reports(odometry: Odometry, poses: list[Pose2]) -> list[str | None]:
    return [odometry.update(report(P3DX, pose, 0.0), i / 10) for i, pose in enumerate(poses)]


@pytest.mark.parametrize("there", [Pose2(-0.3, 0.4, 2.0), Pose2(0, 0, -1.5)])
def test_odometry_that_was_set_anew_leaves_a_standing_robot_where_it_is(there: Pose2) -> None:
    """As by another client's SETO: no wheel made that way, and the robot's own frame is another."""
    odometry, stood = Odometry(P3DX), Pose2(0.05, 0, 0.3)
    said = standing_reports(odometry, [Pose2(), stood, there, there, there])
    assert [text is None for text in said] == [True, True, True, False, True]
    off = stood.between(there)
    assert f"jumped by {math.hypot(off.x, off.y):.2f} m" in str(said[3])
    sure = odometry.covariance
    for i in range(1, 6):  # it drives on along its own heading
        odometry.update(report(P3DX, there.compose(Pose2(0.02 * i, 0, 0)), 0.2), (4 + i) / 10)
    expected = stood.compose(Pose2(0.1, 0, 0))
    assert (odometry.pose.x, odometry.pose.y) == pytest.approx((expected.x, expected.y), abs=0.002)
    assert odometry.pose.heading == pytest.approx(0.3, abs=0.002)
    assert math.sqrt(sure[0, 0]) < 0.01


def test_a_robot_that_drove_when_its_odometry_was_set_anew_is_less_certain_by_its_way() -> None:
    odometry = Odometry(P3DX)
    for i in range(10):
        odometry.update(report(P3DX, Pose2(0.05 * i, 0, 0), 0.5), i / 10)
    before = odometry.covariance
    for i in range(3):
        odometry.update(report(P3DX, Pose2(-0.9 + 0.05 * i, 0.5, 0), 0.5), 1.0 + i / 10)
    grown = np.sqrt(np.diag(odometry.covariance - before)[:2])
    assert (grown >= 0.05 - 1e-9).all()
    # One step of 5 cm is not known; the one after it is.
    assert odometry.pose.x == pytest.approx(0.05 * 9 + 0.05 * 2, abs=0.002)


@pytest.mark.parametrize("damaged", [Pose2(-0.95, 0.97, 0), Pose2(0, 0, 2.5)])
def test_a_damaged_report_that_passed_for_whole_is_left_out(damaged: Pose2) -> None:
    """Beyond half a roll-over its return would not cancel it: a lap of 2 m would stay."""
    odometry = Odometry(P3DX)
    for i in range(60):
        pose = Pose2(0.02 * i, 0.0)
        seen = pose.compose(damaged) if i in (20, 33, 47) else pose
        assert odometry.update(report(P3DX, seen, 0.2), i / 10) is None
    assert odometry.pose.x == pytest.approx(0.02 * 59, abs=0.001)
    assert (odometry.pose.y, odometry.pose.heading) == (0.0, 0.0)
    assert math.sqrt(odometry.covariance[0, 0]) < 0.02


def test_a_damaged_first_report_is_no_origin() -> None:
    odometry, there = Odometry(P3DX), Pose2(0.9, 0.4, 1.5)
    standing_reports(odometry, [Pose2(), there, there, there.compose(Pose2(0.05, 0.0))])
    assert odometry.pose.x == pytest.approx(0.05, abs=0.001)
    assert odometry.pose.y == pytest.approx(0.0, abs=0.001)
    assert odometry.pose.heading == 0.0


def test_a_gap_in_which_positions_may_roll_over_is_said() -> None:
    odometry = Odometry(P3DX)
    odometry.update(report(P3DX, Pose2(0, 0, 0), 0.5), 0.0)
    said = odometry.update(report(P3DX, Pose2(0.2, 0, 0), 0.5), 2.1)
    assert said is not None
    assert "roll over" in said


def test_a_gap_in_which_whole_turns_may_be_missing_is_said() -> None:
    odometry = Odometry(P3DX)
    odometry.update(report(P3DX, Pose2(0, 0, 0), 0.0, 2.0), 0.0)
    said = odometry.update(report(P3DX, Pose2(0, 0, 0.5), 0.0, 2.0), 1.8)
    assert said is not None
    assert "turns" in said


def steps_of(tour: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Legs of (way, turn) in the small steps between reports."""
    steps = []
    for way, turn in tour:
        count = max(1, round(max(abs(way) / 0.03, abs(turn) / 0.05)))
        steps += [(way / count, turn / count)] * count
    return steps


RING = steps_of([(1.0, 0.0), (0.0, 1.2), (0.8, 0.9), (0.0, -0.7), (1.5, 1.5), (-0.4, 0.0)])


def truth_and_report(errors: OdometryErrors, rng: np.random.Generator) -> tuple[Pose2, Odometry]:
    """A robot drives a tour; its odometry is wrong as the errors say."""
    way_off = rng.normal(0, errors.way)
    turn_off = rng.normal(0, errors.turning)
    drift = rng.normal(0, errors.drift)
    odometry = Odometry(P3DX, errors)
    true, told = Pose2(), Pose2()
    odometry.update(report(P3DX, told), 0.0)
    for i, (way, turn) in enumerate(RING, 1):
        told = told.compose(Pose2(0, 0, turn / 2)).compose(Pose2(way, 0, turn / 2))
        really = way * (1 + way_off) + rng.normal(0, errors.way_noise * math.sqrt(abs(way)))
        heading_noise = math.sqrt(
            errors.turning_noise**2 * abs(turn) + errors.drift_noise**2 * abs(way)
        )
        turned = turn * (1 + turn_off) + drift * way + rng.normal(0, heading_noise)
        true = true.compose(Pose2(0, 0, turned / 2)).compose(Pose2(really, 0, turned / 2))
        odometry.update(report(P3DX, told), i / 10)
    return true, odometry


def test_the_covariance_is_honest() -> None:
    """Mean NEES of 60 robots, each with its own constant errors, within chi-square's 99 %."""
    rng, runs, total = np.random.default_rng(61), 60, 0.0
    for _ in range(runs):
        true, odometry = truth_and_report(OdometryErrors(), rng)
        off = np.array(
            [
                true.x - odometry.pose.x,
                true.y - odometry.pose.y,
                wrapped(true.heading - odometry.pose.heading),
            ]
        )
        total += float(off @ np.linalg.solve(odometry.covariance, off))
    low, high = chi2.ppf([0.005, 0.995], 3 * runs) / runs
    assert low < total / runs < high


def test_the_drift_that_users_report_is_two_deviations() -> None:
    """30 cm aside after 5 m straight on, the worst that users complained of."""
    odometry = Odometry(P3DX)
    for i in range(101):
        odometry.update(report(P3DX, Pose2(0.05 * i, 0.0)), i / 10)
    aside = math.sqrt(odometry.covariance[1, 1])
    assert 2 * aside == pytest.approx(0.30, rel=0.1)
    assert math.sqrt(odometry.covariance[0, 0]) == pytest.approx(0.05, rel=0.05)


@given(st.lists(st.tuples(st.floats(-0.03, 0.03), st.floats(-0.1, 0.1)), min_size=1, max_size=60))
def test_the_covariance_is_symmetric_and_positive(steps: list[tuple[float, float]]) -> None:
    odometry, pose = Odometry(P3DX), Pose2()
    for i, (way, turn) in enumerate(steps):
        pose = pose.compose(Pose2(way, 0, turn))
        odometry.update(report(P3DX, pose), i / 10)
    P: FloatArray = odometry.covariance
    assert np.array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() > 0
    assert not P.flags.writeable
