"""The files of a map: picture, JSON, 3-D, and what ROS reads."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from facetlog.mapping.floor_grid import Cell, FloorGrid
from facetlog.mapping.map_record import format_map_json
from facetlog.mapping.room_picture import map_png
from facetlog.mapping.same_thing import MappedThing
from facetlog.perception.atomic_write import write_atomically
from facetlog.perception.surfaces.mesh_export import choose_face_colour, encode_glb

if TYPE_CHECKING:
    from facetlog.mapping.room_map import RoomMap

PNG_FILE, JSON_FILE, GLB_FILE = "map.png", "map.json", "map.glb"

PGM_FILE, YAML_FILE = "map.pgm", "map.yaml"
# The greys that map_saver writes: what only sonars passed is not known to be free.
GREYS = {Cell.UNSEEN: 205, Cell.PASSED: 205, Cell.FREE: 254, Cell.OCCUPIED: 0}
# The thresholds that map_saver writes; 205 is between them.
OCCUPIED, FREE = 0.65, 0.196

# trimesh leaves it without types.
_box: Callable[..., trimesh.Trimesh] = trimesh.creation.box

UP = np.array([0.0, 0.0, 1.0])
# Red, green, blue and how opaque, of floor that is free and that is occupied.
FLOOR_COLOURS = {Cell.FREE: (205, 225, 205, 255), Cell.OCCUPIED: (200, 120, 110, 255)}
# The floor lies a little lower than what stands on it, metres: two surfaces in one place flicker.
SUNK = 0.002


def write_map(room: "RoomMap", folder: Path) -> None:
    """Write a map in all its forms into a folder; InputError where that cannot be written to."""
    for name, content in _contents(room):
        write_atomically(folder / name, content)


def _contents(room: "RoomMap") -> Iterator[tuple[str, bytes]]:
    yield PNG_FILE, map_png(room)
    yield JSON_FILE, format_map_json(room).encode()
    if (model := export_map_glb(room)) is not None:
        yield GLB_FILE, model
    yield PGM_FILE, format_pgm(room.floor)
    yield YAML_FILE, format_map_yaml(room.floor).encode()


def format_pgm(floor: FloorGrid) -> bytes:
    """Return the picture in Netpbm's binary form (P5), one byte a cell."""
    import numpy as np

    greys = np.zeros(len(Cell), np.uint8)
    for state, grey in GREYS.items():
        greys[state] = grey
    picture = greys[floor.cells[::-1]]
    rows, columns = picture.shape
    head = f"P5\n# facetlog: {floor.side:g} m a pixel\n{columns} {rows}\n255\n"
    return head.encode("ascii") + picture.tobytes()


def format_map_yaml(floor: FloorGrid, picture: str = PGM_FILE) -> str:
    """Return what says how to read the picture of that name beside it."""
    x, y = (round(value, 9) for value in floor.low)
    return (
        f"image: {picture}\n"
        "mode: trinary\n"
        f"resolution: {floor.side!r}\n"
        f"origin: [{x!r}, {y!r}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {OCCUPIED}\n"
        f"free_thresh: {FREE}\n"
    )


def export_map_glb(room: "RoomMap") -> bytes | None:
    """Return the map as binary glTF, a node for each thing (named as in the map) and kind of floor.

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
            mesh, face_colors=np.tile(choose_face_colour(index), (len(mesh.faces), 1))
        )
        name = f"{thing.name}_{thing.model}" if thing.model else thing.name
        graph.add_geometry(mesh, node_name=name, geom_name=name)
    return encode_glb(graph, UP) if graph.geometry else None


def _floor(floor: FloorGrid, state: Cell) -> trimesh.Trimesh | None:
    """Return rectangles for the runs of cells in a state along x."""
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
    """Return the faces that were seen, filled; without any the box round it."""
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
