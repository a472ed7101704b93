"""Files of meshes and point clouds into triangles and points."""
