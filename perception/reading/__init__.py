"""Files into views: poses, cameras and pictures; below, files of meshes and clouds."""
