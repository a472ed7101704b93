"""Pieces as one looks at them: a node each in glTF, boxes in the views, a haze of unseen space."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from facetlog.errors import InputError
from facetlog.perception.facts.pieces.piece_facts import shown_pieces
from facetlog.perception.pieces.draw_pieces import draw_pieces
from facetlog.perception.pieces.piece_meshes import export_pieces
from facetlog.perception.pieces.shown_pieces import (
    COLOURS,
    SLENDER,
    THIN,
    Kind,
    ShownPieces,
    compute_box_corners,
)
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.types import Camera, Pose, View
from facetlog.rules import __file__ as rules
from tests.perception.space.simulated_scans import eye_at, scanned

NOTHING = ShownPieces((), ())


def _glb(scene: Scene) -> trimesh.Scene:
    data = export_pieces(scene, shown_pieces(scene))
    loaded = trimesh.load(io.BytesIO(data), file_type="glb")
    assert isinstance(loaded, trimesh.Scene)
    return loaded


def _view(scene: Scene) -> View:
    """A camera that looks at the scene from above one corner."""
    middle = scene.points.mean(axis=0)
    size = float(np.ptp(scene.points, axis=0).max())
    centre = middle + 2.0 * size * np.array([1.0, -1.2, 0.8])
    forward = (middle - centre) / np.linalg.norm(middle - centre)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.column_stack([right, np.cross(forward, right), forward])
    image = np.full((240, 320), 100, dtype=np.uint8)
    return View("a", image, Camera(320, 240, 480, 480, 159.5, 119.5), Pose(rotation, centre))


def test_kinds_are_bounded_as_in_the_vocabulary() -> None:
    text = (Path(rules).parent / "vocabulary.pl").read_text(encoding="utf-8")
    bounds = dict(re.findall(r"^tolerance\((thin|slender), +([\d.]+)\)", text, re.MULTILINE))
    assert {name: float(value) for name, value in bounds.items()} == {
        "thin": THIN,
        "slender": SLENDER,
    }


def test_a_mesh_of_pieces_has_a_closed_node_for_each_in_the_colour_of_its_kind() -> None:
    table = build("table", {})
    graph = _glb(table)
    shown = {each.name: each for each in shown_pieces(table).pieces}
    assert set(graph.graph.nodes_geometry) == set(shown)
    for name, each in shown.items():
        _, geometry = graph.graph[name]
        mesh = graph.geometry[geometry]
        sizes = each.piece.length.value, each.piece.width.value, each.piece.thickness.value
        assert mesh.is_volume
        assert mesh.volume == pytest.approx(np.prod(sizes), rel=1e-4)
        assert tuple(mesh.visual.main_color[:3]) == COLOURS[each.piece.kind]


def test_what_nobody_saw_is_a_haze_round_as_many_cells() -> None:
    block = build("chair", {})
    scan = scanned(block, eye_at(block, 30.0, 20.0))
    shown = shown_pieces(scan)
    graph = _glb(scan)
    (space,) = shown.spaces
    haze = graph.geometry[graph.graph["unseen1"][1]]
    assert haze.volume == pytest.approx(space.unseen * space.lattice.volume, rel=1e-3), (
        "its sides look outwards"
    )
    assert haze.visual.vertex_colors[:, 3].max() < 60


def test_a_scene_without_pieces_has_no_mesh_of_them() -> None:
    scene = build("cuboid", {})
    with pytest.raises(InputError, match="has no pieces"):
        export_pieces(scene, NOTHING)


def test_each_piece_is_drawn_where_its_box_is_seen() -> None:
    scene = build("chair", {})
    view, shown = _view(scene), shown_pieces(scene)
    drawn = draw_pieces(view, shown, "a chair")
    empty = draw_pieces(view, NOTHING, "a chair")
    assert drawn.shape == empty.shape
    for each in shown.pieces:
        if each.piece.kind is Kind.BAR and each.piece.low < 0.1:
            continue  # a leg may be hidden
        corners = compute_box_corners(each.piece)
        ahead = (corners - view.pose.centre) @ view.pose.rotation
        u, v = (480 * ahead[:, :2] / ahead[:, 2:] + (159.5, 119.5)).mean(axis=0).round().astype(int)
        near = drawn[v - 3 : v + 4, u - 3 : u + 4] != empty[v - 3 : v + 4, u - 3 : u + 4]
        assert near.any(axis=2).mean() > 0.5
    assert (drawn[:5, :5] == empty[:5, :5]).all()
