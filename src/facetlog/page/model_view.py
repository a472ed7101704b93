"""The scene in 3-D for the page: what was found, how sure it is, and from where it was seen.

What shows it is trimesh's page with three.js inside. A script beside it (model_view.js) hears
from the page which nodes to show and which to light up, writes their names where they stand, and
says which one was clicked.
"""

from collections.abc import Collection, Iterator, Sequence
from importlib.resources import files

import numpy as np
import trimesh
from numpy.typing import NDArray

from facetlog.page.inner_point import inner_point
from facetlog.page.uncertainty import add_ellipsoids
from facetlog.perception.pieces.piece_meshes import add_pieces
from facetlog.perception.pieces.shown_pieces import ShownPieces
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.face_table import flat_faces
from facetlog.perception.surfaces.mesh_export import add_faces, render_viewer_page
from facetlog.perception.types import FloatArray, View

# A camera is drawn as a pyramid so long, of the scene's diagonal, as wide and high as it sees.
CAMERA_SHARE = 0.06
CAMERA_COLOUR = (90, 110, 130, 255)
# Edges that bound no face are tubes so thick, of the scene's diagonal.
TUBE_SHARE = 0.004
TUBE_COLOUR = (165, 140, 240, 255)
TUBE_SIDES = 8
# The base's corners 1 to 4 run round, the pinhole is corner 0.
_SIDES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [1, 3, 2], [1, 4, 3]])


def model_view(
    scene: Scene,
    pieces: ShownPieces,
    views: Sequence[View],
    named: Collection[str] = (),
) -> str:
    """Return a page of its own; "" without a face.

    Its nodes are f1, … and p1, …; e1, … of the edges that bound no face, and of the `named` ones
    that do as `rim`; v1, … of the vertices as ellipsoids; unseen1, … and view1, ….
    """
    graph = trimesh.Scene()
    if not add_faces(graph, scene):
        return ""
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    _place_face_names(graph, scene)
    add_pieces(graph, pieces)
    loose = frozenset(loose_edges(scene))
    for index, edge in enumerate(scene.edges):
        name, ends = f"e{index + 1}", scene.points[[edge.start, edge.end]]
        if index in loose or (name in named and np.ptp(ends, axis=0).any()):
            tube = _tube(ends, TUBE_SHARE * size)
            tube.metadata["rim"] = index not in loose
            graph.add_geometry(tube, node_name=name)
    add_ellipsoids(graph, scene)
    for number, view in enumerate(views, start=1):
        graph.add_geometry(_camera(view, CAMERA_SHARE * size), node_name=f"view{number}")
    script = files(__package__).joinpath("model_view.js").read_text(encoding="utf-8")
    return render_viewer_page(graph, scene.up, look_at=scene.points, script=script)


def loose_edges(scene: Scene) -> Iterator[int]:
    """Yield the edges (their indices) that have a length and bound no face, such as legs."""
    rings = [ring for face in scene.faces for ring in (face.outline, *face.holes)]
    bounding = {
        frozenset(pair) for ring in rings for pair in zip(ring, (*ring[1:], ring[0]), strict=True)
    }
    for index, edge in enumerate(scene.edges):
        ends = scene.points[[edge.start, edge.end]]
        if frozenset((edge.start, edge.end)) not in bounding and np.ptp(ends, axis=0).any():
            yield index


def _place_face_names(graph: trimesh.Scene, scene: Scene) -> None:
    """Place the names of faces well inside them; the script reads that as `userData.at`."""
    for face in flat_faces(scene):
        mesh = graph.geometry.get(f"f{face.index + 1}")
        if mesh is not None:
            mesh.metadata["at"] = (face.middle + inner_point(face.polygon) @ face.axes).tolist()


def _tube(ends: FloatArray, radius: float) -> trimesh.Trimesh:
    tube = trimesh.creation.cylinder(radius, segment=ends, sections=TUBE_SIDES)
    return _coloured(tube.vertices, tube.faces, TUBE_COLOUR)


def _camera(view: View, length: float) -> trimesh.Trimesh:
    camera, pose = view.camera, view.pose
    across = np.array([-camera.cx, camera.width - camera.cx]) / camera.fx
    down = np.array([-camera.cy, camera.height - camera.cy]) / camera.fy
    rim = [(across[0], down[0]), (across[1], down[0]), (across[1], down[1]), (across[0], down[1])]
    corners: FloatArray = length * np.array([(0.0, 0.0, 0.0), *((x, y, 1.0) for x, y in rim)])
    return _coloured(pose.centre + corners @ pose.rotation.T, _SIDES, CAMERA_COLOUR)


def _coloured(
    corners: FloatArray, triangles: NDArray[np.int64], colour: tuple[int, int, int, int]
) -> trimesh.Trimesh:
    colours = np.tile(np.array(colour, dtype=np.uint8), (len(triangles), 1))
    return trimesh.Trimesh(corners, triangles, face_colors=colours, process=False)
