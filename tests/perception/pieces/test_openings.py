"""Openings: where one sees through a thing, how large they are, and what is round them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.named_rows import FactRows
from facetlog.perception.facts.piece_kinds import PIECE_KINDS
from facetlog.perception.reading.shape_files.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import scene_of_mesh
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.types import FloatArray

KINDS = {kind.functor for kind in PIECE_KINDS} | {"enclosed", "face", "elevation"}
UP = np.array([0.0, 0.0, 1.0])
Box = tuple[tuple[float, float, float], tuple[float, float, float]]
# width, depth and height of a gate, and how broad its posts and its lintel are
WIDTH, DEPTH, HEIGHT, POST = 1.2, 0.1, 2.0, 0.1
POSTS: tuple[Box, ...] = (
    ((0.0, 0.0, 0.0), (POST, DEPTH, HEIGHT)),
    ((WIDTH - POST, 0.0, 0.0), (WIDTH, DEPTH, HEIGHT)),
)
LINTEL: Box = ((POST, 0.0, HEIGHT - POST), (WIDTH - POST, DEPTH, HEIGHT))
SILL: Box = ((POST, 0.0, 0.0), (WIDTH - POST, DEPTH, POST))


def facts(scene: Scene) -> FactRows:
    return fact_rows(scene, KINDS)


def of_boxes(*boxes: Box, turned: FloatArray | None = None, up: bool = True) -> Scene:
    """A mesh of boxes, each from one corner to the opposite one."""
    import trimesh

    solids = [trimesh.creation.box(bounds=np.array(box)) for box in boxes]
    mesh = trimesh.util.concatenate(solids)
    points = mesh.vertices if turned is None else mesh.vertices @ turned.T
    return scene_of_mesh(
        Mesh.of(points, mesh.faces, name="boxes"), up=UP if up else None, metric=True
    )


@pytest.mark.parametrize(
    ("name", "count"),
    [("cuboid", 0), ("tray", 0), ("stairs", 0), ("table", 2), ("bench", 1), ("shelf", 4)],
)
def test_one_sees_through_furniture_where_a_person_says_so(name: str, count: int) -> None:
    assert len(facts(build(name, {}))["opening"]) == count


def test_a_gate_has_one_opening_that_the_ground_closes() -> None:
    rows = facts(of_boxes(*POSTS, LINTEL))
    ((_, length, width, sd),) = rows["opening_size"]
    assert length == pytest.approx(HEIGHT - POST, abs=3 * sd)
    assert width == pytest.approx(WIDTH - 2 * POST, abs=3 * sd)
    ((_, low, high, _),) = rows["opening_heights"]
    assert (low, high) == pytest.approx((0.0, HEIGHT - POST), abs=3 * sd)
    assert len(rows["frames"]) == 3


def test_posts_without_a_lintel_have_none() -> None:
    assert not facts(of_boxes(*POSTS, SILL))["opening"]


def test_a_gate_of_which_up_is_not_known_has_none_but_a_frame_has() -> None:
    assert not facts(of_boxes(*POSTS, LINTEL, up=False))["opening"]
    rows = facts(of_boxes(*POSTS, LINTEL, SILL, up=False))
    assert len(rows["opening"]) == 1
    assert not rows["opening_heights"]


@pytest.mark.parametrize("degrees", [0.0, 25.0, 60.0])
def test_a_frame_that_leans_has_its_opening_in_its_two_faces(degrees: float) -> None:
    turned = Rotation.from_euler("x", degrees, degrees=True).as_matrix()
    rows = facts(of_boxes(*POSTS, LINTEL, SILL, turned=turned))
    ((name, length, width, sd),) = rows["opening_size"]
    assert (length, width) == pytest.approx((HEIGHT - 2 * POST, WIDTH - 2 * POST), abs=3 * sd)
    assert [opening for opening, _ in rows["opening_in"]] == [name, name]


def test_the_size_hangs_on_no_world_frame() -> None:
    turned = Rotation.random(random_state=4).as_matrix()
    scene = of_boxes(*POSTS, LINTEL, turned=turned, up=False)
    scene = replace(scene, up=turned @ UP)
    ((_, length, width, sd),) = facts(scene)["opening_size"]
    assert (length, width) == pytest.approx((HEIGHT - POST, WIDTH - 2 * POST), abs=3 * sd)


def test_a_lamp_hangs_from_its_beam_and_the_beam_from_nothing() -> None:
    lamp: Box = ((0.5, 0.0, 0.9), (0.7, DEPTH, 1.1))
    cord: Box = ((0.58, 0.03, 1.1), (0.64, 0.07, HEIGHT - POST))
    rows = facts(of_boxes(*POSTS, LINTEL, lamp, cord))
    named = {round(low, 2): name for name, low, _, _ in rows["piece_heights"] if low > 0.1}
    cord_name = next(name for low, name in named.items() if abs(low - 1.1) < 0.06)
    beam = next(name for low, name in named.items() if abs(low - (HEIGHT - POST)) < 0.06)
    lamp_name = next(name for low, name in named.items() if abs(low - 0.9) < 0.06)
    assert set(rows["hangs_from"]) == {(cord_name, beam), (lamp_name, cord_name)}


@pytest.mark.parametrize(("name", "share"), [("tray", 1.0), ("table", 0.0)])
def test_the_floor_of_a_tray_is_enclosed_and_a_table_top_is_not(name: str, share: float) -> None:
    rows = facts(build(name, {}))
    floor = {face: each for face, each, _ in rows["enclosed"]}
    heights = {face: height for face, height, _ in rows["elevation"]}
    assert any(heights[face] > 0 and each == share for face, each in floor.items())


def test_the_seat_of_a_chair_is_enclosed_on_one_side_of_four() -> None:
    rows = facts(build("chair", {}))
    heights = {face: height for face, height, _ in rows["elevation"]}
    seat = [each for face, each, _ in rows["enclosed"] if abs(heights[face] - 0.45) < 0.001]
    # and at the ends of the two sides beside it
    assert all(0.25 <= each <= 0.4 for each in seat)
    assert seat
