"""Corners and loose edges of a known scene as one more view shows them.

Loose edges bound no face: each is a line in space, whose ends are hardly known along it.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.corner_tracks import Corners, track_corners
from facetlog.perception.detection.line_front_end.faces_from_lines import Pictures
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.detection.working_size import to_own_pixels
from facetlog.perception.estimation.incidence import GATE
from facetlog.perception.estimation.lines.image_line import fit_image_line
from facetlog.perception.estimation.lines.space_line import fit_line_to_points
from facetlog.perception.estimation.pose_noise import compute_pixel_covs
from facetlog.perception.scene import Evidence, Scene
from facetlog.perception.surfaces.drawing.hidden_surface import (
    HiddenSurface,
    hidden_surface,
    is_facing_camera,
)
from facetlog.perception.types import FloatArray, View

__all__ = ["CornerReadings", "OneView"]

# Places along a side that must be seen for it to be looked for.
PLACES = 5


@dataclass(frozen=True, eq=False, slots=True)
class CornerReadings:
    """Pixels (n, 2) of the scene's vertices with covariances (n, 2, 2), where `seen` (n,)."""

    uv: FloatArray
    cov: FloatArray
    seen: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class OneView:
    """A view with the covariance of its pose, what was found in its picture, and what faces hide.

    `hidden` is what the view sees of the faces of `scene`.
    """

    scene: Scene
    given: View
    looked: Pictures
    hidden: HiddenSurface

    @classmethod
    def of(cls, scene: Scene, given: View, looked: Pictures) -> "OneView":
        return cls(scene, given, looked, hidden_surface(looked.views[0], scene))

    def read_corners(self) -> CornerReadings:
        """Return where the view shows the vertices of measured faces: there its edges meet."""
        (view,), (edges,) = self.looked.views, self.looked.maps
        count = len(self.scene.vertices)
        readings = CornerReadings(
            np.zeros((count, 2)),
            np.tile(np.eye(2), (count, 1, 1)),
            np.zeros(count, np.bool_),
        )
        faces = [face for face in self.scene.faces if face.evidence is Evidence.MEASURED]
        if not faces:
            return readings
        corners = Corners(
            self.scene.points, tuple(f.outline for f in faces), tuple(tuple(f.holes) for f in faces)
        )
        turned = np.array([is_facing_camera(face, view) for face in faces])
        shown = corners.find_shown_side_views(turned[:, None])[:, 0] & self._find_sides_in_sight(
            corners.segments
        )
        fits = fit_sides(corners.segments, shown[:, None], [view], [edges])
        for vertex, track in enumerate(track_corners(corners, [view], fits)):
            for seen in to_own_pixels(track, self.looked.factors).observations:
                readings.uv[vertex], readings.cov[vertex] = seen.uv, seen.cov
                readings.seen[vertex] = True
        return readings

    def update_loose_lines(self, scene: Scene, extra_px: float, factor: float) -> tuple[Scene, int]:
        """Return the scene with its loose edges updated by the view, and how many were.

        `scene` has the faces and edges of the view's own. The variance of pixels is `factor` times
        one to which `extra_px` was added (scene_from_tracks.Assembled).
        """
        of_faces = {k for face in scene.faces for ring in (face.outline, *face.holes) for k in ring}
        loose = [e for e in scene.edges if not of_faces.intersection((e.start, e.end))]
        if not loose:
            return scene, 0
        (view,), (edges,) = self.looked.views, self.looked.maps
        ends = scene.points[np.array([(e.start, e.end) for e in loose])]
        (fits,) = fit_sides(ends, self._find_sides_in_sight(ends)[:, None], [view], [edges])
        vertices = list(scene.vertices)
        updated = 0
        for k in np.flatnonzero(fits.good).tolist():
            pair = loose[k].start, loose[k].end
            pixels, _ = project_points(view.projection, ends[k])
            pixels = pixels + fits.offset[k, :, None] * fits.normal[k]
            across = np.outer(fits.normal[k], fits.normal[k])
            # Along it the readings say nothing, and a line of them asks for nothing.
            noise = (fits.variance[k, :, None, None] + extra_px**2) * factor * across
            noise += (
                compute_pixel_covs(self.given, ends[k]) * float(np.mean(self.looked.factors)) ** 2
            )
            known = [vertices[n].cov for n in pair]
            line = fit_line_to_points(ends[k], known)
            line, chi2 = line.seen(fit_image_line(pixels, noise), view.projection)
            if chi2 > GATE:
                continue
            for n, point, cov in zip(pair, ends[k], known, strict=True):
                on, cov_on = line.near(point, cov)
                vertices[n] = replace(vertices[n], point=on, cov=cov_on)
            updated += 1
        return replace(scene, vertices=tuple(vertices)), updated

    def _find_sides_in_sight(self, sides: FloatArray) -> NDArray[np.bool_]:
        """Return which sides (n, 2, 3) no face hides from the view, (n,)."""
        share = ((np.arange(PLACES) + 0.5) / PLACES)[:, None]
        places = (sides[:, :1] + share * (sides[:, 1:] - sides[:, :1])).reshape(-1, 3)
        uv, depth = project_points(self.looked.views[0].projection, places)
        seen = self.hidden.visible(np.nan_to_num(uv), depth) & (depth > 0)
        return np.asarray(seen.reshape(-1, PLACES).all(axis=1), dtype=np.bool_)
