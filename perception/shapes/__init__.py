"""Meshes and point clouds into scenes: files → regions → polygons → bodies → scene."""
