"""Scenes out as meshes, to look at: PLY with a colour per face, glTF with a node per face."""

import colorsys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from trimesh.exchange import gltf, ply
from trimesh.viewer import notebook

from facetlog.errors import InputError
from facetlog.perception.atomic_write import write_atomically
from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.polygons import triangulate
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.face_table import flat_faces
from facetlog.perception.types import FloatArray

# trimesh leaves these without types.
_export_ply: Callable[..., bytes] = ply.export_ply
_export_glb: Callable[..., bytes] = gltf.export_glb
_export_gltf: Callable[..., dict[str, bytes]] = gltf.export_gltf
_set_camera: Callable[..., object] = trimesh.Scene.set_camera
_viewer_html: Callable[..., str] = notebook.scene_to_html
_apply: Callable[..., object] = trimesh.Scene.apply_transform

# Hues a golden section apart stay distinct however many there are.
HUE_STEP = 0.6180339887
SATURATION, BRIGHTNESS = 0.55, 0.95
# Where the viewer's camera stands at first: angles about x and y, radians, and how many of the
# scene's diagonals away.
VIEWER_ANGLES = (-0.45, 0.6, 0.0)
VIEWER_DISTANCE = 1.3
# glTF 2.0, section 3.4: +y is up.
GLTF_UP = (0.0, 1.0, 0.0)
# A corner this near to a vertex, as a share of the face's extent, is that vertex, rounded.
SAME_CORNER = 1e-9


def triangulate_face(face: FlatFace, points: FloatArray) -> FloatArray:
    """Return triangles (n, 3, 3) that fill a face, holes left open, counter-clockwise from outside.

    Corners are the scene's vertices; only where an outline crosses itself are there others, in
    the face's plane. A face without area has none.
    """
    if not face.polygon.area > 0.0:
        return np.zeros((0, 3, 3))
    corners = triangulate(face.polygon)
    # all three run the same way round, which may be either
    (ax, ay), (bx, by) = np.moveaxis(corners[:, 1:] - corners[:, :1], (1, 2), (0, 1))
    clockwise = ax * by - ay * bx < 0.0
    corners[clockwise] = corners[clockwise][:, ::-1]
    own = points[list(face.members)]
    flat = face.flatten(own)
    gaps = np.linalg.norm(corners[:, :, None] - flat, axis=3)
    nearest = gaps.argmin(axis=2)
    same = gaps.min(axis=2) <= SAME_CORNER * float(np.ptp(flat, axis=0).max())
    lifted: FloatArray = face.middle + corners @ face.axes
    return np.where(same[..., None], own[nearest], lifted)


def add_faces(graph: trimesh.Scene, scene: Scene) -> bool:
    """Add a node (f1, f2, …) for each face that has an area; return whether there are any."""
    meshes = dict(_iter_face_meshes(scene))
    for name, mesh in meshes.items():
        graph.add_geometry(mesh, node_name=name, geom_name=name)
    return bool(meshes)


def encode_glb(graph: trimesh.Scene, up: FloatArray | None) -> bytes:
    """Return the graph as `.glb`, turned so that `up` (3,), where it is known, is the format's."""
    _turn_up(graph, up)
    return bytes(_export_glb(graph))


def _turn_up(graph: trimesh.Scene, up: FloatArray | None) -> None:
    if up is not None:
        _apply(graph, _make_turn_up(up))


def choose_face_colour(index: int) -> NDArray[np.uint8]:
    """Return the colour: red, green, blue and opacity (4,) of what has a number: neighbours in
    number differ.
    """
    rgb = colorsys.hsv_to_rgb(index * HUE_STEP % 1.0, SATURATION, BRIGHTNESS)
    return np.array([*(round(255 * c) for c in rgb), 255], dtype=np.uint8)


def _iter_face_meshes(scene: Scene) -> Iterator[tuple[str, trimesh.Trimesh]]:
    points = scene.points
    for face in flat_faces(scene):
        triangles = triangulate_face(face, points)
        if len(triangles):
            corners, rows = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
            mesh = trimesh.Trimesh(
                corners,
                rows.reshape(-1, 3),
                face_colors=np.tile(choose_face_colour(face.index), (len(triangles), 1)),
                process=False,
            )
            yield f"f{face.index + 1}", mesh


def _make_turn_up(up: FloatArray) -> FloatArray:
    """Return the least rotation (4, 4) that brings a unit vector to the up of glTF.

    >>> _make_turn_up(np.array([0.0, 0.0, 1.0])) @ [1.0, 2.0, 3.0, 1.0]
    array([ 1.,  3., -2.,  1.])
    """
    axis = np.cross(up, GLTF_UP)
    sine = float(np.linalg.norm(axis))
    # upside down any level axis will do
    level = axis / sine if sine > 0.0 else np.array([1.0, 0.0, 0.0])
    turn = Rotation.from_rotvec(np.arctan2(sine, up @ GLTF_UP) * level)
    matrix = np.eye(4)
    matrix[:3, :3] = turn.as_matrix().round(15)  # a quarter turn is written with zeros
    return matrix


def encode_mesh(scene: Scene, suffix: str) -> bytes:
    """Return the scene's faces as `.ply`, `.glb` or `.gltf`, in the scene's coordinates and unit.

    In glTF every face is a node (f1, f2, …) of its own, turned so that up, where it is known, is
    the format's. Loose edges are left out.
    """
    graph = trimesh.Scene()
    if not add_faces(graph, scene):
        raise InputError(f"{scene.name}: has no face with an area, there is no mesh to write")
    if suffix == ".ply":
        return bytes(_export_ply(trimesh.util.concatenate(list(graph.geometry.values()))))
    _turn_up(graph, scene.up)
    if suffix == ".glb":
        return bytes(_export_glb(graph))
    if suffix == ".gltf":
        return bytes(_export_gltf(graph, embed_buffers=True)["model.gltf"])
    raise InputError(f"{suffix or 'no suffix'}: meshes are written as .ply, .glb or .gltf")


def render_viewer(scene: Scene) -> str:
    """Return a page that shows the scene's faces, to turn by mouse: three.js and all else is
    inside.
    """
    graph = trimesh.Scene()
    if not add_faces(graph, scene):
        raise InputError(f"{scene.name}: has no face with an area, there is no mesh to show")
    return render_viewer_page(graph, scene.up, look_at=scene.points)


def render_viewer_page(
    graph: trimesh.Scene, up: FloatArray | None, *, look_at: FloatArray, script: str = ""
) -> str:
    """Return a page that shows any graph in a scene's frame, turned upright; with a script at its
    end.

    The camera stands so that points (n, 3) are in view.
    """
    turn = np.eye(4) if up is None else _make_turn_up(up)
    seen = look_at @ turn[:3, :3].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    turn[:3, 3] = -(low + high) / 2.0
    # The viewer's light falls towards the origin; the camera looks down a little from one side.
    _apply(graph, turn)
    distance = VIEWER_DISTANCE * float(np.linalg.norm(high - low))
    _set_camera(graph, angles=VIEWER_ANGLES, distance=distance, center=np.zeros(3))
    page, end, rest = str(_viewer_html(graph)).rpartition("</body>")
    return f"{page}<script>{script}</script>{end}{rest}" if script else f"{page}{end}{rest}"


def write_mesh(scene: Scene, path: Path) -> None:
    """Write the scene's faces as a mesh of the kind that the path's suffix says, whole or not."""
    write_atomically(path, encode_mesh(scene, path.suffix.lower()))
