"""Which pieces the bodies of a mesh's scene get, and what facts say of them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.pieces.exact.find_pieces import find_solid_pieces
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.scene_file import decode_scene, encode_scene
from tests.perception.shapes.meshes.made_meshes import block, scene_of, table, together


def arrays(made: trimesh.Trimesh) -> tuple[np.ndarray, np.ndarray]:
    return np.asarray(made.vertices), np.asarray(made.faces)


def wheel(x: float, y: float) -> trimesh.Trimesh:
    ends = [(x, y, 0.05), (x, y + 0.03, 0.05)]
    return trimesh.creation.cylinder(0.05, segment=ends, sections=32)


def turned(made: trimesh.Trimesh, turn: Rotation) -> Scene:
    moved = trimesh.Trimesh(turn.apply(made.vertices), made.faces, process=False)
    return scene_of(moved, up=turn.apply((0.0, 0.0, 1.0)))


def test_each_body_gets_the_pieces_that_have_its_faces() -> None:
    scene = scene_of(together(table(), block((3.0, 0.0, 0.0), (3.5, 0.4, 0.3))))
    assert [len(body.solids.pieces) for body in scene.bodies if body.solids] == [5, 1]
    for body in scene.bodies:
        assert body.solids is not None
        owned = [face for piece in body.solids.pieces for face in piece.faces]
        assert sorted(owned) == sorted(body.faces)


def test_a_single_layer_is_a_board_without_thickness() -> None:
    corners = [(0, 0, 0.7), (1.2, 0, 0.7), (1.2, 0.8, 0.7), (0, 0.8, 0.7)]
    sheet = trimesh.Trimesh(corners, [(0, 1, 2), (0, 2, 3)])
    legs = [block((x, y, 0.0), (x + 0.1, y + 0.1, 0.7)) for x in (0.0, 1.1) for y in (0.0, 0.7)]
    for parts in ((sheet, *legs), (sheet, sheet.copy().apply_translation((0, 0, 0.03)), *legs)):
        (body,) = scene_of(together(*parts)).bodies
        assert body.solids is not None
        assert len(body.solids.pieces) == 5
        assert len(body.solids.joins) == 4
        assert body.solids.explained == pytest.approx(1.0)


@pytest.mark.parametrize("turn", [Rotation.identity(), Rotation.random(random_state=3)])
def test_facts_of_pieces_are_exact_in_any_frame(turn: Rotation) -> None:
    kinds = {"piece_size", "explained", "carries", "piece_on_ground"}
    rows = fact_rows(turned(table(overlap=0.01), turn), kinds)
    sizes = sorted(row[1:4] for row in rows["piece_size"])
    assert np.array(sizes[-1]) == pytest.approx([1.2, 0.8, 0.04], abs=1e-5)
    assert np.array(sizes[:4]) == pytest.approx(np.tile([0.71, 0.06, 0.06], (4, 1)), abs=1e-5)
    assert rows["explained"] == [("t1", pytest.approx(1.0))]
    assert len(rows["carries"]) == len(rows["piece_on_ground"]) == 4


@pytest.mark.parametrize("turn", [Rotation.identity(), Rotation.random(random_state=5)])
def test_legs_carry_the_top_over_a_gap_narrower_than_a_cell(turn: Rotation) -> None:
    scene = turned(table(overlap=-0.01), turn)
    assert len(scene.bodies) == 1
    rows = fact_rows(scene, {"carries", "joins"})
    assert len(rows["carries"]) == 4
    assert len(rows["joins"]) == 8


def test_a_wheel_is_round_whatever_its_flat_sides() -> None:
    wheels = [wheel(x, y) for x in (0.1, 0.9) for y in (0.02, 0.55)]
    scene = scene_of(together(block((0, 0, 0.1), (1.0, 0.6, 0.14)), *wheels))
    rows = fact_rows(scene, {"piece_round"})["piece_round"]
    assert sorted(share > 0.9 for _, share in rows) == [False, *[True] * 4]


def test_what_stands_on_a_board_on_the_ground_stands_on_the_ground() -> None:
    lower, upper = (block((0, 0, z), (1.0, 0.1, z + 0.03)) for z in (0.0, 0.13))
    blocks = [block((x, 0, 0.03), (x + 0.14, 0.1, 0.13)) for x in (0.0, 0.43, 0.86)]
    rows = fact_rows(scene_of(together(lower, *blocks, upper)), {"piece_on_ground"})
    assert len(rows["piece_on_ground"]) == 4


def test_a_scene_file_keeps_solids() -> None:
    scene = scene_of(table())
    kinds = {"piece_size", "piece_face", "joins", "explained", "piece_round"}
    assert fact_rows(decode_scene(encode_scene(scene)), kinds) == fact_rows(scene, kinds)


def test_what_faces_of_a_whole_scene_enclose_is_cut_though_hidden_ends_have_none() -> None:
    cabinet = build("cabinet", {"foot": 0.05})
    rows = fact_rows(cabinet, {"piece_size", "piece_face", "explained", "carries"})
    assert rows["explained"] == [("t1", pytest.approx(1.0))]
    assert [round(row[3], 3) for row in rows["piece_size"]] == [0.4, 0.05]
    assert len(rows["piece_face"]) == len(cabinet.faces)
    assert rows["carries"] == [("p2", "p1")]


def remove_sides(made: trimesh.Trimesh, way: tuple[float, float, float]) -> trimesh.Trimesh:
    """Return a block without the side that faces this way."""
    return trimesh.Trimesh(made.vertices, made.faces[made.face_normals @ way < 0.5])


def test_ends_that_nobody_sees_are_closed_and_open_boxes_are_not() -> None:
    top = block((0.0, 0.0, 0.7), (1.2, 0.8, 0.74))
    foot = block((0.4, 0.2, 0.5), (0.8, 0.6, 0.7))
    bar = block((0.1, 0.1, 0.0), (0.2, 0.2, 0.9))
    down, up = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
    for parts in (
        (top, remove_sides(foot, up)),  # it lies on another
        (remove_sides(bar, up),),
        (remove_sides(remove_sides(bar, up), down),),
        (remove_sides(top, down),),
        (remove_sides(remove_sides(bar, (1.0, 0.0, 0.0)), down),),  # in a corner of others
    ):
        found = find_solid_pieces(*arrays(together(*parts)))
        assert (len(found.pieces), found.explained) == (len(parts), pytest.approx(1.0))
    for side in (up, down):
        crate = remove_sides(foot, side)
        assert not find_solid_pieces(*arrays(crate))
        closed = find_solid_pieces(*arrays(crate), up=np.array(side) * -1.0)
        assert len(closed.pieces) == 1


@pytest.mark.parametrize(("gap", "pairs"), [((0.0, 0.0, 0.0, 1.2, 0.8, 0.7), 12), (None, 0)])
def test_pieces_that_volume_in_no_piece_lies_against_may_touch(gap: object, pairs: int) -> None:
    scene = scene_of(table())
    (body,) = scene.bodies
    assert body.solids is not None
    solids = replace(body.solids, explained=0.9, gaps=() if gap is None else (gap,))
    rows = fact_rows(replace(scene, bodies=(replace(body, solids=solids),)), {"may_join", "joins"})
    assert len(rows["joins"]) == 8
    assert len(rows["may_join"]) == pairs
