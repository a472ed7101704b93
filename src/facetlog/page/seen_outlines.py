"""The faces and edges of a scene as a view shows them, without what is hidden, and its pieces."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.affinity import affine_transform
from shapely.geometry.base import BaseGeometry

from facetlog.page.inner_point import inner_point
from facetlog.page.model_view import loose_edges
from facetlog.perception.pieces.shown_pieces import SIDES, Piece, ShownPieces, compute_box_corners
from facetlog.perception.polygons import (
    find_difference,
    find_intersection,
    find_union,
    make_polygon,
)
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.drawing.frustum import Frustum
from facetlog.perception.surfaces.drawing.hidden_surface import (
    DEPTH_TOLERANCE,
    is_facing_camera,
    project_rings,
)
from facetlog.perception.types import FloatArray, View

NO_PIECES = ShownPieces((), ())
LEAST_PX = 12.0  # area of a face, in pixels as shown: less is a sliver
LEAST_LENGTH_PX = 4.0  # likewise of an edge
# A name is written where it has room for half its height on all sides.
NAME_ROOM_PX = 6.0


@dataclass(frozen=True, eq=False, slots=True)
class SeenOutline:
    """Visible outline of something: an SVG path, and the name's place, if it has room.

    Its `kind` is face, edge, rim (an edge that bounds a face), or piece
    and its kind.
    """

    kind: str
    name: str
    path: str
    at: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class _Drawn:
    # A face's polygon or an edge's line in pixels. `nearness` (3,): 1 / depth at pixel (u, v) is
    # its product with (u, v, 1), for of what is flat or straight that is linear in a picture.
    kind: str
    name: str
    shape: BaseGeometry
    nearness: FloatArray
    is_shown: bool

    def is_before(self, other: "_Drawn", at: FloatArray) -> bool:
        pixel = np.array([*at, 1.0])
        return bool(pixel @ self.nearness > (1.0 + DEPTH_TOLERANCE) * (pixel @ other.nearness))


def seen_outlines(
    view: View,
    scene: Scene,
    shrink: float,
    pieces: ShownPieces = NO_PIECES,
    named: Collection[str] = (),
) -> Iterator[SeenOutline]:
    """Yield the faces that turn to the camera and the edges that bound none, as far as they are
    seen.

    Of edges that do those that are `named`; pieces by the outline of their boxes, whatever is
    before them. Pixels are those of a picture `shrink` times as large.
    """
    faces = list(_faces(view, scene))
    tree = shapely.STRtree([face.shape for face in faces])
    border = shapely.box(-0.5, -0.5, view.camera.width - 0.5, view.camera.height - 0.5)
    loose = frozenset(loose_edges(scene))
    rims = (k for k in range(len(scene.edges)) if k not in loose and f"e{k + 1}" in named)
    edges = (*_edges(view, scene, "edge", sorted(loose)), *_edges(view, scene, "rim", rims))
    for drawn in (*(face for face in faces if face.is_shown), *edges):
        seen = find_intersection(drawn.shape, border)
        for index in tree.query(drawn.shape, predicate="intersects"):
            if faces[index] is not drawn:
                seen = find_difference(seen, _hidden_by(faces[index], drawn))
        yield from _outline(drawn.kind, drawn.name, _as_shown(seen, shrink))
    for piece in pieces.pieces:
        box = find_intersection(_box(view, piece.piece), border)
        yield from _outline(f"piece {piece.piece.kind}", piece.name, _as_shown(box, shrink))


def _as_shown(shape: BaseGeometry, shrink: float) -> BaseGeometry:
    return affine_transform(shape, (shrink, 0.0, 0.0, shrink, shrink / 2, shrink / 2))


def _hidden_by(other: _Drawn, drawn: _Drawn) -> BaseGeometry:
    """Return where another face is before it: flat things that do not cross keep their order in
    each part of the picture where both are.
    """
    both = shapely.get_parts(find_intersection(other.shape, drawn.shape))
    hidden = [part for part in both if other.is_before(drawn, _xy(shapely.point_on_surface(part)))]
    return find_union(hidden)


def _outline(kind: str, name: str, shown: BaseGeometry) -> Iterator[SeenOutline]:
    parts = [
        part
        for part in shapely.get_parts(shown)
        if part.area >= LEAST_PX
        or (part.geom_type == "LineString" and part.length >= LEAST_LENGTH_PX)
    ]
    if not parts:
        return
    path = " ".join(_path(part) for part in parts)
    largest = max(parts, key=lambda part: (part.area, part.length))
    if largest.geom_type == "LineString":
        at = _xy(largest.interpolate(0.5, normalized=True))
        yield SeenOutline(kind, name, path, (float(at[0]), float(at[1])))
        return
    inner = inner_point(largest)
    roomy = largest.boundary.distance(shapely.Point(inner)) >= NAME_ROOM_PX
    yield SeenOutline(kind, name, path, (float(inner[0]), float(inner[1])) if roomy else None)


def _path(part: BaseGeometry) -> str:
    if part.geom_type == "LineString":
        return _run(shapely.get_coordinates(part))
    rings = shapely.get_rings(part)
    return " ".join(f"{_run(shapely.get_coordinates(ring)[:-1])} Z" for ring in rings)


def _run(corners: FloatArray) -> str:
    return "M" + " L".join(f"{u:.1f},{v:.1f}" for u, v in corners)


def _faces(view: View, scene: Scene) -> Iterator[_Drawn]:
    for number, face in enumerate(scene.faces):
        rings = [ring for ring in project_rings(view, scene, face) if len(ring) >= 3]
        above = float(face.plane.distance(view.pose.centre))
        if not rings or above == 0.0:
            continue
        # By the even-odd rule: outline and holes may be cut at the picture's border.
        shape = make_polygon(rings[0])
        for hole in rings[1:]:
            shape = find_difference(shape, make_polygon(hole))
        # A ray c + z R (x, y, 1) meets n · p + d = 0 at 1 / z = -n · R (x, y, 1) / (n · c + d).
        of_ray = -(view.pose.rotation.T @ face.plane.normal) / above
        yield _Drawn(
            "face", f"f{number + 1}", shape, _of_pixel(view, of_ray), is_facing_camera(face, view)
        )


def _of_pixel(view: View, of_ray: FloatArray) -> FloatArray:
    camera = view.camera
    x, y, one = of_ray
    u, v = x / camera.fx, y / camera.fy
    return np.array([u, v, one - u * camera.cx - v * camera.cy])


def _edges(view: View, scene: Scene, kind: str, indices: Iterable[int]) -> Iterator[_Drawn]:
    frustum = Frustum(view.camera, view.pose)
    for index in indices:
        edge = scene.edges[index]
        ends = frustum.segment(scene.points[edge.start], scene.points[edge.end])
        if ends is None:
            continue
        pixels = frustum.pixels(ends)
        run = pixels[1] - pixels[0]
        if not run.any():
            continue
        start, end = 1.0 / ends[:, 2]
        slope = (end - start) * run / (run @ run)
        nearness = np.array([*slope, start - slope @ pixels[0]])
        yield _Drawn(kind, f"e{index + 1}", shapely.LineString(pixels), nearness, True)


def _box(view: View, piece: Piece) -> BaseGeometry:
    """Return the outline of a piece's box, as far as it is before the camera."""
    frustum, corners = Frustum(view.camera, view.pose), compute_box_corners(piece)
    edges = [(a, b) for side in SIDES for a, b in zip(side, (*side[1:], side[0]), strict=True)]
    ends = [frustum.segment(corners[a], corners[b]) for a, b in edges if a < b]
    pixels = [frustum.pixels(each) for each in ends if each is not None]
    return shapely.MultiPoint(np.concatenate([np.zeros((0, 2)), *pixels])).convex_hull


def _xy(point: BaseGeometry) -> FloatArray:
    xy: FloatArray = shapely.get_coordinates(point)[0]
    return xy
