"""Readers of point clouds, one module for each format."""
