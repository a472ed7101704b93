"""`facetlog collect --explore --area`: its options, and an area of the simulated robot's world."""

import json
import math
import threading
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from facetlog.cli import main
from facetlog.commands.collect_area import recognised_in
from facetlog.mapping.floor_grid import Seen, floor_grid
from facetlog.mapping.room_map import RoomMap
from facetlog.mapping.same_thing import merged
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.drawing.map_picture import FOUND, Floor, Mapped
from facetlog.robot.collecting.record import read_log, read_record
from facetlog.robot.simulator.station import Station
from facetlog.robot.simulator.world_file import SceneSetup, SolidSetup, read_world
from facetlog.robot.tour import tour_camera
from tests.mapping.rooms import box_thing
from tests.recordings.test_mcap_recording import messages

AREA = (-1.0, -1.6, 4.2, 3.6)
NOBODY = ["collect", "tcp:127.0.0.1:1", "-o"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--area", "0,0,3,3"], "or --explore --area X,Y,W,H"),
        (["--tour", "paper", "--area", "0,0,3,3"], "--area goes with --explore"),
        (["--explore", "--area", "0,0,3"], "X,Y,WIDTH,HEIGHT (metres)"),
        (["--explore", "--area", "0,0,3,0"], "its width and height are above 0"),
        (["--explore", "--area", "1,1,3,3"], "does not hold the robot, which stands at 0.00, 0.00"),
        (["--explore", "--area", "0,0,3,3", "--target", "1,1,0"], "--target does not go with"),
        (["--explore", "--area", "0,0,3,3", "--until", "box >= 60%"], "--until does not go with"),
        (["--explore", "--area", "0,0,3,3", "--keep-out", "0.5"], "--keep-out of an area is X,Y,"),
        (["--explore", "--area", "0,0,3,3", "--max-views", "2"], "a face needs 3 views"),
        (["--explore", "--area", "0,0,3,3", "--dry-run"], "no collection: --dry-run goes"),
        (["--explore", "--area", "0,0,3,3", "--resume"], "to go on with: leave out --resume"),
    ],
)
def test_options_that_say_no_area_are_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main([*NOBODY, str(tmp_path / "out"), *options]) == 2
    told = capsys.readouterr().err.strip()
    assert message in told
    assert "\n" not in told


def test_the_map_of_the_way_shows_what_has_a_name_where_it_stands(tmp_path: Path) -> None:
    box, nameless = box_thing(1.4, 0.2, 0.3), box_thing(3.0, 0.2, model="")
    things, _ = merged([box, nameless])
    room = RoomMap(("area",), things, floor_grid(Seen(), area=AREA), ((),), ())
    (found,) = recognised_in(room)
    assert found.said == "m1 box 80%"
    (rim,) = found.outlines
    assert rim[:-1].mean(axis=0) == pytest.approx([1.4, 0.2, 0.0])
    Mapped((), (), Floor((), None, 0.25, area=AREA), Optics(tour_camera())).draw(tmp_path, [found])
    image = cv2.imread(str(tmp_path / "map.png"))
    assert image is not None
    assert (np.abs(image.astype(int) - FOUND) < 20).all(axis=2).sum() > 300


@pytest.mark.slow
def test_an_area_is_explored_and_mapped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    box = SolidSetup("box", (0.5, 0.4, 0.35), at=(1.4, 0.2))
    setup = read_world(None)
    setup = replace(
        setup,
        scene=SceneSetup("empty", solid=(box,)),
        robot=replace(setup.robot, model="p3dx"),
    )
    out = tmp_path / "views"
    options = ["--explore", f"--area={','.join(map(str, AREA))}", "-o", str(out)]
    local = "127.0.0.1:0"
    with Station(setup, listen=local, pty=False, camera=local) as station:
        thread = threading.Thread(target=station.serve)
        thread.start()
        try:
            addresses = station.addresses
            robot = ["collect", addresses.robot, "--camera", addresses.camera]
            recorded = ["--recognize", "--mcap", str(tmp_path / "area.mcap")]
            code = main([*robot, *options, *recorded, "--speed", "0.5", "--max-views", "5"])
        finally:
            station.stop()
            thread.join()
    told = capsys.readouterr()
    assert code == 1, told.err
    assert "there are 5 views, as many as --max-views allows; 1 thing found" in told.out
    assert "place 1 at" in told.err
    _, taken = read_record(out)
    assert len(taken) == 5
    for view in taken:
        assert math.dist((view.robot.x, view.robot.y), box.at) > 0.25 + 0.25
    chosen = [line for line in read_log(out) if line.get("result") == "chosen"]
    assert {line["looks_at"] for line in chosen} == {0, 1}
    mapped = json.loads((out / "map" / "map.json").read_text(encoding="utf-8"))
    (thing,) = mapped["things"]
    assert math.dist((thing["pose"]["x"], thing["pose"]["y"]), box.at) < 0.15
    assert (out / "map" / "map.png").is_file()
    way = cv2.imread(str(out / "map.png"))
    assert way is not None
    named = thing["model"] is not None
    assert (np.abs(way.astype(int) - FOUND) < 20).all(axis=2).any() == named
    low, rows = mapped["floor"]["origin"], mapped["floor"]["rows"]
    assert low == pytest.approx(AREA[:2])
    assert len(rows) * mapped["floor"]["resolution"] == pytest.approx(AREA[3])
    recording = messages(tmp_path / "area.mcap")
    assert len(recording["/camera/image/compressed"]) == len(taken)
    *_, (_, faces) = recording["/facetlog/faces"]
    assert {marker.ns for marker in faces.markers if marker.points} == {"place 1 faces"}

    # No robot answers there: none is asked. What was looked at is not looked at again.
    code = main([*NOBODY, str(out), *options[:2], "--dry-run", "--json"])
    line = json.loads(capsys.readouterr().out)
    assert line["result"] == ("chosen" if code == 0 else "explored")
    # Its views are none of one target.
    assert main([*NOBODY, str(out), "--explore", "--dry-run"]) == 2
    assert "holds an explored area: give --area=" in capsys.readouterr().err
    # Another area is another collection.
    assert main([*NOBODY, str(out), "--explore", "--area", "-9,-9,20,20", "--dry-run"]) == 2
    assert "was not collected in this --area: give --area=" in capsys.readouterr().err
