"""Cameras: frames that are surely new, and whether a picture is good enough to keep."""
