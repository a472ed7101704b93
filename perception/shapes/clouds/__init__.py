"""A point cloud into flat regions and the rest: grown, outlined, its outside found."""
