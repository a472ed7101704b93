"""`facetlog collect --explore` with the simulated robot, by the clock."""

import json
import math
import re
import threading
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.robot.collecting.record import read_log, read_record
from facetlog.robot.simulator.station import Station
from facetlog.robot.simulator.world_file import read_world

pytestmark = pytest.mark.slow

# The block of the default world, and how near the robot may come.
TARGET, KEEP_OUT = (0.59, 1.42, 0.08), 0.5


def test_a_block_is_explored_and_the_next_choice_is_told_without_a_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "views"
    local = "127.0.0.1:0"
    options = [
        *("-o", str(out), "--explore", "--target", ",".join(map(str, TARGET))),
        *("--until", "box >= 20%", "--max-views", "5"),
    ]
    with Station(read_world(None), listen=local, pty=False, camera=local) as station:
        thread = threading.Thread(target=station.serve)
        thread.start()
        try:
            addresses = station.addresses
            robot = ["collect", addresses.robot, "--camera", addresses.camera]
            code = main([*robot, *options, "--keep-out", str(KEEP_OUT), "--speed", "0.5"])
        finally:
            station.stop()
            thread.join()
    told = capsys.readouterr()
    assert code == 0, told.err
    reason = re.search(r"no further view: (box holds to (\d+)%, 20% wanted; .*)", told.out)
    assert reason is not None
    # One figure all the way: in the lines, in the reason and at the end.
    assert f"t1 is a box (degree {reason[2]}%)" in told.out
    assert f"t1 is a box (degree {reason[2]}%)" in told.err
    _, taken = read_record(out)
    assert 3 <= len(taken) <= 5
    for view in taken:
        assert math.dist((view.robot.x, view.robot.y), TARGET[:2]) > KEEP_OUT
    assert (out / "map.png").is_file()
    explored = next(line for line in read_log(out) if line.get("result") == "explored")
    assert explored["reason"] == reason[1]

    # No robot answers there: none is asked. Of a block it is sure that it is no chair.
    folder = ["collect", "tcp:127.0.0.1:1", "-o", str(out), "--explore", "--dry-run"]
    # The goal is that of the run, unless another is given.
    assert main(folder) == 1
    assert "20% wanted" in capsys.readouterr().out
    argv = ["collect", "tcp:127.0.0.1:1", *options, "--dry-run", "--json"]
    code = main([*argv, "--until", "box >= 100%"])
    line = json.loads(capsys.readouterr().out)
    assert line["result"] == ("chosen" if code == 0 else "explored")
