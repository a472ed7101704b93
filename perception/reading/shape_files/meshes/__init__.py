"""Readers of meshes, one module for each format."""
