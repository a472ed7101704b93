"""Where one more view shows the corners of a scene that is known."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.corner_tracks import Corners, track_corners
from facetlog.perception.detection.line_front_end.faces_from_lines import Pictures
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.detection.working_size import in_own_pixels
from facetlog.perception.online.in_sight import in_sight
from facetlog.perception.scene import Evidence, Scene
from facetlog.perception.surfaces.drawing.hidden_surface import HiddenSurface, faces_camera
from facetlog.perception.types import FloatArray

__all__ = ["CornerReadings", "corner_readings"]


@dataclass(frozen=True, eq=False, slots=True)
class CornerReadings:
    """Pixels (n, 2) of the scene's vertices with covariances (n, 2, 2), where `seen` (n,)."""

    uv: FloatArray
    cov: FloatArray
    seen: NDArray[np.bool_]


def corner_readings(scene: Scene, looked: Pictures, hidden: HiddenSurface) -> CornerReadings:
    """Where the one view of `looked` shows the vertices of measured faces: there its edges meet.

    `hidden` is what that view sees of the scene's faces.
    """
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
    shown = corners.sides_shown(turned[:, None])[:, 0] & in_sight(hidden, corners.segments, view)
    fits = fit_sides(corners.segments, shown[:, None], [view], [edges])
    for vertex, track in enumerate(track_corners(corners, [view], fits)):
        for seen in in_own_pixels(track, looked.factors).observations:
            readings.uv[vertex], readings.cov[vertex] = seen.uv, seen.cov
            readings.seen[vertex] = True
    return readings
