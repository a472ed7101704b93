"""Drawings show what is in front, and only that."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from facetlog.perception.reading.read_views import read_views
from facetlog.perception.scene import Edge, Evidence, Face, Plane, Scene, Vertex
from facetlog.perception.surfaces.drawing.draw import draw_scene
from facetlog.perception.surfaces.drawing.hidden_surface import hidden_surface
from facetlog.perception.surfaces.drawing.lettering import ColourImage
from facetlog.perception.types import Camera, FloatArray, Observation, Pose, View

LOOPS = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
EDGES = tuple(
    sorted({(min(a, b), max(a, b)) for r in LOOPS for a, b in zip(r, (*r[1:], r[0]), strict=True)})
)
UNIT_CUBE = np.array(
    [[x, y, z] for z in (0.0, 1.0) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))]
)


def _scene(points: FloatArray, *, implied: bool = False, views: tuple[str, ...] = ("a",)) -> Scene:
    faces = []
    for loop in LOOPS:
        normal = np.cross(points[loop[1]] - points[loop[0]], points[loop[2]] - points[loop[1]])
        normal /= np.linalg.norm(normal)
        offset = -float(normal @ points[loop[0]])
        faces.append(Face(loop, Plane(normal, offset, np.eye(4) * 1e-6)))
    evidence = Evidence.IMPLIED if implied else Evidence.MEASURED
    seen = (Observation(0, [20.0, 20.0], np.eye(2)),)
    return Scene(
        "cube",
        views,
        tuple(Vertex(p, np.eye(3) * 1e-4, seen if i == 0 else ()) for i, p in enumerate(points)),
        tuple(Edge(a, b, evidence=evidence) for a, b in EDGES),
        tuple(faces),
    )


def _view(centre: tuple[float, float, float], width: int = 320) -> View:
    """A camera that looks at the middle of the unit cube."""
    forward = np.array([0.5, 0.5, 0.5]) - centre
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.column_stack([right, np.cross(forward, right), forward])
    height = width * 3 // 4
    camera = Camera(width, height, width, width, (width - 1) / 2, (height - 1) / 2)
    image = np.full((height, width), 90, dtype=np.uint8)
    return View("a", image, camera, Pose(rotation, np.array(centre)))


def _green(image: ColourImage) -> int:
    """Pixels of the edges' green, which no tint of a face on mid-grey reaches."""
    blue, green, red = np.moveaxis(image.astype(int), -1, 0)
    return int((green - np.maximum(blue, red) > 100).sum())


def test_faces_behind_others_are_hidden() -> None:
    surface = hidden_surface(_view((4.0, 3.0, 2.5)), _scene(UNIT_CUBE))
    assert set(np.unique(surface.face)) == {-1, 1, 3, 4}  # top, x = 1 and y = 1


def test_a_picture_on_its_side_is_drawn_upright() -> None:
    scene = replace(_scene(UNIT_CUBE), up=np.array([0.0, 0.0, 1.0]))
    view = _view((4.0, 3.0, 2.5))
    right, down, forward = view.pose.rotation.T
    lying = replace(view, pose=Pose(np.column_stack([down, -right, forward]), view.pose.centre))
    as_held, upright = draw_scene(replace(view, name="a"), scene), draw_scene(lying, scene)
    assert upright.shape[1] == view.image.shape[0]
    assert as_held.shape[1] == view.image.shape[1]
    # The cube's edges are as long, but where the narrower picture cuts them.
    assert _green(upright) == pytest.approx(_green(as_held), rel=0.1)


def test_a_hidden_edge_is_not_drawn() -> None:
    near, far = UNIT_CUBE, UNIT_CUBE * 0.4 + np.array([-3.0, 0.3, 0.3])  # the second is behind
    view = _view((4.0, 0.51, 0.52))
    alone = _green(draw_scene(view, _scene(far)))
    assert alone > 50
    both = _scene(near)
    loose = Scene("s", ("a",), (*both.vertices, *_scene(far).vertices), (Edge(8, 14),), both.faces)
    assert _green(draw_scene(view, loose)) == _green(
        draw_scene(view, Scene("s", ("a",), both.vertices, (), both.faces))
    )


def test_implied_edges_are_dashed() -> None:
    view = _view((4.0, 3.0, 2.5), 640)
    solid = _green(draw_scene(view, _scene(UNIT_CUBE)))
    dashed = _green(draw_scene(view, _scene(UNIT_CUBE, implied=True)))
    assert 0.3 * solid < dashed < 0.75 * solid


@pytest.mark.parametrize(
    "centre", [(0.5, 0.4, 0.6), (1.0, 0.5, 0.51), (1.0001, 0.5, 0.51), (0.9, -0.2, 0.5)]
)
def test_a_camera_inside_or_touching_the_thing_can_be_drawn(
    centre: tuple[float, float, float],
) -> None:
    assert draw_scene(_view(centre), _scene(UNIT_CUBE)).any()


def test_a_real_cube_is_tinted_where_the_picture_shows_it() -> None:
    folder = Path(os.environ.get("FACETLOG_DATA", "absent")) / "images" / "visp_cube"
    if not folder.is_dir():
        pytest.skip("FACETLOG_DATA has no images/visp_cube")
    truth = json.loads((folder / "ground_truth.json").read_text())
    points = np.array(truth["vertices"])
    view = read_views(folder).views[0]
    scene = _scene(points * [-1, 1, 1] if np.linalg.det(points[[1, 3, 4]]) < 0 else points)
    faces = set(np.unique(hidden_surface(view, scene).face)) - {-1}
    assert len(faces) == 3
