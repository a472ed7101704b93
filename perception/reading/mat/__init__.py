"""A printed mat in pictures: what is printed on it, and the cameras and poses that it gives."""
