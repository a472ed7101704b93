"""Faces by lines first: segments, 3-D segments that many views support, planes, outlines."""
