"""Scenes: their faces, outlines and things; scene files, exact solids, drawings."""
