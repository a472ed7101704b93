"""The space round things whose solids are known: full, free, assumed and unseen cells."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from facetlog.perception.facts.all_facts import LEVEL_KINDS, fact_rows
from facetlog.perception.facts.levels.levels import Bounded
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene, SightLines
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.space.grid import Lattice
from facetlog.perception.space.space import Space, State
from facetlog.perception.space.thing_space import ThingSurface, thing_space
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import moved, stick_table
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import box_points
from tests.perception.space.simulated_scans import eye_at, one_body, scanned

UP = np.array([0.0, 0.0, 1.0])
NONE = np.zeros((0, 3))
MEASURES = {"footprint", "solidity", *LEVEL_KINDS, "unseen_bounds"}


def space(scene: Scene, *, all_round: bool = False) -> Space:
    """The space of the scene's faces as one thing on the ground."""
    faces = SceneMemo.of(scene).table.faces
    surface = ThingSurface(faces, scene.points, NONE, NONE, all_round=all_round)
    found = thing_space(surface, UP, sights=scene.sights)
    assert found is not None
    return found


def shares(found: Space) -> dict[State, float]:
    return {state: found.share(state) for state in State}


def enclosed_share(*boxes: tuple[tuple[float, float, float], tuple[float, float, float]]) -> float:
    """The full share of the space of a mesh that is made of boxes, by their corners."""
    parts = [trimesh.creation.box(bounds=bounds) for bounds in boxes]
    return solidity(trimesh.util.concatenate(parts))


def solidity(mesh: trimesh.Trimesh) -> float:
    scene = make_mesh_scene(Mesh.of(mesh.vertices, mesh.faces), up=UP)
    thing, share, _ = fact_rows(scene, {"solidity"})["solidity"][0]
    assert thing == "t1"  # the one with most surface
    return float(share)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("cuboid", 0.99, 1.0),
        ("cabinet", 0.95, 1.0),
        ("table", 0.05, 0.2),
        ("chair", 0.05, 0.25),
        ("tray", 0.1, 0.5),
        ("shelf", 0.1, 0.4),
    ],
)
def test_what_is_closed_is_full_and_what_is_open_is_not(name: str, low: float, high: float) -> None:
    found = space(build(name, {}), all_round=True)
    assert found.known
    assert found.unseen == found.share(State.ASSUMED) == 0.0
    assert low <= found.share(State.FULL) <= high


@given(
    cells=arrays(
        np.uint8, st.tuples(*[st.integers(1, 6)] * 3), elements=st.sampled_from(list(State))
    ),
    axis=st.integers(0, 2),
    sense=st.sampled_from([1, -1]),
)
def test_of_what_is_unseen_that_shows_which_nothing_full_hides(
    cells: NDArray[np.uint8], axis: int, sense: int
) -> None:
    lattice = Lattice(1.0, np.eye(3), np.zeros(3), cells.shape)  # type: ignore[arg-type]
    found = Space(lattice, cells, closed=False)
    shown = 0
    for row in np.moveaxis(cells, axis, 2).reshape(-1, cells.shape[axis]):
        for state in row[::-sense]:
            if state > State.UNSEEN:
                break
            shown += state == State.UNSEEN
    unseen = int((cells == State.UNSEEN).sum())
    assert found.measure_visible_unseen(axis, sense) == (shown / unseen if unseen else 0.0)


# walls of a bin 40 x 40 x 50 cm, 1 cm thick; its lid; and aprons of a table 1.2 x .8 m
WALLS = (
    ((0.0, 0.0, 0.0), (0.4, 0.4, 0.01)),
    ((0.0, 0.0, 0.0), (0.01, 0.4, 0.5)),
    ((0.39, 0.0, 0.0), (0.4, 0.4, 0.5)),
    ((0.0, 0.0, 0.0), (0.4, 0.01, 0.5)),
)
BACK = ((0.0, 0.39, 0.0), (0.4, 0.4, 0.5))
LID = ((0.0, 0.0, 0.49), (0.4, 0.4, 0.5))


@pytest.mark.slow
def test_a_bin_is_empty_without_a_lid_and_full_with_one() -> None:
    assert enclosed_share(*WALLS, BACK) < 0.3
    assert enclosed_share(*WALLS, BACK, LID) > 0.95


@pytest.mark.parametrize("eye", [(1.4, 0.9, 1.3), (0.5, 1.2, 2.0)])
def test_of_an_empty_shell_round_the_sensor_nobody_knows_whether_it_is_a_thing(
    eye: tuple[float, float, float],
) -> None:
    shell = box_points((3.0, 2.0, 2.5), 6000)
    empty = solidity_of(shell, eye)
    assert empty.if_free < 0.3
    assert empty.if_full > 0.95


def test_of_a_room_the_block_in_it_is_the_thing() -> None:
    shell = box_points((3.0, 2.0, 2.5), 6000)
    block = box_points((0.5, 0.4, 0.9), 900, sides=("-x", "+x", "-y", "+y", "+z"))
    found = solidity_of(np.concatenate([shell, block + np.array([0.6, 0.5, 0.0])]), (1.4, 0.9, 1.3))
    assert min(found.if_free, found.if_full) > 0.9


