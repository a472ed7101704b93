"""What each view before a face shows of it: how much is seen, hidden by which face, and outside."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photometric_views import (
    MIN_FACING_SINE,
    PhotometricViews,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.scene import Face, FaceSight
from facetlog.perception.surfaces.eyes import BEFORE_PX, Eye, Surface, in_picture
from facetlog.perception.types import FloatArray

__all__ = ["Look", "shown_at"]


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """How the views look at a face: which are `before` it (V,), and of each point (V, n) whether it
    is `inside` the picture, and which face is its `hider`, -1 for none.
    """

    surface: Surface
    before: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    hider: NDArray[np.intp]

    @classmethod
    def at(cls, surface: Surface, views: int) -> "Look":
        """Before any view looked."""
        rows = views, len(surface.points)
        before, inside = np.zeros(views, dtype=np.bool_), np.zeros(rows, dtype=np.bool_)
        return cls(surface, before, inside, np.full(rows, -1))

    def through(self, view: int, eye: Eye, number: int) -> None:
        """Looks by one view at the face, which has this number among all."""
        points = self.surface.points
        if not len(points):
            return
        away = eye.centre - points.mean(axis=0)
        height = float(away @ self.surface.face.plane.normal)
        self.before[view] = height > MIN_FACING_SINE * float(np.linalg.norm(away))
        uv, depth = project_points(eye.view.projection, points)
        self.inside[view] = np.logical_and(depth > 0, in_picture(uv, eye.size))
        if not self.before[view]:
            return
        on = np.nonzero(self.inside[view])[0]
        others = eye.depths(uv[on])
        others[number] = np.inf
        limit = depth[on] - BEFORE_PX * eye.pixel(depth[on])
        self.hider[view, on] = np.where(others.min(axis=0) < limit, others.argmin(axis=0), -1)

    def face(self, photos: PhotometricViews) -> Face:
        """The face with what each view before it shows of it."""
        face, points = self.surface.face, self.surface.points
        if not len(points):
            return face
        clear = self.before[:, None] & self.inside & (self.hider < 0)
        shown = shown_at(photos, points, np.arange(len(clear)), clear)
        sights = tuple(
            FaceSight(
                k,
                float(shown[k].mean()),
                tuple(
                    (by, float((self.hider[k] == by).mean()))
                    for by in np.unique(self.hider[k]).tolist()
                    if by >= 0
                ),
                float(1.0 - self.inside[k].mean()),
            )
            for k in np.nonzero(self.before)[0].tolist()
        )
        return replace(face, coverage=float(shown.any(axis=0).mean()), sights=sights)


def shown_at(
    photos: PhotometricViews,
    points: FloatArray,
    views: NDArray[np.intp],
    clear: NDArray[np.bool_] | None = None,
) -> NDArray[np.bool_]:
    """Which of the views (v,) show a surface at points (n, 3), as others do: (v, n).

    `clear` (v, n) are those that have nothing else before it, as far as is known.
    """
    found, _ = photos.agree(views, points, clear=clear)
    return found.agrees & (found.ratio > 0)
