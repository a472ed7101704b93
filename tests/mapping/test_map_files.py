"""The map's files, read back by others: Pillow and PyYAML by ROS's rule, jsonschema, trimesh."""

import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import shapely
import trimesh
import yaml
from PIL import Image

from facetlog.mapping.floor_grid import Cell, Seen, floor_grid
from facetlog.mapping.map_files import write_map
from facetlog.mapping.map_record import MapRecord
from facetlog.mapping.moved_thing import Moved
from facetlog.mapping.room_map import RoomMap
from facetlog.mapping.same_thing import merged
from facetlog.mapping.sonar_beams import Beam
from facetlog.robot.pose2 import Pose2
from tests.mapping.rooms import box_thing


@pytest.fixture(scope="module")
def room() -> RoomMap:
    things, _ = merged(
        [
            box_thing(1.0, 0.5, 0.4, visit="monday", pose_sd=0.02),
            box_thing(-1.0, -0.5, 0.0, (1.2, 0.6, 0.7), visit="monday", model="table"),
            box_thing(0.0, 1.5, 0.2, (0.2, 0.15, 0.3), visit="tuesday", model=""),
        ]
    )
    way = tuple(Pose2(-2.0 + 0.1 * k, -1.5, 0.0) for k in range(40))
    seen = Seen(
        way=way,
        radius=0.25,
        plans=tuple(thing.best.plan for thing in things),
        beams=(Beam(2.0, -1.5, 1.0, 1.5, echo=False),),
    )
    floor = floor_grid(seen)
    (stood,), _ = merged([box_thing(1.6, 1.2, 0.0, visit="monday", pose_sd=0.02)])
    moved = Moved(stood, things[1])
    return RoomMap(("monday", "tuesday"), things, floor, (way, ()), (), ("a note",), (moved,))


@pytest.fixture
def folder(room: RoomMap, tmp_path: Path) -> Path:
    write_map(room, tmp_path)
    return tmp_path


def _ros_cells(path: Path) -> tuple[np.ndarray, dict[str, object]]:
    """The grid that map_server would publish: -1, 0 or 100, row 0 at the lowest y.

    As nav2_map_server documents it: a pixel is occupied with 1 - shade, trinary by two thresholds.
    """
    said = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert said["mode"] == "trinary"
    assert said["negate"] == 0
    with Image.open(path.parent / said["image"]) as picture:
        assert picture.mode == "L"
        shade = np.asarray(picture, dtype=np.float32) / np.float32(255.0)
    occupied = 1.0 - shade[::-1]
    cells = np.full(shade.shape, -1)
    cells[occupied > said["occupied_thresh"]] = 100
    cells[occupied < said["free_thresh"]] = 0
    return cells, said


def test_ros_reads_the_same_floor_at_the_same_places(room: RoomMap, folder: Path) -> None:
    cells, said = _ros_cells(folder / "map.yaml")
    floor = room.floor
    assert cells.shape == floor.cells.shape
    expected = {Cell.FREE: 0, Cell.OCCUPIED: 100, Cell.UNSEEN: -1, Cell.PASSED: -1}
    for state, value in expected.items():
        assert (floor.cells == state).any()
        assert set(cells[floor.cells == state].tolist()) == {value}
    resolution, (x, y, yaw) = said["resolution"], said["origin"]
    assert yaw == 0.0
    for thing in room.things:
        column = math.floor((thing.best.pose[0] - x) / resolution)
        row = math.floor((thing.best.pose[1] - y) / resolution)
        assert cells[row, column] == 100


def test_its_json_is_as_the_published_schema_has_it(room: RoomMap, folder: Path) -> None:
    found = json.loads((folder / "map.json").read_text(encoding="utf-8"))
    jsonschema.validate(found, MapRecord.model_json_schema())
    assert [thing["model"] for thing in found["things"]] == ["table", "box", None]
    for thing, mapped in zip(found["things"], room.things, strict=True):
        assert np.array(thing["pose"]["covariance"]) == pytest.approx(mapped.best.cov)
    (before,) = found["things"][1]["moved_from"]
    assert (before["visit"], before["pose"]["x"], before["pose"]["y"]) == (
        "monday",
        pytest.approx(1.6),
        pytest.approx(1.2),
    )
    assert before["off"] == pytest.approx(math.hypot(0.6, 0.7))
    assert [thing["moved_from"] for thing in found["things"][::2]] == [[], []]
    rows = found["floor"]["rows"]
    assert (len(rows), len(rows[0])) == room.floor.cells.shape
    free = sum(row.count(".") for row in rows)
    assert found["floor"]["areas"]["free"] == pytest.approx(free * 0.05**2)


def test_its_3d_model_has_each_thing_where_it_is(room: RoomMap, folder: Path) -> None:
    scene = trimesh.load_scene(folder / "map.glb")
    for thing in room.things:
        name = f"{thing.name}_{thing.model}" if thing.model else thing.name
        assert name in scene.graph.nodes
        transform, geometry = scene.graph[name]
        corners = scene.geometry[geometry].vertices @ transform[:3, :3].T + transform[:3, 3]
        # glTF has y up and z towards the viewer: x, z, -y.
        plan = shapely.MultiPoint(np.column_stack([corners[:, 0], -corners[:, 2]])).convex_hull
        assert plan.symmetric_difference(thing.best.plan).area < 1e-6
        assert corners[:, 1].max() == pytest.approx(thing.best.high.value)
    assert {"floor_free", "floor_occupied"} <= set(scene.graph.nodes)
