"""Self-calibration: two unknowns of each camera, errors of its focal length and radial distortion.

A pixel p of a pinhole is seen at c + (1 + a) (1 + b r²) (p - c), with c the principal point and r
the tangent of the ray's angle to the axis (OpenCV's k1 is b). Views of one camera share both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import Camera, FloatArray, LensError, View

LENS_UNKNOWNS = 2
LEAST_VIEWS = 3
"""With fewer views of a camera, errors of its lens cannot be separated from those of its poses."""
ROUNDS = 20
"""Rounds of a fixed-point iteration: for a radial distortion of .3 at r = .5 the error shrinks by a
factor of .2 a round."""


@dataclass(frozen=True, eq=False, slots=True)
class Lenses:
    """Membership of V views in the C cameras with unknowns: `member` (V, C), 1 or 0; each
    view's principal point `centre` (V, 2) and focal lengths `focal` (V, 2), in px.
    """

    member: FloatArray
    centre: FloatArray
    focal: FloatArray

    @property
    def count(self) -> int:
        """Cameras with unknowns."""
        return int(self.member.shape[1])

    def of_views(self, values: FloatArray) -> FloatArray:
        """Return each view's share (V, ...) of the cameras' values (C, ...)."""
        return np.tensordot(self.member, values, axes=1)

    def of_cameras(self, values: FloatArray) -> FloatArray:
        """Return the sums (C, ...) over each camera's views of values (V, ...)."""
        return np.tensordot(self.member.T, values, axes=1)

    def some(self, chosen: Sequence[int]) -> "Lenses":
        """Return the lenses of the chosen views."""
        views = list(chosen)
        return Lenses(self.member[views], self.centre[views], self.focal[views])

    def seen(
        self, unknowns: FloatArray, uv: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return where pixels (n, V, 2) of pinholes are seen by lenses with these unknowns (C, 2).

        With their derivatives by the pixels (n, V, 2, 2) and by each view's unknowns (n, V, 2, 2).
        """
        a, b = np.moveaxis(self.of_views(unknowns), -1, 0)
        off = uv - self.centre
        r2 = ((off / self.focal) ** 2).sum(axis=-1)
        gain = 1.0 + b * r2
        turned = off[..., :, None] * (off / self.focal**2)[..., None, :]
        by_pixel = gain[..., None, None] * np.eye(2) + (2.0 * b)[:, None, None] * turned
        by_pixel = (1.0 + a)[:, None, None] * by_pixel
        known = self.member.sum(axis=1)[:, None] > 0
        by_focal = np.where(known, gain[..., None] * off, 0.0)
        by_radial = np.where(known, ((1.0 + a) * r2)[..., None] * off, 0.0)
        at = self.centre + ((1.0 + a) * gain)[..., None] * off
        return at, by_pixel, np.stack([by_focal, by_radial], axis=-1)

    def undistorted(self, unknowns: FloatArray, uv: FloatArray) -> FloatArray:
        """Remove the radial distortion from observed pixels (n, V, 2); the focal length stays."""
        a, b = np.moveaxis(self.of_views(unknowns), -1, 0)
        if not b.any():
            return uv
        off, focal = uv - self.centre, (1.0 + a)[:, None] * self.focal
        straight = off
        for _ in range(ROUNDS):
            r2 = ((straight / focal) ** 2).sum(axis=-1)
            straight = off / (1.0 + b * r2)[..., None]
        return self.centre + straight

    def errors(self, unknowns: FloatArray, sds: FloatArray) -> tuple[LensError, ...]:
        """Return the lens error of each view, by the cameras' unknowns and their sds (C, 2)."""
        rows = np.hstack([self.of_views(unknowns), self.of_views(sds)])
        return tuple(LensError(1.0 + a, b, *both) for a, b, *both in rows.tolist())


def group_lenses(views: Sequence[View]) -> Lenses:
    """Return the cameras of views; those of the same intrinsics are one."""
    cameras: dict[Camera, list[int]] = {}
    for k, view in enumerate(views):
        cameras.setdefault(view.camera, []).append(k)
    known = [taken for taken in cameras.values() if len(taken) >= LEAST_VIEWS]
    member = np.zeros((len(views), len(known)))
    for n, taken in enumerate(known):
        member[taken, n] = 1.0
    return Lenses(
        member,
        np.array([(v.camera.cx, v.camera.cy) for v in views]).reshape(-1, 2),
        np.array([(v.camera.fx, v.camera.fy) for v in views]).reshape(-1, 2),
    )
