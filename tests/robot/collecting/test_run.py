"""The command with the simulated robot, by the clock: over TCP and over a serial line."""

import json
import math
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from facetlog.cli import main
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import read_views_from, recognize_views
from facetlog.robot.collecting.record import read_record
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.station import Station
from facetlog.robot.simulator.world_file import SolidSetup, read_world
from tests.patience import allowed

pytestmark = pytest.mark.slow

TOUR = """image,x,y,z,pan_deg,tilt_deg
first,0.25,0.36,0.7239,-19,-113
second,0.45,0.39,0.7239,0,-113
third,0.67,0.35,0.7239,13,-113
"""
# The way there is straight, from the world's origin.
FAR = """image,x,y,z,pan_deg,tilt_deg
a,1.8,0.3,0.7239,46,-113
b,1.9,0.6,0.7239,58,-113
"""
PLACES = ((0.25, 0.36), (0.45, 0.39), (0.67, 0.35))


@contextmanager
def simulated(
    *, pty: bool = False, seed: int = 0, besides: tuple[SolidSetup, ...] = ()
) -> Iterator[Station]:
    setup = replace(read_world(None), seed=seed)
    setup = replace(setup, scene=replace(setup.scene, solid=besides))
    local = "127.0.0.1:0"
    with Station(setup, listen=local, pty=pty, camera=local) as station:
        thread = threading.Thread(target=station.serve)
        thread.start()
        try:
            yield station
        finally:
            station.stop()
            thread.join()


def _state(station: Station) -> dict[str, Any]:
    with urllib.request.urlopen(station.addresses.state) as answer:  # noqa: S310
        state: dict[str, Any] = json.load(answer)
    return state


def _true(station: Station) -> Pose2:
    truth = _state(station)["truth"]
    return Pose2(truth["x"], truth["y"], truth["heading"])


def _fault(station: Station, fault: dict[str, object]) -> None:
    request = urllib.request.Request(  # noqa: S310
        station.addresses.faults, json.dumps(fault).encode(), {"Content-Type": "application/json"}
    )
    urllib.request.urlopen(request).close()  # noqa: S310


