"""Which files hold meshes and clouds, by their suffix in lower case.

A new format is a module in meshes/ or clouds/, and its row here. Readers are named and not
imported: the command line asks for suffixes, and a file loads its own reader alone.
"""

from collections.abc import Mapping
from types import MappingProxyType

CLOUD_READERS: Mapping[str, str] = MappingProxyType(
    {
        ".csv": "text_points:read_text",
        ".las": "las_points:read_las",
        ".laz": "las_points:read_las",
        ".pcd": "pcd_points:read_pcd",
        ".ply": "cloud_files:read_ply",
        ".pts": "text_points:read_text",
        ".txt": "text_points:read_text",
        ".xyz": "text_points:read_text",
    }
)
"""Module in clouds/ and function: it takes a `ShapeFile` and gives a `Cloud`."""

MESH_READERS: Mapping[str, str] = MappingProxyType(
    {
        ".dae": "dae_mesh:read_dae",
        ".glb": "gltf_mesh:read_gltf",
        ".gltf": "gltf_mesh:read_gltf",
        ".obj": "obj_mesh:read_obj",
        ".off": "off_mesh:read_off",
        ".ply": "ply_mesh:read_ply",
        ".stl": "stl_mesh:read_stl",
    }
)
"""Module in meshes/ and function: it takes bytes and a `ShapeFile`, and gives a `TriangleList`."""

CLOUD_SUFFIXES, MESH_SUFFIXES = tuple(CLOUD_READERS), tuple(MESH_READERS)
"""The files that `read_cloud` and `read_mesh` read; a COLMAP model is a folder."""

FORMATS_WITH_UP = (".dae", ".glb", ".gltf")
"""Suffixes of files that state which axis is up, and their unit."""
