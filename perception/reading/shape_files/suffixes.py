"""Which files hold meshes and clouds, by their suffix, in lower case."""

__all__ = ["CLOUD_SUFFIXES", "MESH_SUFFIXES"]

CLOUD_SUFFIXES = (".csv", ".las", ".laz", ".pcd", ".ply", ".pts", ".txt", ".xyz")
"""The files that `read_cloud` reads; a COLMAP model is a folder."""

MESH_SUFFIXES = (".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl")
"""The files that `read_mesh` reads."""
