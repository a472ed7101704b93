"""Photo-consistency of views: do they show one and the same surface at points of the scene?"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import (
    Agreement,
    GreyLevels,
    Levels,
    agreement,
    compute_known_surface_ratio,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_to_views
from facetlog.perception.types import FloatArray, View

# A view counts when it looks at a plane by more than this sine.
MIN_FACING_SINE = 0.15
# A view reads no level nearer to the picture's border than this, px.
BORDER_PX = 1


class PhotometricViews:
    """Views with their grey levels; `weight` (V,) is how much each counts beside views like it."""

    def __init__(self, views: Sequence[View], levels: GreyLevels, weight: FloatArray) -> None:
        self.projections = np.array([view.projection for view in views])
        self.centres = np.array([view.pose.centre for view in views])
        self.weight = weight
        self.focal = float(np.median([view.camera.fx for view in views]))
        self._sizes = np.array([view.image.shape[::-1] for view in views])
        self.levels = levels

    def facing(self, middle: FloatArray, normal: FloatArray) -> NDArray[np.intp]:
        """Return the views (v,) in front of a plane through a point (3,) that do not see it edge-
        on.
        """
        rays = self.centres - middle
        before = rays @ normal > MIN_FACING_SINE * np.linalg.norm(rays, axis=1)
        return np.nonzero(before)[0]

    def agree(
        self,
        views: NDArray[np.intp],
        points: FloatArray,
        taken: Sequence[NDArray[np.uint8]] | None = None,
        clear: NDArray[np.bool_] | None = None,
    ) -> tuple[Agreement, NDArray[np.bool_]]:
        """Return how far the chosen views (v,) are consistent at points (n, 3), and which they see
        (v, n).

        A view does not see what is outside its picture, falls on its `taken` pixels (V pictures
        of 0 and 1), which show something else, or is not `clear` (v, n) of other things.
        """
        levels, seen = self._read(views, points, taken)
        if clear is not None:
            levels, seen = levels.where(clear), seen & clear
        return agreement(levels, self.weight[views]), seen

    def compare_evened(
        self, views: NDArray[np.intp], points: FloatArray, taken: Sequence[NDArray[np.uint8]]
    ) -> Agreement:
        """Return `agree` as if each view showed the points (n, 3) as bright in the median as all
        do.

        Gloss adds about the same level everywhere on a smooth surface.
        """
        levels, seen = self._read(views, points, taken)
        there = seen.any(axis=1)
        usual = np.zeros((len(views), 1), dtype=np.float32)
        usual[there] = np.nanmedian(levels.level[there], axis=1, keepdims=True)
        even = levels.level - usual + np.median(usual[there]) if there.any() else levels.level
        return agreement(replace(levels, level=even), self.weight[views])

    def compare_clear_views(
        self,
        views: NDArray[np.intp],
        points: FloatArray,
        taken: Sequence[NDArray[np.uint8]],
        clear: NDArray[np.bool_],
    ) -> tuple[Agreement, Agreement]:
        """Return `agree` of the views whose sight of the points is clear, and of all of them."""
        levels, _ = self._read(views, points, taken)
        weight = self.weight[views]
        return agreement(levels.where(clear), weight), agreement(levels, weight)

    def judge_known_surface(
        self, view: int, points: FloatArray, surface: NDArray[np.float32]
    ) -> FloatArray:
        """Return the log-likelihood ratio (n,) that a view shows a surface of that level at points
        (n, 3).
        """
        levels, _ = self._read(np.array([view]), points)
        ratio: FloatArray = compute_known_surface_ratio(levels, surface)[0]
        return ratio

    def _read(
        self,
        views: NDArray[np.intp],
        points: FloatArray,
        taken: Sequence[NDArray[np.uint8]] | None = None,
    ) -> tuple[Levels, NDArray[np.bool_]]:
        uv, depth = project_to_views(self.projections[views], points)
        u, v = uv.transpose(2, 0, 1)
        width, height = self._sizes[views].T[:, :, None]
        seen = (depth > 0) & (u > BORDER_PX) & (u < width - 1 - BORDER_PX)
        seen &= (v > BORDER_PX) & (v < height - 1 - BORDER_PX)
        if taken is not None:
            at = np.where(seen, np.rint(v) * width + np.rint(u), 0).astype(np.intp)
            seen &= np.array([taken[k].take(at[n]) == 0 for n, k in enumerate(views)])
        return self.levels.read(views, np.stack([u, v]), seen), seen
