"""Counts of sonar beams that passed each cell of a floor, and that ended in it.

A beam is some 30 degrees wide, and what it met is somewhere on its arc: where most of the beams
that came to a cell ended, something is; where most of them passed, nothing is of their height.
"""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.mapping.sonar_beams import Beam
from facetlog.perception.types import FloatArray

HALF_BEAM = math.radians(15.0)
"""Half of a sonar's beam: it is some 30 degrees wide (Pioneer 2 manual)."""


class BeamCounts:
    """Counts of beams in cells (rows, columns): `hits` that ended there, `passes` that went on.

    `low` is the corner of cell (0, 0) in the world, `side` that of a cell, metres.
    """

    def __init__(self, low: tuple[float, float], side: float, shape: tuple[int, int]) -> None:
        self._low, self._side = np.array(low), side
        self.hits: NDArray[np.float32] = np.zeros(shape, np.float32)
        self.passes: NDArray[np.float32] = np.zeros(shape, np.float32)

    @property
    def echoed(self) -> NDArray[np.bool_]:
        """The cells in which at least as many beams ended as passed."""
        return np.asarray((self.hits > 0) & (self.hits >= self.passes))

    @property
    def passed(self) -> NDArray[np.bool_]:
        """The cells that more beams passed than ended there."""
        return np.asarray(self.passes > self.hits)

    def add(self, beam: Beam) -> None:
        """Count a beam where it passed, and where it ended."""
        count = max(2, math.ceil(2 * HALF_BEAM * beam.range / self._side))
        ring = sector(beam, count)
        # OpenCV's pixels are at whole numbers: a cell's middle is one.
        pixels = np.rint((ring - self._low) / self._side - 0.5).astype(np.int32)
        mask = np.zeros(self.hits.shape, np.uint8)
        cv2.fillPoly(mask, [pixels], 1)
        at_end = np.zeros(self.hits.shape, np.uint8)
        cv2.polylines(at_end, [pixels[1:]], False, 1)
        ended = at_end.view(np.bool_)
        self.passes += mask.view(np.bool_) & ~ended
        if beam.echo:
            self.hits += ended


def sector(beam: Beam, count: int) -> FloatArray:
    """Return where a beam begins, and so many places of the arc on which it ends (count + 1, 2)."""
    angles = beam.heading + np.linspace(-HALF_BEAM, HALF_BEAM, count)
    begin = np.array([beam.x, beam.y])
    arc = beam.range * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.vstack([begin, begin + arc])
