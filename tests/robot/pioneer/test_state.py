"""What a report says in metres, radians and seconds, by the model and its firmware."""

import math
from dataclasses import replace

import pytest

from facetlog.robot.pioneer.packets.reports import ServerInformation, SonarReading
from facetlog.robot.pioneer.parameters import MODELS
from facetlog.robot.pioneer.state import StateMaker
from tests.robot.pioneer.scripted import CONFIGURATION

REPORT = ServerInformation(
    x=100,
    y=200,
    heading=0,
    left=200,
    right=240,
    battery=121,
    stall_left=False,
    stall_right=True,
    rear_bumpers=0b10,
    front_bumpers=0b10001,
    control=0,
    flags=0b10000100001,
    compass=0,
    sonar=(SonarReading(0, 1000), SonarReading(3, 500)),
)


def test_speeds_ranges_and_voltages_are_in_si() -> None:
    state, doubt = StateMaker(MODELS["p3dx"], CONFIGURATION).state(REPORT, 7.0)
    assert doubt is None
    assert state.at == 7.0
    assert state.speed == pytest.approx(0.22)
    assert state.turning == pytest.approx(0.02 * 5.6)  # (R - L) / 2 × 2 / track
    assert (state.left_speed, state.right_speed) == pytest.approx((0.2, 0.24))
    assert state.battery_v == pytest.approx(12.1)
    assert state.stalled == (False, True)
    assert not state.standing
    assert {s.index: s.range for s in state.sonars} == pytest.approx({0: 1.0, 3: 0.5})


def test_units_are_those_of_the_model() -> None:
    state, _ = StateMaker(MODELS["pion1m"]).state(REPORT, 0.0)
    assert state.left_speed == pytest.approx(200 * 2.5332e-3)
    assert state.sonars[0].range == pytest.approx(1000 * 0.1734e-3)


def test_bumpers_are_as_many_as_the_robot_has_and_from_left_to_right() -> None:
    state, _ = StateMaker(MODELS["p3dx"], CONFIGURATION).state(REPORT, 0.0)
    assert state.front_bumpers == (True, False, False, False, True)
    assert state.rear_bumpers == (False, True, False, False, False)
    none = replace(CONFIGURATION, front_bumpers=0, rear_bumpers=0)
    state, _ = StateMaker(MODELS["p3dx"], none).state(REPORT, 0.0)
    assert (state.front_bumpers, state.rear_bumpers) == ((), ())
    state, _ = StateMaker(MODELS["p3dx"]).state(REPORT, 0.0)
    assert len(state.front_bumpers) == len(state.rear_bumpers) == 5


def test_flags_are_believed_from_aros_on_only() -> None:
    told, _ = StateMaker(MODELS["p3dx"]).state(REPORT, 0.0)
    assert (told.motors_on, told.stop_button) == (True, True)
    old, _ = StateMaker(MODELS["p2dx"]).state(REPORT, 0.0)
    assert (old.motors_on, old.stop_button) == (None, None)
    new = {name for name, p in MODELS.items() if p.generation.reports_motors}
    assert new == {"p2d8", "p2at8", "p3dx", "p3dx-sh", "p3at", "p3at-sh"}


def test_sonars_keep_their_last_range() -> None:
    maker = StateMaker(MODELS["p2dx"])
    maker.state(REPORT, 1.0)
    state, _ = maker.state(replace(REPORT, sonar=(SonarReading(3, 600),)), 2.0)
    assert [(s.index, s.at) for s in state.sonars] == [(0, 1.0), (3, 2.0)]
    assert state.sonars[1].range == pytest.approx(600 * 0.268e-3)
    assert state.sonars[0].place == MODELS["p2dx"].sonars[0]


def test_a_sonar_that_no_table_has_is_kept_without_its_place() -> None:
    state, _ = StateMaker(MODELS["pion1m"]).state(
        replace(REPORT, sonar=(SonarReading(30, 1),)), 0.0
    )
    assert state.sonars[0].place is None


def test_fields_of_later_firmware_go_before_those_that_they_refine() -> None:
    later = replace(REPORT, battery_10=265, turning=-100)
    state, _ = StateMaker(MODELS["p3dx"]).state(later, 0.0)
    assert state.battery_v == pytest.approx(26.5)
    assert state.turning == pytest.approx(math.radians(-10))