def solidity_of(points: FloatArray, eye: tuple[float, float, float]) -> Bounded:
    """That of the largest thing of a cloud that was seen from one place."""
    seen_from = np.tile(np.array(eye), (len(points), 1))
    memo = SceneMemo.of(make_cloud_scene(Cloud.of(points, seen_from=seen_from), up=UP))
    return max(memo.filled.values(), key=lambda filled: filled.box).solidity


@pytest.mark.parametrize(
    ("faces", "eyes", "views", "is_assumed"),
    [
        ("sides", "above", 4, False),  # a crate: its rim was found, and views look into it
        ("sides", "above", 2, True),  # too few to say that a lid would have been found
        ("sides", "level", 4, True),  # nobody looked at what may be a lid
        ("all but one side", "above", 4, True),  # a side is missing, and no rim is round it
    ],
)
def test_behind_an_opening_that_views_look_into_nothing_is_assumed(
    faces: str, eyes: str, views: int, is_assumed: bool
) -> None:
    block = build("cuboid", {})
    size = block.points.max(axis=0)
    every = SceneMemo.of(block).table.faces
    upright = [face for face in every if abs(float(face.normal @ UP)) < 0.5]
    level = [face for face in every if float(face.normal @ UP) > 0.5]
    shown = upright if faces == "sides" else [*upright[1:], *level]
    surface = ThingSurface(tuple(shown), block.points, NONE, NONE)
    height = 3.0 if eyes == "above" else 0.5
    turns = np.linspace(0.0, 2.0 * np.pi, views, endpoint=False)
    away = size * [[0.5, 0.5, 9.0]]
    sights = [
        SightLines(size * [3.0 * np.cos(turn), 3.0 * np.sin(turn), height], away) for turn in turns
    ]
    found = thing_space(surface, UP, sights=sights, places=2)
    assert found is not None
    assert (found.share(State.ASSUMED) > 0.5) == is_assumed
    assert (found.unseen > 0.5) != is_assumed


def measured(scene: Scene) -> dict[tuple[str, str], tuple[float, float, float]]:
    """Low, high and sd of each measure of space, by its name and the place of what it is of."""
    rows = fact_rows(scene, MEASURES)
    bounds = {(name, of): (low, high) for name, of, low, high in rows["unseen_bounds"]}
    places = {
        f"f{face.index + 1}": f"{face.middle.round(2).tolist()}"
        for face in SceneMemo.of(scene).table.faces
        if face.normal[2] > 0.9
    }
    return {
        (name, places.get(str(of), str(of))): (*bounds.get((name, of), (value, value)), sd)
        for name, found in rows.items()
        if name != "unseen_bounds"
        for of, value, sd in found
        if of == "t1" or of in places
    }


@pytest.mark.parametrize("name", ["cuboid", "cabinet", "table", "desk", "chair", "bench", "shelf"])
@pytest.mark.slow
def test_bounds_of_a_scan_contain_what_is_true_of_the_whole(name: str) -> None:
    solid = build(name, {})
    truth = measured(one_body(solid, whole=True))
    cell = 1.0 / 40
    compared = 0
    for azimuth in (20.0, 110.0, 200.0, 290.0):
        for height in (15.0, 40.0):
            scan = measured(scanned(solid, eye_at(solid, azimuth, height)))
            for key, (if_free, if_full, _) in scan.items():
                low, high = sorted((if_free, if_full))
                # the back of a chair hides a strip of the seat, whose face is taken to go on
                if key in truth and not key[0].startswith("rise"):
                    true = truth[key][0]
                    slack = 4.0 * cell * max(1.0, 2.0 * abs(true))
                    assert low - slack <= true <= high + slack, (
                        azimuth,
                        height,
                        key,
                        low,
                        true,
                        high,
                    )
                    compared += 1
    assert compared >= 16


@settings(max_examples=8)
@given(st.floats(0.0, 6.3), st.floats(0.1, 100.0))
def test_neither_turning_the_world_nor_its_unit_changes_its_space(
    turn: float, scale: float
) -> None:
    table = build("table", {})
    scan = scanned(table, eye_at(table, 35.0, 30.0))
    c, s = np.cos(turn), np.sin(turn)
    other = moved(scan, [[c, -s, 0], [s, c, 0], [0, 0, 1]], (3.0, -2.0, 5.0), scale)
    before, after = shares(space(scan)), shares(space(other))
    for state in State:
        assert after[state] == pytest.approx(before[state], abs=0.05)


def test_an_edge_that_bounds_no_face_is_full_and_hides_nothing() -> None:
    table = SceneMemo.of(stick_table()).table
    legs = table.points[[[i, 8 + i] for i in range(4)]]
    bare, legged = (
        thing_space(ThingSurface(table.faces, table.points, NONE, NONE, lines), UP)
        for lines in (legs[:0], legs)
    )
    assert bare is not None
    assert legged is not None
    foot = legged.cells[:, :, 0]
    assert (foot == State.FULL).sum() == 4
    other = legged.cells != bare.cells
    assert (legged.cells[other] == State.FULL).all()
    assert (other.sum(axis=2) > 0).sum() == 4


def test_a_place_without_extent_has_no_space() -> None:
    surface = ThingSurface((), np.zeros((3, 3)), NONE, NONE)
    assert thing_space(surface, UP) is None
