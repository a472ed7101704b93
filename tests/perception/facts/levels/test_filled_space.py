"""Space that whole things fill and leave: shares and lengths known from their construction."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.facts.levels.levels import GAP, closed
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Body, Face, Patch, Scene, Vertex
from facetlog.perception.shapes.meshes.mesh_scene import scene_of_mesh
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved
from facetlog.perception.types import FloatArray
from tests.perception.space.simulated_scans import eye_at, scanned

UP = np.array([0.0, 0.0, 1.0])
CELL = 1 / 40
"""Of the longest side: what the grid resolves."""


def whole(scene: Scene) -> Scene:
    """The scene as one body that is known from all sides."""
    faces, edges = tuple(range(len(scene.faces))), tuple(range(len(scene.edges)))
    return replace(scene, bodies=(Body(faces, edges, (), whole=True),))


def values(scene: Scene, functor: str) -> dict[str, float]:
    """The first value of each fact of a kind, by what it is of."""
    return {str(f.args[0]): float(f.args[1]) for f in scene_facts(scene) if f.functor == functor}


def pairs(scene: Scene, functor: str) -> set[tuple[object, ...]]:
    """The arguments of all facts of a kind."""
    return {f.args for f in scene_facts(scene) if f.functor == functor}


def turned(scene: Scene, radians: float, scale: float = 1.0) -> Scene:
    """The scene turned about the vertical, scaled and moved away."""
    c, s = np.cos(radians), np.sin(radians)
    return moved(scene, [[c, -s, 0], [s, c, 0], [0, 0, 1]], (3.0, -2.0, 5.0), scale)


TABLE = whole(build("table", {"width": 0.8, "length": 1.2, "height": 0.74}))
CHAIR = whole(build("chair", {}))


def test_a_table_top_covers_the_plan_with_room_and_sight_beneath() -> None:
    assert values(TABLE, "cover")["f2"] == pytest.approx(1.0)
    assert values(TABLE, "built_over")["f2"] == 0.0
    # the board is 4 cm thick; 4 legs take a little of the plan
    assert values(TABLE, "room_below")["f2"] == pytest.approx(0.70, abs=2 * CELL * 1.2)
    assert values(TABLE, "room_above")["f2"] == 0.0
    assert values(TABLE, "see_through")["f2"] > 0.8
    assert "f2" not in values(TABLE, "rise_side")
    assert values(TABLE, "footprint")["t1"] == pytest.approx(0.96, rel=0.1)


def test_a_back_rises_at_the_rim_of_a_seat_along_all_of_one_side() -> None:
    seat = "f2"
    assert values(CHAIR, "rise_side")[seat] == pytest.approx(1.0, abs=0.2)
    assert values(CHAIR, "rise_off_middle")[seat] == pytest.approx(0.0, abs=2 * CELL)
    assert values(CHAIR, "rise_span")[seat] == pytest.approx(1.0, abs=2 * CELL)
    assert values(CHAIR, "room_above")[seat] > 0.3


@pytest.mark.parametrize(("width", "depth"), [(0.40, 0.48), (0.48, 0.40), (0.45, 0.45)])
@pytest.mark.parametrize("radians", [0.0, 0.4, 2.0])
def test_a_seat_is_as_broad_as_its_front_whichever_side_is_longer(
    width: float, depth: float, radians: float
) -> None:
    chair = turned(whole(build("chair", {"width": width, "depth": depth})), radians)
    assert values(chair, "front_width")["f2"] == pytest.approx(width)
    # what lies in front of the back
    assert values(chair, "front_depth")["f2"] == pytest.approx(depth, abs=0.04)
    assert "front_width" not in {fact.functor for fact in scene_facts(replace(chair, up=None))}


def test_a_cabinet_is_solid_and_a_tray_is_not() -> None:
    assert values(whole(build("cabinet", {})), "solidity")["t1"] > 0.9
    assert values(whole(build("tray", {})), "solidity")["t1"] < 0.5
    assert values(whole(cuboid()), "solidity")["t1"] == 1.0


def test_a_block_that_is_tipped_over_is_as_solid_as_upright() -> None:
    tilt = np.radians(30.0)
    c, s = np.cos(tilt), np.sin(tilt)
    tipped = moved(cuboid(), [[1, 0, 0], [0, c, -s], [0, s, c]], (0.0, 0.0, 0.0), 1.0)
    assert values(whole(tipped), "solidity")["t1"] == pytest.approx(1.0)


def apart(scene: Scene, share: float, sd: float) -> Scene:
    """The scene with faces that have corners of their own, known to `sd`, drawn in."""
    vertices: list[Vertex] = []
    faces: list[Face] = []
    for face in scene.faces:
        corners = scene.points[list(face.outline)]
        middle = corners.mean(axis=0)
        start = len(vertices)
        vertices += [Vertex(middle + share * (c - middle), sd**2 * np.eye(3)) for c in corners]
        faces.append(replace(face, outline=tuple(range(start, len(vertices)))))
    return replace(scene, vertices=tuple(vertices), edges=(), faces=tuple(faces), bodies=())


@pytest.mark.parametrize("up", [True, False])
def test_a_block_whose_faces_miss_each_other_within_their_error_is_solid(up: bool) -> None:
    block = cuboid(1.0, 1.0, 1.0) if up else replace(cuboid(1.0, 1.0, 1.0), up=None)
    known, vague = (whole(apart(block, 0.84, sd)) for sd in (0.001, 0.04))
    assert "t1" not in {f.args[0] for f in scene_facts(known) if f.functor == "whole"}
    assert "t1" in {f.args[0] for f in scene_facts(vague) if f.functor == "whole"}
    assert values(vague, "solidity")["t1"] > 0.9


def top_of(scene: Scene) -> str:
    """The face whose level is highest."""
    return max(values(scene, "elevation").items(), key=lambda item: item[1])[0]


@pytest.mark.parametrize("block", [0.03, 0.3, 0.6])
def test_between_the_ends_of_a_desk_there_is_a_room_as_wide_as_they_leave(block: float) -> None:
    desk = whole(build("desk", {"block": block}))
    left = 1.4 - 2 * 0.05 * 0.7 - 0.03 - block
    assert values(desk, "room_width")[top_of(desk)] == pytest.approx(left, abs=2 * CELL * 1.4)


@settings(max_examples=10)
@given(st.floats(0.0, 6.3), st.floats(0.01, 1000.0))
@pytest.mark.slow
def test_neither_the_frame_nor_the_unit_matters(radians: float, scale: float) -> None:
    after = turned(CHAIR, radians, scale)
    for functor in ("cover", "see_through", "rise_side", "solidity", "built_over"):
        before, now = values(CHAIR, functor), values(after, functor)
        assert now["t1" if functor == "solidity" else "f2"] == pytest.approx(
            before["t1" if functor == "solidity" else "f2"], abs=4 * CELL
        )
    room = values(CHAIR, "room_below")["f2"]
    assert values(after, "room_below")["f2"] / scale == pytest.approx(room, abs=2 * CELL)


def test_where_nobody_noted_what_was_looked_at_the_room_below_a_top_is_unseen() -> None:
    facts = scene_facts(replace(build("table", {}), bodies=()))
    bounds = {f.args[:2]: f.args[2:] for f in facts if f.functor == "unseen_bounds"}
    if_free, if_full = bounds["free_below", "f2"]
    assert float(if_free) > 0.8
    assert float(if_full) < 0.2
    assert not [f for f in facts if f.functor in ("whole", "scanned")]


def looked_at(scene: Scene, *eyes: FloatArray) -> Scene:
    """A scene as pictures from these places show it, with lines of sight to it and the floor."""
    sights = [replace(scanned(scene, eye).sights[0], view=k) for k, eye in enumerate(eyes)]
    views = tuple(f"{k}.png" for k in range(len(eyes)))
    return replace(scene, views=views, sights=tuple(sights), bodies=())


def test_what_one_picture_alone_looked_through_is_not_free_and_what_two_did_is() -> None:
    table = build("table", {})
    eyes = [eye_at(table, azimuth, 25.0) for azimuth in (30.0, 50.0, 70.0)]
    one, three = (values(looked_at(table, *some), "free_below")["f2"] for some in (eyes[:1], eyes))
    assert one < 0.6
    assert three > one + 0.1


def test_only_measures_that_unseen_space_could_change_have_bounds_about_their_value() -> None:
    scan = scanned(TABLE, eye_at(TABLE, 30.0, 40.0))
    bounds = {f.args[:2]: f.args[2:] for f in scene_facts(scan) if f.functor == "unseen_bounds"}
    stated = {(f.functor, f.args[0]): f.args[1:] for f in scene_facts(scan) if len(f.args) == 3}
    assert bounds.keys() < stated.keys()
    assert ("free_below", "f1") in bounds
    for key, ends in bounds.items():
        if_free, if_full = map(float, ends)
        assert if_free != if_full
        assert float(stated[key][0]) == pytest.approx((if_free + if_full) / 2.0)
    free, full = bounds["free_below", "f1"]
    assert free > full
    assert not [f for f in scene_facts(TABLE) if f.functor == "unseen_bounds"]


def ball(count: int = 60000) -> FloatArray:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def test_a_ball_is_a_thing_all_curved_and_half_of_its_box() -> None:
    points = ball()
    hull = tuple(range(400))
    patch = Patch(points, points, np.full(len(points), 4 * np.pi / len(points)), hull)
    scene = Scene(
        "ball",
        vertices=tuple(Vertex(p, 1e-12 * np.eye(3)) for p in points[:400]),
        up=np.array([0.0, 0.0, 1.0]),
        patches=(patch,),
        bodies=(Body(patches=(0,), whole=True),),
    )
    assert values(scene, "curved")["t1"] == 1.0
    # the ball's share of its box is π / 6; cells of its surface count wholly
    assert values(scene, "solidity")["t1"] == pytest.approx(np.pi / 6, abs=0.1)
    assert len(pairs(scene, "thing_size")) == 1


def test_panels_that_lean_a_little_stand_at_the_rim() -> None:
    board = trimesh.creation.box(bounds=[(0.0, 0.0, 0.7), (1.2, 0.7, 0.73)])
    panels = []
    for start, lean in ((0.15, 10.0), (1.02, -10.0)):
        panel = trimesh.creation.box(bounds=[(start, 0.05, 0.0), (start + 0.03, 0.65, 0.7)])
        corners = np.array(panel.vertices)
        corners[:, 0] += np.tan(np.radians(lean)) * (corners[:, 2] - 0.7)
        panels.append(trimesh.Trimesh(corners, panel.faces))
    mesh = trimesh.util.concatenate([board, *panels])
    scene = scene_of_mesh(Mesh.of(mesh.vertices, mesh.faces, name="trestle"), up=UP, metric=True)
    leaning = {f for f, tilt in values(scene, "tilt").items() if 75.0 < tilt < 85.0}
    tops = {f for f, tilt in values(scene, "tilt").items() if tilt < 1.0}
    assert leaning
    assert leaning & {part for part, face in pairs(scene, "at_rim") if face in tops}


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 12))
def test_gaps_of_a_plan_are_closed_as_in_mathematical_morphology(
    seed: int, rows: int, columns: int
) -> None:
    plan = np.random.default_rng(seed).random((rows, columns)) < 0.4
    wide = ndimage.binary_closing(np.pad(plan, GAP + 1), iterations=GAP)
    wanted = wide[GAP + 1 : -GAP - 1, GAP + 1 : -GAP - 1]
    np.testing.assert_array_equal(closed(plan), wanted)
