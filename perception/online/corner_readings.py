"""Where one more view shows the corners of a scene that is known."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.corner_tracks import Corners, track_corners
from facetlog.perception.detection.line_front_end.faces_from_lines import Pictures
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.detection.working_size import in_own_pixels
from facetlog.perception.scene import Evidence, Scene
from facetlog.perception.surfaces.drawing.hidden_surface import faces_camera, hidden_surface
from facetlog.perception.types import FloatArray, View

__all__ = ["CornerReadings", "corner_readings"]

# Places along a side that must be seen for it to be looked for.
PLACES = 5


@dataclass(frozen=True, eq=False, slots=True)
class CornerReadings:
    """Pixels (n, 2) of the scene's vertices with covariances (n, 2, 2), where `seen` (n,)."""

    uv: FloatArray
    cov: FloatArray
    seen: NDArray[np.bool_]


def corner_readings(scene: Scene, looked: Pictures) -> CornerReadings:
    """Where the one view of `looked` shows the vertices of measured faces: there its edges meet."""
    (view,), (edges,) = looked.views, looked.maps
    count = len(scene.vertices)
    readings = CornerReadings(
        np.zeros((count, 2)),
        np.tile(np.eye(2), (count, 1, 1)),
        np.zeros(count, np.bool_),
    )
    faces = [face for face in scene.faces if face.evidence is Evidence.MEASURED]
    if not faces:
        return readings
    corners = Corners(
        scene.points, tuple(f.outline for f in faces), tuple(tuple(f.holes) for f in faces)
    )
    turned = np.array([faces_camera(face, view) for face in faces])
    shown = corners.sides_shown(turned[:, None])[:, 0] & _in_sight(scene, corners.segments, view)
    fits = fit_sides(corners.segments, shown[:, None], [view], [edges])
    for vertex, track in enumerate(track_corners(corners, [view], fits)):
        for seen in in_own_pixels(track, looked.factors).observations:
            readings.uv[vertex], readings.cov[vertex] = seen.uv, seen.cov
            readings.seen[vertex] = True
    return readings


def _in_sight(scene: Scene, sides: FloatArray, view: View) -> NDArray[np.bool_]:
    share = ((np.arange(PLACES) + 0.5) / PLACES)[:, None]
    places = (sides[:, :1] + share * (sides[:, 1:] - sides[:, :1])).reshape(-1, 3)
    uv, depth = project_points(view.projection, places)
    seen = hidden_surface(view, scene).visible(np.nan_to_num(uv), depth) & (depth > 0)
    return np.asarray(seen.reshape(-1, PLACES).all(axis=1), dtype=np.bool_)
