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
from facetlog.perception.surfaces.seeing.eyes import BEFORE_PX, Eye, in_picture
from facetlog.perception.surfaces.seeing.seen_faces import Surface
from facetlog.perception.types import FloatArray

__all__ = ["Look"]

# A face hides so much of another, or it is a pixel at the rim of a neighbour.
LEAST_HIDDEN = 1.0 / 60.0


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """How the views look at a face: which are `before` it (V,), and of each point (V, n) whether it
    is `inside` the picture, and which face is its `hider`, -1 for none.
    """

    surface: Surface
    points: FloatArray
    before: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    hider: NDArray[np.intp]

    @classmethod
    def at(cls, surface: Surface, views: int) -> "Look":
        """Before any view looked."""
        points = surface.points
        rows = views, len(points)
        before, inside = np.zeros(views, dtype=np.bool_), np.zeros(rows, dtype=np.bool_)
        return cls(surface, points, before, inside, np.full(rows, -1))

    def through(self, view: int, eye: Eye, number: int) -> None:
        """Looks by one view at the face, which has this number among all."""
        points = self.points
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

    def _hidden(self, view: int) -> tuple[tuple[int, float], ...]:
        # By which faces it is hidden from a view, each with its share.
        hider = self.hider[view]
        shares = ((by, float((hider == by).mean())) for by in np.unique(hider[hider >= 0]).tolist())
        return tuple((by, share) for by, share in shares if share >= LEAST_HIDDEN)

    def shown(self, photos: PhotometricViews) -> NDArray[np.bool_]:
        """Which views show which points of the face (V, n), as others do."""
        clear = self.before[:, None] & self.inside & (self.hider < 0)
        return _shown_at(photos, self.points, clear)

    def face(self, shown: NDArray[np.bool_]) -> Face:
        """The face with what each view before it shows of it, of which points (V, n) are shown."""
        face = self.surface.face
        if not len(self.points):
            return face
        sights = tuple(
            FaceSight(
                k,
                float(shown[k].mean()),
                self._hidden(k),
                float(1.0 - self.inside[k].mean()),
            )
            for k in np.nonzero(self.before)[0].tolist()
        )
        return replace(face, coverage=float(shown.any(axis=0).mean()), sights=sights)


def _shown_at(
    photos: PhotometricViews, points: FloatArray, clear: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    # Which views show a surface at points (n, 3), as others do: (V, n); those that are `clear`
    # (V, n) have nothing else before it, as far as is known.
    found, _ = photos.agree(np.arange(len(clear)), points, clear=clear)
    return found.agrees & (found.ratio > 0)
