"""Sonars of a collection, from its log: where each measured in the world."""

import math
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.mapping.sonar_beams import FARTHEST, driven
from facetlog.robot.collecting.request import TRAFFIC_FILE
from facetlog.robot.collecting.run_sessions import Run
from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.station import Station
from facetlog.robot.simulator.world_file import SceneSetup, SolidSetup, read_world
from tests.patience import allowed


@pytest.mark.slow
def test_echoes_of_a_session_lie_on_what_stands_before_the_robot(tmp_path: Path) -> None:
    """A board across its way, 1.2 m ahead in the world, of a robot that began elsewhere."""
    board = SolidSetup("box", (0.1, 4.0, 0.5), at=(1.25, 0.0))
    setup = read_world(None)
    setup = replace(setup, scene=SceneSetup("empty", solid=(board,)))
    local = "127.0.0.1:0"
    with Station(setup, listen=local, pty=False, camera=local) as station:
        thread = threading.Thread(target=station.serve)
        thread.start()
        try:
            log = tmp_path / TRAFFIC_FILE
            with Pioneer.connect(station.addresses.robot, log=log) as robot:
                began = time.time()
                robot.switch_sonars(True)
                robot.wait_for(lambda state: len(state.sonars) >= 8, allowed(3.0))
        finally:
            station.stop()
            thread.join()
    start = Pose2(2.0, 3.0, math.pi / 2)
    found = driven(tmp_path, (Run(began, start),))
    assert found.radius > 0.2
    # Its front is at y = 3 + 1.2 in that world.
    ahead = [b for b in found.beams if abs(b.heading - math.pi / 2) < math.radians(20) and b.echo]
    assert ahead
    for beam in ahead:
        assert beam.y + beam.range == pytest.approx(4.2, abs=0.06)
    assert all(0.0 < beam.range <= FARTHEST for beam in found.beams)
    assert driven(tmp_path, (Run(began - 3600.0, start),)).beams == ()
