"""The files of a map: picture, JSON, 3-D, and what ROS reads."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.mapping.map_record import map_json
from facetlog.mapping.room_mesh import map_glb
from facetlog.mapping.room_picture import map_png
from facetlog.mapping.ros_map import PGM_FILE, YAML_FILE, pgm_bytes, yaml_text
from facetlog.perception.atomic_write import write_whole

if TYPE_CHECKING:
    from facetlog.mapping.room_map import RoomMap

__all__ = ["GLB_FILE", "JSON_FILE", "PNG_FILE", "write_map"]

PNG_FILE, JSON_FILE, GLB_FILE = "map.png", "map.json", "map.glb"


def write_map(room: "RoomMap", folder: Path) -> None:
    """Writes a map in all its forms into a folder; InputError where that cannot be written to."""
    for name, content in _contents(room):
        write_whole(folder / name, content)


def _contents(room: "RoomMap") -> Iterator[tuple[str, bytes]]:
    yield PNG_FILE, map_png(room)
    yield JSON_FILE, map_json(room).encode()
    if (model := map_glb(room)) is not None:
        yield GLB_FILE, model
    yield PGM_FILE, pgm_bytes(room.floor)
    yield YAML_FILE, yaml_text(room.floor).encode()
