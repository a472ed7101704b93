"""Which triangles are one object: parts whose surfaces come near each other, whether they share
corners or not, as a leg that ends within a table top, or a little below it, does not.
"""

from scipy.spatial import cKDTree

from facetlog.perception.shapes.clean_mesh import Surface
from facetlog.perception.shapes.grouped import Indices, joined
from facetlog.perception.shapes.surface_samples import Samples, thinned

__all__ = ["find_bodies"]

# Parts nearer than this share of the size of all are one object. Third-party models of furniture
# leave gaps of up to 2 % between legs and seat; chairs at a table keep more.
NEAR_SHARE = 0.02
# Samples are thinned to cells of half of that, whose diagonal (√3 halves) is less than it: parts
# that cross the same cell are found whichever samples were kept.
CELL_SHARE = 0.5 * NEAR_SHARE


def find_bodies(surface: Surface, samples: Samples) -> Indices:
    """The object (m,) of each triangle, numbered from 0; `samples` of the whole surface."""
    count = int(surface.bodies.max()) + 1
    if count == 1:
        return surface.bodies
    groups = surface.bodies[samples.triangles]
    kept, _, _ = thinned(samples.points, samples.areas, groups, CELL_SHARE * surface.size)
    points, groups = samples.points[kept], groups[kept]
    pairs = cKDTree(points).query_pairs(NEAR_SHARE * surface.size, output_type="ndarray")
    met = groups[pairs]
    met = met[met[:, 0] != met[:, 1]]
    _, together = joined(count, met)
    return together[surface.bodies]
