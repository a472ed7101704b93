"""Planes through groups of triangles, all groups at once, and how flat each group is."""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.ragged import Indices, sum_by_group
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface
from facetlog.perception.types import FloatArray

# A plane is as certain as from so many independent points: a face's deviation from flatness is a
# bow or a twist, not noise, so more triangles do not make it more certain. Four bear a rectangle.
INDEPENDENT = 4.0


@dataclass(frozen=True, eq=False, slots=True)
class Fits:
    """Least-squares planes of r groups of triangles, weighted by area.

    `middles` (r, 3) of the area; `normals` (r, 3) along the mean of the triangles' own; `rms` (r,)
    distance of the surface from its plane; `variances` (r, 2) of the surface along its two
    directions `axes` (r, 2, 3), the shorter first; `spreads` (r,) rms angle of the triangles'
    normals from their mean, radians.
    """

    areas: FloatArray
    middles: FloatArray
    normals: FloatArray
    rms: FloatArray
    variances: FloatArray
    axes: FloatArray
    spreads: FloatArray

    @property
    def breadths(self) -> FloatArray:
        """The shorter side (r,) of a rectangle with the same variance, s² / 12."""
        breadths: FloatArray = np.sqrt(12.0 * self.variances[:, 0])
        return breadths


@dataclass(frozen=True, eq=False, slots=True)
class Moments:
    """Sums over r groups of triangles: areas (r,), middles (r, 3), scatter (r, 3, 3), normals (r,
    3).

    `scatter` is ∫ (x - middle)(x - middle)ᵀ over the group's surface, `normals` are ∫ n.
    """

    areas: FloatArray
    middles: FloatArray
    scatter: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, surface: Surface, rows: Indices, groups: Indices, count: int) -> "Moments":
        """Return moments of `count` groups, each with a triangle; rows[i] is of the group
        groups[i].

        A triangle with corners v and area A has ∫ x xᵀ = A / 12 (Σ v vᵀ + (Σ v)(Σ v)ᵀ).
        """
        areas, triangles = surface.areas[rows], surface.triangles[rows]
        whole = sum_by_group(groups, areas, count)
        corners = [surface.points[triangles[:, k]] for k in range(3)]
        sums = corners[0] + corners[1] + corners[2]
        middles = sum_by_group(groups, areas[:, None] * sums, count) / (3.0 * whole[:, None])
        # about each group's own middle, else small groups far out lose their digits
        about = middles[groups]
        corners = [corner - about for corner in corners]
        corners.append(sums - 3.0 * about)
        scatter = np.empty((count, 3, 3))
        for i in range(3):
            for j in range(i, 3):
                square = sum((c[:, i] * c[:, j] for c in corners), start=np.zeros(len(rows)))
                moment = sum_by_group(groups, areas * square, count) / 12.0
                scatter[:, i, j] = scatter[:, j, i] = moment
        normals = sum_by_group(groups, areas[:, None] * surface.normals[rows], count)
        return cls(whole, middles, scatter, normals)

    def joined(self, groups: Indices, count: int) -> "Moments":
        """Return moments of `count` groups of these groups; groups[i] is that of i, or -1:
        of none.
        """
        used = np.flatnonzero(groups >= 0)
        groups, areas = groups[used], self.areas[used]
        whole = sum_by_group(groups, areas, count)
        middles = sum_by_group(groups, areas[:, None] * self.middles[used], count) / whole[:, None]
        off = self.middles[used] - middles[groups]
        # ∫ about the common middle = ∫ about the own one + A (m - M)(m - M)ᵀ
        scatter = self.scatter[used] + areas[:, None, None] * off[:, :, None] * off[:, None]
        flat = sum_by_group(groups, scatter.reshape(-1, 9), count).reshape(-1, 3, 3)
        return Moments(whole, middles, flat, sum_by_group(groups, self.normals[used], count))

    def fits(self) -> Fits:
        """Return the plane of each group."""
        values, vectors = np.linalg.eigh(self.scatter / self.areas[:, None, None])
        values = np.maximum(values, 0.0)
        mean = self.normals / self.areas[:, None]
        length = np.sqrt((mean * mean).sum(axis=1))
        normals = vectors[:, :, 0]
        against = (normals * mean).sum(axis=1) < 0.0
        return Fits(
            self.areas,
            self.middles,
            np.where(against[:, None], -normals, normals),
            np.sqrt(values[:, 0]),
            values[:, 1:],
            np.swapaxes(vectors[:, :, 1:], 1, 2),
            # mean cosine 1 - σ² / 2
            np.sqrt(2.0 * np.maximum(1.0 - length, 0.0)),
        )


def make_fitted_plane(fits: Fits, group: int, size: float, step: float = 0.0) -> Plane:
    """Return the plane of one group with its covariance, about the surface's own middle.

    With sd the rms distance, not less than the resolution of `size`, nor than step / √12 where
    coordinates were rounded to multiples of `step`: tilt about the in-plane axis
    e has variance sd² / (n λ), λ the variance of the surface across e; the offset at the middle
    has sd² / n; n = 4. Along an axis all corners are rounded alike: then the offset has step² / 12.
    """
    rounding = step / np.sqrt(12.0)
    sd = max(float(fits.rms[group]), RESOLUTION * size, rounding)
    middle, normal = fits.middles[group], fits.normals[group]
    tilt = np.zeros((3, 3))
    for variance, axis in zip(fits.variances[group], fits.axes[group], strict=True):
        # a piece narrower than the resolution has no meaningful tilt
        floor = (RESOLUTION * size) ** 2
        tilt += sd**2 / (INDEPENDENT * max(float(variance), floor)) * np.outer(axis, axis)
    lever = np.vstack([np.eye(3), -middle])
    cov = lever @ tilt @ lever.T
    cov[3, 3] += max(sd**2 / INDEPENDENT, rounding**2)
    return Plane(normal, float(-normal @ middle), cov)
