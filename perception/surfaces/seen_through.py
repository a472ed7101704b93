"""Which loose edges are no edges of anything: the ground shows through them.

Lines of a floor that agree by chance make edges in the air. Of a true one some solid hides the
ground along it, though it shows to either side.
"""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.row_table import Bools
from facetlog.perception.scene import Scene, SeenLattice
from facetlog.perception.surfaces.scene_from_tracks import without_unused
from facetlog.perception.types import FloatArray

__all__ = ["seen_through", "without_edges_seen_through"]

# Samples along an edge, but for its ends, which are the least certain.
SAMPLES = np.linspace(0.05, 0.95, 40)[:, None]
# So many points of a lattice to either side: beyond a leg and the windows that reach over it.
BESIDE = 5.0
# The ground shows more than this many times as often along an edge as beside it, if none is there:
# along true ones up to .4 times, along others .9 times and more.
AS_OFTEN = 0.7
# Points that show beside an edge: with fewer it stays.
FEWEST = 20


def without_edges_seen_through(scene: Scene) -> Scene:
    """The scene without loose edges through which the ground shows."""
    sides = {
        frozenset((a, b))
        for face in scene.faces
        for ring in (face.outline, *face.holes)
        for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)
    }
    loose = [n for n, e in enumerate(scene.edges) if frozenset((e.start, e.end)) not in sides]
    ends = np.array([(scene.edges[n].start, scene.edges[n].end) for n in loose], dtype=np.intp)
    gone = seen_through(scene.points[ends.reshape(-1, 2)], scene.lattices)
    if not gone.any():
        return scene
    wrong = {loose[n] for n in np.flatnonzero(gone).tolist()}
    edges = tuple(edge for n, edge in enumerate(scene.edges) if n not in wrong)
    return without_unused(scene, edges)


def seen_through(segments: FloatArray, lattices: Sequence[SeenLattice]) -> Bools:
    """Which segments (n, 2, 3) above the ground are seen through to it, by all views together."""
    samples = segments[:, None, 0] + SAMPLES * (segments[:, None, 1] - segments[:, None, 0])
    along, beside = np.zeros((2, len(segments)))
    for lattice in lattices:
        pitch = float(np.linalg.norm(lattice.steps[0]))
        normal = np.cross(*lattice.steps) / pitch**2
        for origin, shown in zip(lattice.origins, lattice.shown, strict=True):
            top = float((origin - lattice.corner) @ normal)
            up = normal if top > 0.0 else -normal
            top = abs(top)
            high = (samples - lattice.corner) @ up
            over = (high > BESIDE * pitch) & (high < top)
            below = np.where(over, top - high, 1.0)
            met = origin + (samples - origin) * (top / below)[..., None]
            at = (met - lattice.corner) @ lattice.steps.T / pitch**2
            run = at[:, -1] - at[:, 0]
            size = np.linalg.norm(run, axis=1)
            over &= size[:, None] > 0.0
            across = run[:, ::-1] * [-1.0, 1.0] / np.where(size > 0.0, size, 1.0)[:, None]
            along += _shown(shown, at, over)
            for side in (-BESIDE, BESIDE):
                beside += _shown(shown, at + side * across[:, None], over) / 2.0
    return np.asarray((beside >= FEWEST / 2.0) & (along > AS_OFTEN * beside))


def _shown(shown: Bools, at: FloatArray, over: Bools) -> FloatArray:
    """How many (n,) of the points nearest to places (n, k, 2), of those `over` it, are shown."""
    row, column = np.rint(at).astype(np.intp).transpose(2, 0, 1)
    rows, columns = shown.shape
    inside = over & (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    found = inside & shown[np.where(inside, row, 0), np.where(inside, column, 0)]
    counts: FloatArray = found.sum(axis=1).astype(np.float64)
    return counts
