"""Flat faces in space, and which points of surfaces lie on them: found faces are measured so."""

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

SAMPLES = 400  # of a face, about


class Polygon:
    """A flat face in space: its loop of corners (n, 3), its unit normal (3,) and its area."""

    def __init__(self, corners: FloatArray) -> None:
        arms = corners - corners[0]
        total = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
        self.normal = total / np.linalg.norm(total)
        across = np.cross(self.normal, np.eye(3)[int(np.argmin(np.abs(self.normal)))])
        across /= np.linalg.norm(across)
        self._axes = np.array([across, np.cross(self.normal, across)])
        self._middle = corners.mean(axis=0)
        self._outline = shapely.Polygon((corners - self._middle) @ self._axes.T).buffer(0.0)
        self.area = float(self._outline.area)

    def samples(self) -> FloatArray:
        """Return points (n, 3) evenly over the face."""
        low, high = np.reshape(self._outline.bounds, (2, 2))
        # As many cells along the shorter side as cells that are square have, but two at least.
        cell = np.sqrt(self.area / SAMPLES)
        steps = np.maximum(np.ceil((high - low) / cell).astype(int), 2)
        cells = np.stack(np.meshgrid(*map(np.arange, steps), indexing="ij"), axis=-1)
        flat = low + (high - low) * (cells.reshape(-1, 2) + 0.5) / steps
        inside = flat[shapely.contains_xy(self._outline, flat)]
        return np.asarray(self._middle + inside @ self._axes)

    def covers(
        self, points: FloatArray, normals: FloatArray, *, offset: float, margin: float, turn: float
    ) -> NDArray[np.bool_]:
        """Return which points (n, 3) of surfaces with these normals (n, 3) lie on the face."""
        arms = points - self._middle
        near = (np.abs(arms @ self.normal) < offset) & (
            np.abs(normals @ self.normal) > np.cos(turn)
        )
        near[near] = shapely.contains_xy(self._outline.buffer(margin), arms[near] @ self._axes.T)
        return np.asarray(near)
