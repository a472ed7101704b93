"""Points view by view: each view updates them once, in constant time for each view.

The paper's recursion (section 4.1) from an estimated start: a point's first views are held until
they determine it well enough to linearise further ones at it (`estimate_points`, which also leaves
out outliers); from then on each view is one step of the filter, gated by its innovation.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.perception.estimation.incidence import GATE, MAX_HELD, SURE_SD, updated
from facetlog.perception.estimation.point_filter import estimate_points, pixel_incidence
from facetlog.perception.types import FloatArray

BoolArray = NDArray[np.bool_]


def update_by_view(
    projection: FloatArray, points: FloatArray, covs: FloatArray, uv: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return points (n, 3) and covariances (n, 3, 3) updated by a view with this projection (3, 4),
    which shows them at pixels `uv` (n, 2), `noise` (n, 2, 2); and the inliers (n,), others are
    unchanged.
    """
    after, covs_after, chi2 = updated(pixel_incidence(projection), points, covs, uv, noise)
    taken: BoolArray = chi2 <= GATE
    return (
        np.where(taken[:, None], after, points),
        np.where(taken[:, None, None], covs_after, covs),
        taken,
    )


class PointFilters:
    """n points, each with its filter. Points (n, 3) and covariances (n, 3, 3), in the unit of the
    projections, are NaN where `known` (n,) is false: not seen well enough yet.

    `views` (n,) is how many views each point took, the held ones of its start included.
    """

    def __init__(self, count: int) -> None:
        self.points: FloatArray = np.full((count, 3), np.nan)
        self.covs: FloatArray = np.full((count, 3, 3), np.nan)
        self.known: BoolArray = np.zeros(count, np.bool_)
        self.views: NDArray[np.intp] = np.zeros(count, np.intp)
        self._projections: list[FloatArray] = []
        self._held: list[tuple[FloatArray, FloatArray, BoolArray]] = []

    def add(
        self, projection: ArrayLike, uv: ArrayLike, cov: ArrayLike, seen: ArrayLike
    ) -> BoolArray:
        """Add one more view, and return the points (n,) for which it is an outlier; those stay.

        `projection` (3, 4); pixels `uv` (n, 2) and `cov` (n, 2, 2) where `seen` (n,).
        """
        P = np.array(projection, dtype=np.float64)
        pixels, noise = np.array(uv, dtype=np.float64), np.array(cov, dtype=np.float64)
        here = np.array(seen, dtype=np.bool_)
        refused = np.zeros(len(self.points), np.bool_)
        old = np.flatnonzero(here & self.known)
        refused[old] = ~self._update(old, P, pixels[old], noise[old])
        self._projections = [*self._projections, P][-MAX_HELD:]
        self._held = [*self._held, (pixels, noise, here & ~self.known)][-MAX_HELD:]
        self._start()
        return refused

    def _update(
        self, rows: NDArray[np.intp], P: FloatArray, uv: FloatArray, noise: FloatArray
    ) -> BoolArray:
        # Which of some known points take a view, after that they have.
        if not len(rows):
            return np.zeros(0, np.bool_)
        self.points[rows], self.covs[rows], taken = update_by_view(
            P, self.points[rows], self.covs[rows], uv, noise
        )
        self.views[rows] += taken
        return taken

    def _start(self) -> None:
        # Those that this view showed, of which the held views know enough.
        asked = np.flatnonzero(self._held[-1][2])
        if not len(asked) or len(self._held) < 2:
            return
        uv, noise = (np.stack([h[k][asked] for h in self._held], axis=1) for k in (0, 1))
        seen: BoolArray = np.stack([h[2][asked] for h in self._held], axis=1)
        P = np.array(self._projections)
        points, covs, used, ok = estimate_points(uv, noise, seen, P)
        pinholes = -np.linalg.solve(P[:, :, :3], P[:, :, 3:])[..., 0]
        away = np.linalg.norm(points[:, None] - pinholes, axis=-1).min(axis=1)
        with np.errstate(invalid="ignore"):
            sure = ok & (np.trace(covs, axis1=1, axis2=2) <= (SURE_SD * away) ** 2)
        new = asked[sure]
        self.points[new], self.covs[new] = points[sure], covs[sure]
        self.known[new] = True
        self.views[new] = used[sure].sum(axis=1)
        # Two views that agree too little to be a start by themselves may both be right.
        for h, (view, left_out) in enumerate(zip(P, (seen & ~used)[sure].T, strict=True)):
            rows = np.flatnonzero(left_out)
            self._update(new[rows], view, uv[sure][rows, h], noise[sure][rows, h])
