"""Structure from motion: cameras and poses of pictures by what they have in common."""
