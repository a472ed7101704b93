"""Openings: where one sees through a thing, how large they are, and what is round them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.named_rows import FactRows
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.space.grid import Lattice
from facetlog.perception.space.openings import find_openings, has_room_for_openings
from facetlog.perception.space.space import Space, State
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.types import FloatArray
from tests.perception.space.simulated_scans import eye_at, one_body, scanned

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
    return make_mesh_scene(
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


@pytest.mark.parametrize(
    ("boxes", "known"),
    [((*POSTS, LINTEL), False), ((*POSTS, LINTEL, SILL), True), ((LINTEL,), True)],
    ids=["gate", "frame", "beam"],
)
def test_the_ground_may_close_more_while_up_is_not_known(
    boxes: tuple[Box, ...], known: bool
) -> None:
    for turn in (Rotation.identity(), Rotation.from_euler("xyz", [70.0, 10.0, 33.0], degrees=True)):
        rows = facts(of_boxes(*boxes, turned=turn.as_matrix(), up=False))
        assert bool(rows["openings_known"]) == known


@pytest.mark.parametrize("name", ["desk", "chair", "bench", "shelf"])
@pytest.mark.slow
def test_of_a_scan_from_one_side_they_are_not_but_of_one_from_all_sides(name: str) -> None:
    solid = build(name, {})
    ways = [(azimuth, height) for height in (20.0, 4.0) for azimuth in range(10, 360, 45)]
    scans = [scanned(solid, eye_at(solid, *way)) for way in ways]
    assert not facts(scans[0])["openings_known"]
    every = tuple(sight for scan in scans for sight in scan.sights)
    around = replace(one_body(solid, whole=False), sights=every)
    assert facts(around)["openings_known"] == [("t1",)]
    assert len(facts(around)["opening"]) == len(facts(solid)["opening"])


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.integers(0, 12))
def test_where_no_room_is_left_nothing_that_nobody_saw_makes_another_opening(
    seed: int, unseen: int
) -> None:
    """Random walls with holes and cells that nobody saw, which are then decided at random."""
    rng = np.random.default_rng(seed)
    shape = (1, 12, 12)
    cells = np.full(shape, State.FULL, dtype=np.uint8)
    for _ in range(rng.integers(0, 4)):
        y, z = rng.integers(0, 10, 2)
        cells[0, y : y + rng.integers(1, 5), z : z + rng.integers(1, 5)] = State.FREE
    y, z = rng.integers(0, 12, 2)
    cells[0, y : y + unseen, z : z + rng.integers(1, 4)] = State.UNSEEN
    space = Space(Lattice(0.1, np.eye(3), np.zeros(3), shape), cells, closed=False)
    found = find_openings(space, on_ground=True)
    if has_room_for_openings(space, found, on_ground=True):
        return
    for _ in range(5):
        decided = np.where(rng.random(shape) < 0.5, State.FULL, State.FREE).astype(np.uint8)
        decided = np.where(cells == State.UNSEEN, decided, cells)
        other = Space(space.lattice, decided, closed=False)
        assert len(find_openings(other, on_ground=True)) == len(found)