def _tour(folder: Path) -> str:
    path = folder / "tour.csv"
    path.write_text(TOUR, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("pty", [False, True], ids=["tcp", "pty"])
def test_a_tour_is_collected_with_poses_as_good_as_odometry(
    pty: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "views"
    with simulated(pty=pty) as station:
        addresses = station.addresses
        robot = addresses.pty if pty else addresses.robot
        assert robot is not None
        options = ["--unit", "m", "--camera", addresses.still if pty else addresses.camera]
        assert main(["collect", robot, "--tour", _tour(tmp_path), "-o", str(out), *options]) == 0
        true = _true(station)
    assert capsys.readouterr().out.startswith("3 of 3 views, ")
    _, taken = read_record(out)
    assert [view.name for view in taken] == ["first.png", "second.png", "third.png"]
    for view, place in zip(taken, PLACES, strict=True):
        assert math.dist(view.pose.centre[:2], place) < 0.04
    last = taken[-1]
    # Half a per cent between the wheels: 1 cm and 1 degree on the way of 0.9 m.
    assert math.dist((last.robot.x, last.robot.y), (true.x, true.y)) < 0.02
    assert abs(math.remainder(last.robot.heading - true.heading, math.tau)) < math.radians(2)
    present = {path.name for path in out.iterdir()}
    assert present >= {"map.png", "odometry.tum", "traffic.jsonl", "transforms.json", "images.txt"}
    assert not any(name.endswith(".part") for name in present)


def test_a_frozen_camera_ends_it_and_the_rest_is_taken_later(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "views"
    with simulated() as station:
        addresses = station.addresses
        argv = [
            *("collect", addresses.robot, "--tour", _tour(tmp_path), "-o", str(out)),
            *("--unit", "m", "--camera", addresses.camera),
        ]

        def freeze() -> None:
            while not (out / "first.png").exists():
                time.sleep(0.05)
            _fault(station, {"kind": "camera-frozen"})

        watcher = threading.Thread(target=freeze)
        watcher.start()
        assert main(argv) == 3
        watcher.join()
        assert "is frozen" in capsys.readouterr().err
        _, taken = read_record(out)
        assert [view.name for view in taken] == ["first.png"]

        _fault(station, {"kind": "camera-frozen", "on": False})
        true = _true(station)
        start = f"{true.x},{true.y},{math.degrees(true.heading)}"
        assert main([*argv, "--resume", "--start", start]) == 0
    _, taken = read_record(out)
    assert [view.name for view in taken] == ["first.png", "second.png", "third.png"]


def test_what_stands_in_the_way_is_seen_before_it_is_touched(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tour = tmp_path / "tour.csv"
    tour.write_text(FAR, encoding="utf-8")
    block = SolidSetup("box", size=(0.3, 0.3, 0.4), at=(1.0, 0.17))
    with simulated(besides=(block,)) as station:
        addresses = station.addresses
        argv = ["collect", addresses.robot, "--tour", str(tour), "-o", str(tmp_path / "views")]
        options = ["--unit", "m", "--camera", addresses.camera, "--speed", "0.5"]
        assert main([*argv, *options]) == 3
        state = _state(station)
    assert "something is close ahead of the robot" in capsys.readouterr().err
    assert not state["touching"]
    assert 0.3 < state["truth"]["x"] < 0.85 - 0.25


def test_a_program_that_is_terminated_stops_the_robot_first(tmp_path: Path) -> None:
    out = tmp_path / "views"
    with simulated() as station:
        addresses = station.addresses
        argv = [
            *("collect", addresses.robot, "--tour", _tour(tmp_path), "-o", str(out)),
            *("--unit", "m", "--camera", addresses.camera),
        ]
        process = subprocess.Popen(
            [sys.executable, "-m", "facetlog", *argv], stderr=subprocess.PIPE, text=True
        )
        while _state(station)["speed"] < 0.1:
            assert process.poll() is None
            time.sleep(0.05)
        process.terminate()
        _, said = process.communicate(timeout=allowed(20.0))
        assert process.returncode == 130
        # The session was ended in order: its own end, not the watchdog, switched the motors off.
        state = _state(station)
        assert (state["speed"], state["motors"], state["session"]) == (0.0, False, False)
        true = _true(station)
    assert (out / "map.png").exists()
    last = json.loads((out / "collect.jsonl").read_text(encoding="utf-8").splitlines()[-1])
    assert (last["result"], last["taken"], last["fault"]) == ("ended", 0, "interrupted")
    assert math.dist(last["robot"][:2], (true.x, true.y)) < 0.02
    x, y, heading = last["robot"]
    again = f"go on with --resume --start {x:.3f},{y:.3f},{heading:.1f}"
    assert f"interrupted; {again} (where it stands by odometry); 0 of 3 views are there" in said


def test_the_papers_block_is_recognised_from_the_views_that_were_collected(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "views"
    with simulated(seed=1) as station:
        addresses = station.addresses
        options = ["--camera", addresses.camera, "--recognize", "--json"]
        code = main(["collect", addresses.robot, "--tour", "paper", "-o", str(out), *options])
    printed = capsys.readouterr()
    document = json.loads(printed.out)
    assert code == 0, printed.err
    assert (document["taken"], document["fault"]) == (24, None)
    found = recognize_views(
        read_views_from(out, unit="m", progress=None, clock=StepClock()), clock=StepClock()
    )
    assert found.recognition.models == {"box"}
    sizes = sorted(size.value for size in found.recognition.best[0].sizes)
    assert sizes == pytest.approx([0.1524, 0.2032, 0.2540], rel=0.04)


def test_a_camera_of_another_size_is_noticed_before_the_robot_moves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "views"
    calibration = tmp_path / "other.toml"
    calibration.write_text(
        "width = 320\nheight = 240\nfx = 250\nfy = 250\ncx = 159.5\ncy = 119.5\n", encoding="utf-8"
    )
    with simulated() as station:
        addresses = station.addresses
        argv = [
            *("collect", addresses.robot, "--tour", _tour(tmp_path), "-o", str(out)),
            *("--unit", "m", "--camera", addresses.camera, "--camera-file", str(calibration)),
        ]
        assert main(argv) == 3
        assert _true(station) == Pose2()
    assert "pictures are 640 x 480, its calibration is for 320 x 240" in capsys.readouterr().err
    # Nothing was begun: the same command can be given again.
    assert [path.name for path in out.iterdir()] == ["traffic.jsonl"]
