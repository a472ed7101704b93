"""A lattice of points on the ground, where views look at it, and what of it faces hide."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photometric_views import MIN_FACING_SINE
from facetlog.perception.flat_faces import clip_polygon_above, make_plane_axes
from facetlog.perception.surfaces.seeing.seen_faces import BEFORE_PX, NEAREST
from facetlog.perception.types import FloatArray, View

__all__ = ["PITCH_PX", "GroundLattice"]

# Points are so many pixels apart: no two have the same nearest pixel, and hardly a pixel is left.
PITCH_PX = 1.5
# Points at most, in all and along a side; above, they are further apart.
MOST_POINTS = 200_000
MOST_ALONG = 8_000
# Fewest along a side.
FEWEST_ALONG = 8
# Beyond the lattice, along its sides, shadows are cut off.
FAR = 1 << 14


@dataclass(frozen=True, eq=False, slots=True)
class GroundLattice:
    """Points `corner` (3,) + i steps[0] + j steps[1] for i, j below `shape`, rows and columns.

    `steps` (2, 3) are square to each other and equally long; `normal` (3,) is that of the ground.
    """

    corner: FloatArray
    steps: FloatArray
    normal: FloatArray
    shape: tuple[int, int]

    @classmethod
    def under(
        cls, views: Sequence[View], normal: FloatArray, height: float
    ) -> "GroundLattice | None":
        """Return the lattice half a picture's width round where the optical axes meet the ground;
        None if none does.

        The ground is normal · x = height.
        """
        axes = make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        middles, pixels, widths = [], [], []
        for view in views:
            forward, centre = view.pose.rotation[:, 2], view.pose.centre
            fall, above = -float(forward @ normal), float(centre @ normal) - height
            if fall < MIN_FACING_SINE or above <= 0:
                continue
            away = above / fall
            middles.append(axes @ (centre + away * forward))
            pixel = away / view.camera.fx
            widths.append(pixel * view.camera.width)
            # A pixel's area is that of its square by the sine at which it is seen.
            pixels.append(pixel / np.sqrt(fall))
        if not middles:
            return None
        half = np.array(widths)[:, None] / 2
        low, high = (middles - half).min(axis=0), (middles + half).max(axis=0)
        sides = high - low
        pitch = max(
            PITCH_PX * float(np.median(pixels)),
            float(np.sqrt(sides.prod() / MOST_POINTS)),
            float(sides.max() / MOST_ALONG),
        )
        rows, columns = np.maximum(sides // pitch, FEWEST_ALONG).astype(int).tolist()
        return cls(low @ axes + height * normal, pitch * axes, normal, (rows, columns))

    def pixels(self, view: View) -> FloatArray:
        """Return the homography (3, 3) from (column, row, 1) to homogeneous pixels, depth last."""
        across, down = self.steps[1], self.steps[0]
        points = np.column_stack([np.stack([across, down, self.corner]), [0.0, 0.0, 1.0]]).T
        homography: FloatArray = view.projection @ points
        return homography

    def shadow(self, faces: Sequence[Sequence[FloatArray]], view: View) -> NDArray[np.bool_]:
        """Return the points (rows, columns) that faces, each some rings (k, 3), hide from a view
        above.

        Of a face on the ground nothing does.
        """
        mask = np.zeros(self.shape, dtype=np.uint8)
        for rings in faces:
            loops = [loop for ring in rings for loop in self._cast(ring, view)]
            if loops:
                cv2.fillPoly(mask, loops, 1)
        return mask.view(np.bool_)

    def _cast(self, ring: FloatArray, view: View) -> Iterator[NDArray[np.int32]]:
        """Return the ring as its shadow has it, in columns and rows, if it has any."""
        centre = view.pose.centre
        top = float((centre - self.corner) @ self.normal)
        # What stands on the ground hides it; what lies there is known to be there to some pixels.
        least = BEFORE_PX * top / view.camera.fx
        part = clip_polygon_above(ring, (ring - self.corner) @ self.normal - least)
        if len(part) >= 3:
            part = clip_polygon_above(
                part, (1 - NEAREST) * top - (part - self.corner) @ self.normal
            )
        if len(part) >= 3:
            below = top - (part - self.corner) @ self.normal
            met = centre + (part - centre) * (top / below)[:, None] - self.corner
            at = met @ self.steps[::-1].T / (self.steps[0] @ self.steps[0])
            yield np.clip(np.rint(at), -FAR, FAR).astype(np.int32)
