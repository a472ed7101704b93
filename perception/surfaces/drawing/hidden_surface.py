"""Which face of a scene is foremost at each pixel of a view: a depth buffer over plane polygons."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.scene import Face, Scene
from facetlog.perception.surfaces.drawing.frustum import Frustum
from facetlog.perception.types import FloatArray, View

# The buffer needs no more detail than this; a larger picture gets a coarser one.
MAX_BUFFER_PX = 1280
SUBPIXEL_BITS = 4
# A point counts as hidden when a face lies in front of it by more than this share of its depth:
# points on a face are not hidden by that face, rounding and estimation errors included.
DEPTH_TOLERANCE = 0.01


@dataclass(frozen=True, eq=False, slots=True)
class HiddenSurface:
    """`face` (h, w): index of the foremost face or -1; `depth` (h, w) along the optical axis.

    A pixel of the picture times `scale` is a pixel of the buffer.
    """

    face: NDArray[np.int32]
    depth: FloatArray
    scale: float

    def visible(self, pixels: FloatArray, depth: FloatArray) -> NDArray[np.bool_]:
        """Return whether points at pixels (n, 2) and depths (n,) are in the picture with nothing
        before.

        A point near an outline is visible if it is from any of the nearest buffer pixels.
        """
        h, w = self.face.shape
        at = np.rint((pixels + 0.5) * self.scale - 0.5).astype(np.int64)
        inside = ((at >= 0) & (at < [w, h])).all(axis=1)
        seen = np.zeros(len(at), dtype=bool)
        for step in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
            u, v = np.clip(at + step, 0, [w - 1, h - 1]).T
            seen |= depth <= self.depth[v, u] * (1 + DEPTH_TOLERANCE)
        return np.asarray(seen & inside)


def is_facing_camera(face: Face, view: View) -> bool:
    """Return whether the camera is on the outer side of the face."""
    return bool(face.plane.distance(view.pose.centre) > 0)


def hidden_surface(view: View, scene: Scene) -> HiddenSurface:
    """Return the foremost of the scene's faces that turn to the camera, at each pixel of the
    view.
    """
    camera = view.camera
    scale = min(1.0, MAX_BUFFER_PX / max(camera.width, camera.height))
    h, w = max(1, round(camera.height * scale)), max(1, round(camera.width * scale))
    index = np.full((h, w), -1, dtype=np.int32)
    depth = np.full((h, w), np.inf)
    for number, face in enumerate(scene.faces):
        if not is_facing_camera(face, view):
            continue
        rings = project_rings(view, scene, face)
        if not rings:
            continue
        mask = np.zeros((h, w), dtype=np.uint8)
        scaled = [(ring + 0.5) * scale - 0.5 for ring in rings]
        fill(mask, scaled, 1)
        v, u = np.nonzero(mask)
        x = ((u + 0.5) / scale - 0.5 - camera.cx) / camera.fx
        y = ((v + 0.5) / scale - 0.5 - camera.cy) / camera.fy
        # A ray c + z R (x, y, 1) meets n · p + d = 0 at z = -(n · c + d) / (n · R (x, y, 1)).
        toward = np.column_stack([x, y, np.ones_like(x)]) @ (
            view.pose.rotation.T @ face.plane.normal
        )
        above = float(face.plane.distance(view.pose.centre))
        z = np.divide(-above, toward, out=np.full_like(toward, np.inf), where=toward < 0)
        nearer = z < depth[v, u]
        depth[v[nearer], u[nearer]] = z[nearer]
        index[v[nearer], u[nearer]] = number
    return HiddenSurface(index, depth, scale)


def project_rings(view: View, scene: Scene, face: Face) -> list[FloatArray]:
    """Return the outline and holes of a face in pixels, clipped to the view; empty if it is out of
    sight.
    """
    frustum = Frustum(view.camera, view.pose)
    points = scene.points
    rings = [frustum.polygon(points[list(ring)]) for ring in (face.outline, *face.holes)]
    return [ring for ring in rings if len(ring)] if len(rings[0]) else []


def fill(mask: NDArray[np.uint8], rings: list[FloatArray], value: int) -> None:
    """Set the pixels of a mask that lie inside the rings by the even-odd rule (holes stay)."""
    fixed = [np.rint(ring * (1 << SUBPIXEL_BITS)).astype(np.int32) for ring in rings]
    cv2.fillPoly(mask, fixed, value, lineType=cv2.LINE_8, shift=SUBPIXEL_BITS)
