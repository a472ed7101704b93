"""Faces from lines: segments, 3-D segments supported by many views, planes, outlines."""
