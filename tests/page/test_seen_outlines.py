"""A picture shows of each face and edge what nothing hides, by its name."""

import re

import numpy as np
import pytest
import shapely

from facetlog.page.seen_outlines import SeenOutline, seen_outlines
from facetlog.perception.scene import Edge, Face, Plane, Scene, Vertex
from facetlog.perception.types import Camera, FloatArray, Pose, View

CAMERA = Camera(200, 200, 100.0, 100.0, 99.5, 99.5)
FROM_FRONT = View("front.png", np.zeros((200, 200), np.uint8), CAMERA, Pose(np.eye(3), np.zeros(3)))


def _scene(
    *squares: tuple[float, float, float, float], edges: tuple[FloatArray, ...] = ()
) -> Scene:
    """Squares (x, y, depth, half a side) that face the camera, and edges by their ends."""
    around = np.array([(-1, -1, 0), (-1, 1, 0), (1, 1, 0), (1, -1, 0)])
    corners = [np.array([x, y, z]) + half * around for x, y, z, half in squares]
    points = np.concatenate([*corners, *edges])
    first = 4 * len(squares)
    return Scene(
        "squares",
        vertices=tuple(Vertex(point, np.zeros((3, 3))) for point in points),
        edges=tuple(Edge(first + 2 * k, first + 2 * k + 1) for k in range(len(edges))),
        faces=tuple(
            Face(
                (4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3),
                Plane(np.array([0.0, 0.0, -1.0]), square[2], np.zeros((4, 4))),
            )
            for k, square in enumerate(squares)
        ),
    )


def _seen(scene: Scene) -> dict[str, SeenOutline]:
    return {outline.name: outline for outline in seen_outlines(FROM_FRONT, scene, 1.0)}


def _shape(outline: SeenOutline) -> shapely.Geometry:
    runs = [
        [tuple(map(float, xy.split(","))) for xy in re.findall(r"[\d.-]+,[\d.-]+", run)]
        for run in outline.path.split("M")[1:]
    ]
    if "Z" not in outline.path:
        return shapely.union_all([shapely.LineString(run) for run in runs])
    # By the even-odd rule, as SVG fills it.
    shape: shapely.Geometry = shapely.Polygon()
    for run in runs:
        shape = shapely.symmetric_difference(shape, shapely.Polygon(run))
    return shape


def test_a_face_ends_where_another_is_before_it() -> None:
    seen = _seen(_scene((0.0, 0.0, 2.0, 1.0), (0.5, 0.0, 1.0, 0.25)))
    behind, before = _shape(seen["f1"]), _shape(seen["f2"])
    assert before.area == pytest.approx(50.0**2, rel=0.01)
    assert behind.area == pytest.approx(100.0**2 - 25.0 * 50.0, rel=0.01)
    assert behind.intersection(before).area == pytest.approx(0.0, abs=1.0)


def test_what_a_face_has_in_its_middle_is_a_hole_and_its_name_is_not_there() -> None:
    seen = _seen(_scene((0.0, 0.0, 2.0, 1.0), (0.0, 0.0, 1.0, 0.25)))
    at = seen["f1"].at
    assert at is not None
    assert _shape(seen["f1"]).contains(shapely.Point(at))
    assert _shape(seen["f1"]).area == pytest.approx(100.0**2 - 50.0**2, rel=0.01)


def test_what_is_hidden_has_neither_outline_nor_name() -> None:
    assert set(_seen(_scene((0.0, 0.0, 2.0, 0.5), (0.0, 0.0, 1.0, 0.5)))) == {"f2"}


def test_a_loose_edge_is_drawn_as_far_as_it_is_seen() -> None:
    ends = np.array([(-1.0, 0.0, 2.0), (1.0, 0.0, 2.0)])
    scene = _scene((0.5, 0.0, 1.0, 0.5), edges=(ends,))
    edge = _shape(_seen(scene)["e1"])
    assert edge.length == pytest.approx(50.0, abs=0.2)
    assert edge.bounds[2] == pytest.approx(100.0, abs=0.2)
