"""Walls, bumpers, stalls: the robot does not go through things, and says what it feels."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.solids import cuboid, cylinder, placed, table
from facetlog.robot.rendering.world import Solid
from facetlog.robot.simulator.body import Obstacles
from tests.robot.simulator.clients import Client, connected, make_firmware

RADIUS = 0.25
BLOCK = cuboid(0.2, 0.2, 0.2)


def against(block: Solid, speed: int = 200, model: str = "p3dx") -> Client:
    client = connected(make_firmware(model, block))
    client.command(Command.VEL, speed)
    client.wait_pulsing(6.0)
    return client


@pytest.mark.parametrize(("speed", "x"), [(200, 0.8), (-200, -0.8)])
def test_both_wheels_stall_while_it_pushes(speed: int, x: float) -> None:
    client = against(placed(BLOCK, x, 0.0), speed)
    seen = [client.report() for _ in range(10)]
    stalled = [report for report in seen if report.stall_left]
    assert stalled
    assert all(report.stall_right == report.stall_left for report in seen)
    assert not any(report.left or report.right for report in stalled)


def test_it_can_drive_away_from_what_it_touches_and_turn_at_it() -> None:
    client = against(placed(BLOCK, 0.8, 0.0))
    touched = client.truth.x
    client.command(Command.VEL, 0)
    client.command(Command.RVEL, 20)
    client.wait_pulsing(2.0)
    assert client.truth.heading > math.radians(30)
    client.command(Command.RVEL, 0)
    client.command(Command.VEL, -200)
    client.wait_pulsing(3.0)
    assert client.truth.x < touched - 0.2
    report = client.report()
    assert (report.front_bumpers, report.stall_left) == (0, False)


@pytest.mark.parametrize(
    ("bearing_deg", "front", "rear"),
    [
        (80, 0b00001, 0),
        (0, 0b00100, 0),
        (-40, 0b01000, 0),
        (-140, 0, 0b00010),
        (100, 0, 0b10000),
    ],
)
def test_the_bumper_on_the_side_of_the_contact_is_pressed(
    bearing_deg: float, front: int, rear: int
) -> None:
    # a thin post that touches the robot from that side
    angle = math.radians(bearing_deg)
    post = cylinder(0.02, 0.3, facets=24)
    distance = RADIUS + 0.0105
    post = placed(post, distance * math.cos(angle), distance * math.sin(angle))
    report = connected(make_firmware("p3dx", post)).report()
    assert (report.front_bumpers, report.rear_bumpers) == (front, rear)


def test_what_is_higher_than_the_robot_is_not_in_its_way() -> None:
    high = table(1.4, 1.0, 0.75, thickness=0.05, leg=0.06)
    obstacles = Obstacles.of((high,), radius=RADIUS, height=0.24)
    middle = obstacles.nearest(0.0, 0.0)
    assert middle is not None
    assert middle.gap > 0.3, "the robot stands below the table"
    low = Obstacles.of((high,), radius=RADIUS, height=0.8).nearest(0.0, 0.0)
    assert low is not None
    assert low.gap < 0


@settings(max_examples=15)
@given(
    heading=st.floats(-math.pi, math.pi),
    speed=st.sampled_from([-750, -300, 300, 750]),
    turning=st.integers(-90, 90),
)
def test_no_drive_takes_the_robot_into_a_solid(heading: float, speed: int, turning: int) -> None:
    ring = [
        placed(BLOCK, 0.9 * math.cos(a), 0.9 * math.sin(a), yaw=a)
        for a in (math.tau * i / 12 for i in range(12))
    ]
    client = connected(make_firmware("p3dx", *ring, start=Pose2(0.0, 0.0, heading)))
    obstacles = Obstacles.of(tuple(ring), radius=RADIUS, height=0.24)
    client.command(Command.VEL, speed)
    client.command(Command.RVEL, turning)
    for _ in range(12):
        client.command(Command.PULSE)
        client.wait(0.25)
        found = obstacles.nearest(client.truth.x, client.truth.y)
        assert found is not None
        assert found.gap > -1e-6
        assert math.hypot(client.truth.x, client.truth.y) < 0.9
