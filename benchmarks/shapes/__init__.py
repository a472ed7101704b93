"""What meshes, scans and texts of models are judged to be."""
