"""Views into a scene and its facts: features, tracks, vertices, faces, with their uncertainty."""
