"""The scene in 3-D for the page: faces, pieces, unseen space and cameras, to turn and to light up.

What shows it is trimesh's page with three.js inside. A script beside it (model_view.js) hears
from the page which nodes to show and which to light up, and says which one was clicked.
"""

from collections.abc import Sequence
from importlib.resources import files

import numpy as np
import trimesh

from facetlog.perception.pieces.piece_meshes import add_pieces
from facetlog.perception.pieces.shown_pieces import ShownPieces
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.mesh_export import add_faces, viewer_page
from facetlog.perception.types import FloatArray, View

__all__ = ["model_view"]

# A camera is drawn as a pyramid so long, of the scene's diagonal, as wide and high as it sees.
CAMERA_SHARE = 0.06
CAMERA_COLOUR = (90, 110, 130, 255)
# The base's corners 1 to 4 run round, the pinhole is corner 0.
_SIDES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [1, 3, 2], [1, 4, 3]])


def model_view(scene: Scene, pieces: ShownPieces, views: Sequence[View]) -> str:
    """A page of its own, with nodes f1, … p1, … unseen1, … and view1, …; "" without a face."""
    graph = trimesh.Scene()
    if not add_faces(graph, scene):
        return ""
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    add_pieces(graph, pieces)
    for number, view in enumerate(views, start=1):
        graph.add_geometry(_camera(view, CAMERA_SHARE * size), node_name=f"view{number}")
    script = files(__package__).joinpath("model_view.js").read_text(encoding="utf-8")
    return viewer_page(graph, scene.up, look_at=scene.points, script=script)


def _camera(view: View, length: float) -> trimesh.Trimesh:
    camera, pose = view.camera, view.pose
    across = np.array([-camera.cx, camera.width - camera.cx]) / camera.fx
    down = np.array([-camera.cy, camera.height - camera.cy]) / camera.fy
    rim = [(across[0], down[0]), (across[1], down[0]), (across[1], down[1]), (across[0], down[1])]
    corners: FloatArray = length * np.array([(0.0, 0.0, 0.0), *((x, y, 1.0) for x, y in rim)])
    return trimesh.Trimesh(
        pose.centre + corners @ pose.rotation.T,
        _SIDES,
        face_colors=np.tile(np.array(CAMERA_COLOUR, dtype=np.uint8), (len(_SIDES), 1)),
        process=False,
    )
