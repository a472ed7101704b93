"""Holes in the faces of pictures, and openings that are no faces."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.holes_and_spurs import find_differing_places
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import FloatArray, View
from facetlog.robot.rendering.solids import Part, cuboid, joined, placed, printed, slab
from facetlog.robot.rendering.texture import Pattern, Texture
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import Floor, Solid, World
from facetlog.robot.tour import make_ring_poses
from tests.perception.detection.line_front_end.block_rig import CAMERA

UP = np.array([0.0, 0.0, 1.0])
VIEWS = 12
SIZE = (10.0, 8.0, 5.0)
HOLE = (-2.5, -2.0, 2.5, 2.0)
# The side of a cell of which regions are outlined, inches: 2 px.
CELL = 0.17


def with_hole(depth: float, hole: tuple[float, float, float, float] = HOLE) -> Solid:
    """A block with a well in its top; as deep as the block is high, it goes through."""
    length, width, height = SIZE
    x0, y0, x1, y1 = hole
    low, x, y = height - depth, length / 2, width / 2
    parts: list[Part] = [
        slab((-x, -y, low), (length, y0 + y, depth)),
        slab((-x, y1, low), (length, y - y1, depth)),
        slab((-x, y0, low), (x0 + x, y1 - y0, depth), without=("front", "back")),
        slab((x1, y0, low), (x - x1, y1 - y0, depth), without=("front", "back")),
    ]
    if low > 0:
        parts.append(slab((-x, -y, 0.0), (length, width, low)))
    return joined("block with a hole", parts)


def with_block_on_it(height: float) -> Solid:
    top = slab((-2.5, -2.0, SIZE[2]), (5.0, 4.0, height), without=("bottom",))
    return joined("pile", [slab((-5.0, -4.0, 0.0), SIZE), top])


THINGS = {
    "well": lambda: with_hole(2.0),
    "deep": lambda: with_hole(5.0),
    "tray": lambda: with_hole(4.5, (-4.7, -3.7, 4.7, 3.7)),
    "coin": lambda: with_block_on_it(0.2),
    "plain": lambda: cuboid(*SIZE),
    "printed": lambda: printed(cuboid(*SIZE), 3),
}


def views(name: str) -> tuple[View, ...]:
    floor = Floor(0.3, Texture(Pattern.TILES, 5, 45.0, 0.35))
    world = World((placed(THINGS[name](), 0.0, 0.0, yaw=0.4),), floor, np.array([1.0, 0.6, 2.0]))
    poses = make_ring_poses([0.0, 0.0, 3.0], 26.0, (16.0, 22.0), VIEWS)
    return views_of(world, poses, CAMERA, seed=1, noise_sd=3.0)


@cache
def scene(name: str) -> Scene:
    return reconstruct(views(name), name=name, up=UP)


def with_glossy_label(view: View) -> View:
    """The view with a label on the top of the block that is brighter from one side."""
    x0, y0, x1, y1 = HOLE
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    label = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) @ turn.T
    h = np.column_stack([label, np.full(4, SIZE[2]), np.ones(4)]) @ view.projection.T
    mask = np.zeros_like(view.image)
    uv = np.rint(16 * h[:, :2] / h[:, 2:]).astype(np.int32)
    cv2.fillPoly(mask, [uv], 255, cv2.LINE_AA, 4)
    side = float(np.arctan2(view.pose.centre[1], view.pose.centre[0]))
    grey = 80.0 + 90.0 * np.exp(-(((side - 1.0 + np.pi) % (2 * np.pi) - np.pi) ** 2))
    share = mask / 255.0
    return replace(view, image=np.rint(view.image * (1 - share) + grey * share).astype(np.uint8))


def holes(found: Scene) -> list[FloatArray]:
    return [found.points[list(hole)] for face in found.faces for hole in face.holes]


def level_at(found: Scene, height: float) -> list[float]:
    """Heights of the level faces near one."""
    levels = [
        float(found.points[list(face.outline), 2].mean())
        for face in found.faces
        if face.plane.normal @ UP > 0.9
    ]
    return [z for z in levels if abs(z - height) < 0.3]


@pytest.mark.parametrize("name", ["well", "deep"])
@pytest.mark.slow
def test_a_hole_is_found_where_it_is(name: str) -> None:
    (hole,) = holes(scene(name))
    turn = np.array([[np.cos(0.4), np.sin(0.4)], [-np.sin(0.4), np.cos(0.4)]])
    x0, y0, x1, y1 = HOLE
    true = np.array([[x0, y0], [x0, y1], [x1, y1], [x1, y0]])
    at = hole[:, :2] @ turn.T
    apart = np.linalg.norm(at[:, None] - true, axis=2)
    assert len(hole) == 4
    assert apart.min(axis=0).max() < CELL
    np.testing.assert_allclose(hole[:, 2], SIZE[2], atol=CELL)


@pytest.mark.parametrize("name", ["coin", "printed"])
@pytest.mark.slow
def test_what_stands_on_a_face_or_is_printed_on_it_is_no_hole(name: str) -> None:
    assert len(scene(name).faces) >= 5
    assert not holes(scene(name))


@pytest.mark.slow
def test_a_glossy_label_is_no_hole() -> None:
    shown = tuple(map(with_glossy_label, views("plain")))
    found = reconstruct(shown, name="label", up=UP)
    assert level_at(found, SIZE[2])
    assert not holes(found)


@pytest.mark.slow
def test_the_mouth_of_an_open_box_is_no_face() -> None:
    found = scene("tray")
    assert not level_at(found, SIZE[2])
    assert len(found.faces) >= 4
    assert len(level_at(scene("plain"), SIZE[2])) == 1


def test_where_views_differ_more_than_elsewhere() -> None:
    count = np.full(200, 10.0)
    apart = np.zeros(200)
    assert not find_differing_places(count, apart).any()
    apart[::7] = 1.0  # here and there one does
    assert not find_differing_places(count, apart).any()
    apart[40:60] = 6.0
    more = find_differing_places(count, apart)
    assert more[40:60].all()
    assert more.sum() == 20
