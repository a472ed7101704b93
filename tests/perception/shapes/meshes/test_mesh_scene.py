"""Meshes of known solids as scenes: faces, edges, objects, and that no frame or order matters."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.facts.most_faces import MOST_FACES
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import MOST_OBJECTS, make_mesh_scene
from facetlog.perception.surfaces.contacts import find_side_contacts
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.scene_file import decode_scene, encode_scene
from facetlog.perception.types import FloatArray
from tests.perception.shapes.meshes.made_meshes import block, scene_of, table

UP = (0.0, 0.0, 1.0)


def subdivided_box(times: int) -> trimesh.Trimesh:
    made = block((0, 0, 0), (3, 2, 1))
    for _ in range(times):
        made = made.subdivide()
    return made


def areas(scene: Scene) -> FloatArray:
    return np.sort([face.area for face in FaceTable.of(scene).faces])


def bends_of(scene: Scene) -> list[float]:
    turns: list[float] = np.rad2deg(find_side_contacts(FaceTable.of(scene)).turn).tolist()
    return turns


@pytest.mark.parametrize("subdivided", [0, 3])
def test_a_cuboid_has_six_faces_eight_vertices_and_twelve_convex_edges(subdivided: int) -> None:
    scene = scene_of(subdivided_box(subdivided))
    assert (len(scene.faces), len(scene.vertices), len(scene.edges)) == (6, 8, 12)
    assert bends_of(scene) == pytest.approx([90.0] * 12)
    assert areas(scene) == pytest.approx([2, 2, 3, 3, 6, 6])
    assert scene.bodies[0].faces == (0, 1, 2, 3, 4, 5)
    assert scene.bodies[0].whole
    assert not scene.patches


@pytest.mark.slow
def test_five_boxes_that_touch_or_overlap_are_a_table() -> None:
    with open_knowledge_base() as base:
        for overlap in (0.0, 0.02, 0.04):
            scene = scene_of(table(overlap=overlap))
            facts = [fact.row for fact in scene_facts(scene)]
            # the legs' tops are within the table, and no faces
            assert (len(scene.bodies), len(scene.faces)) == (1, 26)
            assert judge_scene(base, "s", facts).models == {"table"}


@pytest.mark.parametrize("spoilt", ["inside out", "random winding", "doubled", "unwelded"])
def test_a_cuboid_stays_one_however_its_triangles_are_kept(spoilt: str) -> None:
    made = subdivided_box(2)
    vertices, triangles = np.array(made.vertices), np.array(made.faces)
    rng = np.random.default_rng(1)
    if spoilt == "inside out":
        triangles = triangles[:, ::-1]
    elif spoilt == "random winding":
        turn = rng.random(len(triangles)) < 0.5
        triangles = np.where(turn[:, None], triangles[:, ::-1], triangles)
    elif spoilt == "doubled":
        triangles = np.concatenate((triangles, triangles[:, ::-1], triangles))
    else:
        vertices = vertices[triangles].reshape(-1, 3)
        vertices = vertices + rng.normal(size=vertices.shape) * 1e-8
        triangles = np.arange(len(vertices)).reshape(-1, 3)
    scene = make_mesh_scene(Mesh.of(vertices, triangles))
    assert areas(scene) == pytest.approx([2, 2, 3, 3, 6, 6], rel=1e-5)
    assert bends_of(scene) == pytest.approx([90.0] * 12, abs=1e-3)


def test_a_ball_has_no_face_and_a_patch_of_its_area() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4)
    scene = scene_of(ball)
    assert not scene.faces
    assert scene.patches[0].areas.sum() == pytest.approx(ball.area)
    outwards = (scene.patches[0].normals * scene.patches[0].points).sum(axis=1)
    assert (outwards > 0.9).all()


def test_a_frame_scale_and_order_do_not_matter() -> None:
    made = table(overlap=0.02)
    rotation = Rotation.random(random_state=3).as_matrix()
    rng = np.random.default_rng(0)
    order = rng.permutation(len(made.faces))
    turned = made.vertices @ rotation.T * 1000.0 + 1e5
    before = scene_of(made)
    after = make_mesh_scene(Mesh.of(turned, made.faces[order]), up=rotation @ np.array(UP))
    assert areas(after) / 1e6 == pytest.approx(areas(before), rel=1e-4)
    assert sorted(bends_of(after)) == pytest.approx(sorted(bends_of(before)), abs=0.01)


def test_without_solid_parts_a_scene_is_the_same_but_for_these() -> None:
    mesh = Mesh.of(table(overlap=0.02).vertices, table(overlap=0.02).faces)
    whole, without = (make_mesh_scene(mesh, up=UP, solid_parts=each) for each in (True, False))
    assert [scene.bodies[0].solids is None for scene in (whole, without)] == [False, True]
    assert scene_facts(whole) == scene_facts(without)


def sheets(sides: tuple[float, float, float], *left_out: int) -> Scene:
    """A block of single-layer walls without some of them: 0 and 1 are its bottom and its top."""
    made = block((0, 0, 0), sides)
    keep = np.ones(len(made.faces), dtype=bool)
    for side in left_out:
        keep &= made.face_normals[:, 2] != (-1.0, 1.0)[side]
    return make_mesh_scene(Mesh.of(made.vertices, made.faces[keep][:, ::-1]), up=np.array(UP))


def upwards(scene: Scene) -> list[float]:
    return sorted(round(float(face.plane.normal[2]), 6) + 0.0 for face in scene.faces)


def test_a_tray_of_single_sheets_has_an_inside_too() -> None:
    assert upwards(sheets((3.0, 2.0, 0.3), 1)) == [-1, *[0] * 8, 1]


def test_a_single_sheet_has_an_upper_and_a_lower_face() -> None:
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    scene = make_mesh_scene(Mesh.of(corners, [(0, 1, 2), (0, 2, 3)]), up=np.array(UP))
    assert upwards(scene) == [-1, 1]
    assert areas(scene) == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("sections", [8, 12, 16, 48, 200])
def test_a_round_leg_is_flat_at_its_ends_alone(sections: int) -> None:
    made = trimesh.creation.cylinder(0.05, 1.0, sections=sections)
    scene = scene_of(made)
    assert upwards(scene) == [-1, 1]
    ends = 2 * float(areas(scene)[0])
    assert scene.patches[0].areas.sum() == pytest.approx(made.area - ends, rel=0.01)


def grid(bow: float) -> Mesh:
    """A square of 30 x 30 corners, two wide, that rises by `bow` at two sides."""
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(-1, 1, 30), np.linspace(-1, 1, 30)))
    corners = np.arange(900).reshape(30, 30)
    a, b, c, d = (
        corners[i : 29 + i, j : 29 + j].ravel() for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))
    )
    triangles = np.concatenate((np.column_stack([a, b, c]), np.column_stack([a, c, d])))
    return Mesh.of(np.column_stack([x, y, bow * x * x]), triangles)


def test_a_bowed_seat_is_a_face_whose_plane_is_less_sure() -> None:
    flat, bowed = (make_mesh_scene(grid(bow), up=np.array(UP)) for bow in (0.0, 0.06))
    assert upwards(flat) == upwards(bowed) == [-1, 1]
    tilt_sds = [
        np.sqrt(np.linalg.eigvalsh(s.faces[0].plane.cov[:3, :3])[-1]) for s in (flat, bowed)
    ]
    rms = 0.06 * np.sqrt(4 / 45)  # of x² over -1 .. 1
    # over a variance of 1/3 each way, by four places
    assert tilt_sds[1] == pytest.approx(rms / np.sqrt(4 / 3), rel=0.05)
    assert tilt_sds[0] < 1e-4


def test_a_face_in_pieces_that_touch_without_shared_corners_is_one() -> None:
    left = [(0, 0, 0), (1, 0, 0), (1, 2, 0), (0, 2, 0)]
    right = [(1, -0.5, 0), (2, -0.5, 0), (2, 1.3, 0), (1, 1.3, 0)]
    quads = [(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)]
    scene = make_mesh_scene(Mesh.of([*left, *right], quads))
    assert areas(scene) == pytest.approx([3.8, 3.8], rel=1e-3)


def test_a_frame_has_a_face_with_a_hole() -> None:
    outer = [(0, 0, 0), (4, 0, 0), (4, 3, 0), (0, 3, 0)]
    inner = [(1, 1, 0), (3, 1, 0), (3, 2, 0), (1, 2, 0)]
    sides = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    triangles = [(a, b, c) for a, b, c, _ in sides] + [(a, c, d) for a, _, c, d in sides]
    scene = make_mesh_scene(Mesh.of([*outer, *inner], triangles))
    assert [(len(f.outline), len(f.holes[0])) for f in scene.faces] == [(4, 4), (4, 4)]
    assert areas(scene) == pytest.approx([10.0, 10.0])


def slivers_on_a_box(count: int, size: float, seed: int = 0) -> Mesh:
    """Triangles 2 cm long and 0.1 mm wide in the sides of a box; no two share a corner."""
    rng = np.random.default_rng(seed)
    box = trimesh.creation.box((size, 0.7 * size, 0.5 * size))
    points, sides = trimesh.sample.sample_surface(box, count, seed=seed)
    normals = box.face_normals[sides]
    along = np.cross(normals, rng.normal(size=(count, 3)))
    along /= np.linalg.norm(along, axis=1)[:, None]
    tips = points + 0.01 * along + 1e-4 * np.cross(normals, along)
    corners = np.stack([points, points + 0.02 * along, tips], axis=1).reshape(-1, 3)
    return Mesh.of(corners, np.arange(3 * count).reshape(-1, 3), name="slivers.ply")


def test_the_scene_of_loose_slivers_can_be_read_and_says_that_they_enclose_nothing() -> None:
    # of this one two faces would have holes across their outlines
    scene = make_mesh_scene(slivers_on_a_box(400, 0.08), up=(0, 0, 1), metric=True)
    assert any(face.holes for face in scene.faces)
    assert len(decode_scene(encode_scene(scene)).faces) == len(scene.faces)
    assert not any(body.whole for body in scene.bodies)
    (said,) = scene.warnings
    assert said.startswith("400 of 400 triangles, 100.0% of the surface, share no corner")


def test_more_loose_objects_than_are_judged_are_refused() -> None:
    with pytest.raises(
        InputError, match=r"^slivers.ply: falls into 2,\d{3} objects, at most 2,000"
    ):
        make_mesh_scene(slivers_on_a_box(2_200, 4.0))
    assert MOST_OBJECTS == MOST_FACES
