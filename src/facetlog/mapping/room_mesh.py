"""The map in 3-D, as GLB: the free floor, and each thing's faces, or else the box round it."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from facetlog.mapping.floor_grid import Cell, FloorGrid
from facetlog.mapping.same_thing import MappedThing
from facetlog.perception.surfaces.mesh_export import face_colour, graph_bytes

if TYPE_CHECKING:
    from facetlog.mapping.room_map import RoomMap

__all__ = ["map_glb"]

# trimesh leaves it without types.
_box: Callable[..., trimesh.Trimesh] = trimesh.creation.box

UP = np.array([0.0, 0.0, 1.0])
# Red, green, blue and how opaque, of floor that is free and that is occupied.
FLOOR_COLOURS = {Cell.FREE: (205, 225, 205, 255), Cell.OCCUPIED: (200, 120, 110, 255)}
# The floor lies a little lower than what stands on it, metres: two surfaces in one place flicker.
SUNK = 0.002


def map_glb(room: "RoomMap") -> bytes | None:
    """The map as binary glTF, a node for each thing (named as in the map) and kind of floor.

    None of a map on which there is neither.
    """
    graph = trimesh.Scene()
    for state, colour in FLOOR_COLOURS.items():
        mesh = _floor(room.floor, state)
        if mesh is not None:
            mesh.visual = trimesh.visual.ColorVisuals(
                mesh, face_colors=np.tile(np.array(colour, np.uint8), (len(mesh.faces), 1))
            )
            graph.add_geometry(mesh, node_name=f"floor_{state.name.lower()}")
    for index, thing in enumerate(room.things):
        mesh = _solid(thing)
        mesh.visual = trimesh.visual.ColorVisuals(
            mesh, face_colors=np.tile(face_colour(index), (len(mesh.faces), 1))
        )
        name = f"{thing.name}_{thing.model}" if thing.model else thing.name
        graph.add_geometry(mesh, node_name=name, geom_name=name)
    return graph_bytes(graph, UP) if graph.geometry else None


def _floor(floor: FloorGrid, state: Cell) -> trimesh.Trimesh | None:
    """Rectangles for the runs of cells in a state along x."""
    chosen = np.pad(floor.cells == state, ((0, 0), (1, 1))).astype(np.int8)
    steps = np.diff(chosen, axis=1)
    (rows, first), (_, last) = np.nonzero(steps == 1), np.nonzero(steps == -1)
    if not len(rows):
        return None
    low_x, high_x = (floor.low[0] + floor.side * ends for ends in (first, last))
    low_y = floor.low[1] + floor.side * rows
    high_y = low_y + floor.side
    corners = np.stack(
        [
            np.stack([x, y, np.full(len(x), -SUNK)], axis=1)
            for x, y in ((low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y))
        ],
        axis=1,
    )
    starts = 4 * np.arange(len(rows))[:, None]
    triangles = np.concatenate([starts + np.array(corner) for corner in ((0, 1, 2), (0, 2, 3))])
    return trimesh.Trimesh(corners.reshape(-1, 3), triangles, process=False)


def _solid(thing: MappedThing) -> trimesh.Trimesh:
    """The faces that were seen, filled; without any the box round it."""
    corners = thing.best.triangles.reshape(-1, 3)
    if len(corners):
        return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
    length, width, height = (max(each.value, SUNK) for each in thing.best.lengths)
    x, y, heading = thing.best.pose.tolist()
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_rotvec([0.0, 0.0, heading]).as_matrix()
    turn[:3, 3] = x, y, height / 2
    box: trimesh.Trimesh = _box((length, width, height), turn)
    return box
