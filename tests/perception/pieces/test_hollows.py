"""Hollows: spaces within a thing that are open at the top or at one side."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.types import FloatArray
from tests.perception.pieces.test_openings import UP, Box, facts
from tests.perception.space.simulated_scans import eye_at, scanned

# A shaft of four walls, a metre square within walls of 10 cm, and 60 cm high.
RING: tuple[Box, ...] = (
    ((0.0, 0.0, 0.0), (1.2, 0.1, 0.6)),
    ((0.0, 1.1, 0.0), (1.2, 1.2, 0.6)),
    ((0.0, 0.1, 0.0), (0.1, 1.1, 0.6)),
    ((1.1, 0.1, 0.0), (1.2, 1.1, 0.6)),
)
FLOOR: Box = ((0.1, 0.1, 0.0), (1.1, 1.1, 0.1))
ROOF: tuple[Box, ...] = (
    ((0.0, 0.55, 0.6), (0.1, 0.65, 1.4)),
    ((1.1, 0.55, 0.6), (1.2, 0.65, 1.4)),
    ((0.0, 0.0, 1.4), (1.2, 1.2, 1.5)),
)
LID: Box = ((0.0, 0.0, 0.6), (1.2, 1.2, 0.7))
# The first wall with a hole of 30 cm.
FRONT: tuple[Box, ...] = (
    ((0.0, 0.0, 0.0), (0.45, 0.1, 0.6)),
    ((0.75, 0.0, 0.0), (1.2, 0.1, 0.6)),
    ((0.45, 0.0, 0.0), (0.75, 0.1, 0.15)),
    ((0.45, 0.0, 0.45), (0.75, 0.1, 0.6)),
)
# A crate with walls of a cell, without the one in front.
THREE: tuple[Box, ...] = (
    ((0.0, 0.0, 0.0), (0.4, 0.3, 0.01)),
    ((0.0, 0.29, 0.01), (0.4, 0.3, 0.25)),
    ((0.0, 0.0, 0.01), (0.01, 0.29, 0.25)),
    ((0.39, 0.0, 0.01), (0.4, 0.29, 0.25)),
)
TURNED = Rotation.from_euler("z", 33.0, degrees=True).as_matrix()
MIRRORED = np.diag([-1.0, 1.0, 1.0])


def of_boxes(*boxes: Box, by: FloatArray | None = None, up: bool = True) -> Scene:
    """Return a mesh of boxes, each from one corner to the opposite one, changed by a matrix."""
    import trimesh

    mesh = trimesh.util.concatenate([trimesh.creation.box(bounds=np.array(box)) for box in boxes])
    change = np.eye(3) if by is None else by
    faces = mesh.faces if np.linalg.det(change) > 0 else mesh.faces[:, ::-1]
    return make_mesh_scene(
        Mesh.of(mesh.vertices @ change.T, faces, name="boxes"), up=UP if up else None, metric=True
    )


@pytest.mark.parametrize(
    ("boxes", "depth"),
    [(RING, 0.6), ((*RING, FLOOR), 0.5), ((*RING, *ROOF), 0.6)],
    ids=["ring", "box", "well"],
)
@pytest.mark.parametrize("by", [np.eye(3), TURNED, MIRRORED, 0.3 * np.eye(3)])
def test_what_is_open_at_the_top_is_one_in_whatever_frame(
    boxes: tuple[Box, ...], depth: float, by: FloatArray
) -> None:
    rows = facts(of_boxes(*boxes, by=by))
    scale = float(abs(np.linalg.det(by))) ** (1.0 / 3.0)
    ((name, side, deep, sd, mouth, _),) = rows["hollow_mouth"]
    assert side == "top"
    assert deep == pytest.approx(depth * scale, abs=4 * sd)
    assert mouth > 0.8
    ((_, length, width, _),) = [row for row in rows["opening_size"] if row[0] == name]
    assert (length, width) == pytest.approx((scale, scale), abs=4 * sd)
    ((_, _, top, _),) = [row for row in rows["opening_heights"] if row[0] == name]
    assert top == pytest.approx(0.6 * scale, abs=4 * sd)
    assert rows["hollows_known"] == [("t1",)]


def test_a_hole_in_front_opens_a_closed_box_to_that_side() -> None:
    for by in (np.eye(3), TURNED, MIRRORED):
        rows = facts(of_boxes(*FRONT, *RING[1:], FLOOR, LID, by=by))
        ((_, side, _, _, mouth, _),) = rows["hollow_mouth"]
        assert side == "side"
        assert mouth < 0.3


@pytest.mark.parametrize(
    "boxes",
    [(*RING, LID), (LID,), ROOF, (*RING, ((0.1, 0.1, 0.0), (1.1, 1.1, 0.6))), THREE],
    ids=["upside down", "board", "gate", "filled", "three walls"],
)
def test_what_is_covered_or_filled_has_none(boxes: tuple[Box, ...]) -> None:
    rows = facts(of_boxes(*boxes))
    assert not rows["hollow_of"]
    assert rows["hollows_known"] == [("t1",)]


@pytest.mark.parametrize(
    ("name", "count"),
    [("cuboid", 0), ("tray", 1), ("table", 0), ("chair", 0), ("stairs", 0), ("frame", 0)],
)
def test_furniture_has_hollows_where_a_person_says_so(name: str, count: int) -> None:
    assert len(facts(build(name, {}))["hollow_of"]) == count


def test_what_lies_behind_two_posts_is_none() -> None:
    posts: tuple[Box, ...] = (
        ((0.0, 1.9, 0.0), (0.1, 2.0, 0.3)),
        ((0.9, 1.9, 0.0), (1.0, 2.0, 0.3)),
    )
    bed: tuple[Box, ...] = (((0.0, 0.0, 0.0), (1.0, 0.1, 0.8)), ((0.0, 0.1, 0.3), (1.0, 2.0, 0.5)))
    assert not facts(of_boxes(*bed, *posts))["hollow_of"]


def test_a_scan_from_above_finds_what_it_saw_but_knows_of_no_more() -> None:
    solid = build("tray", {})
    rows = facts(scanned(solid, eye_at(solid, 20.0, 60.0)))
    assert [row[1] for row in rows["hollow_mouth"]] == ["top"]
    assert not rows["hollows_known"]


def test_none_is_known_without_up() -> None:
    rows = facts(of_boxes(*RING, up=False))
    assert not rows["hollow_of"]
    assert not rows["hollows_known"]
