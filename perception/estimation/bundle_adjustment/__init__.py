"""Poses and points together: bundle adjustment."""
