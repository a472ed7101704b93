"""Whether what goes round a place is an empty shell, or a room in which something stands."""

from facetlog.perception.types import FloatArray

# What is nearer than this share of the way to the shell stands before it; noise of a shell, or a
# board on it, is further off.
BEFORE = 0.8
# Less than this share of the points is noise, or a rim that stands out.
LEAST_SHARE = 0.05
# Numbers in a table of points and sides: 80 MB.
MOST_AT_ONCE = 10_000_000


def is_empty_shell(shell: FloatArray, points: FloatArray, place: FloatArray) -> bool:
    """Return whether next to nothing of points (n, 3) stands between a place (3,) and the convex
    hull of the `shell` (k, 3); False where the place is not within it.

    Of a shell nothing tells whether it is a room or a thing: that differs in size alone.
    """
    from scipy.spatial import ConvexHull, QhullError  # loaded only now: few scenes need it

    try:
        sides = ConvexHull(shell).equations
    except (QhullError, ValueError):  # flat, or too few points
        return False
    depth = -(sides[:, :3] @ place + sides[:, 3])
    if not (depth > 0.0).all():
        return False
    # along a ray p + t r a side is met at t = depth / (n · r)
    outwards = (sides[:, :3] / depth[:, None]).T  # 1 at the hull
    # A curved shell has as many sides as points: few points at a time, or they take all memory.
    several = max(1, MOST_AT_ONCE // len(sides))
    before = sum(
        int((((points[k : k + several] - place) @ outwards).max(axis=1) < BEFORE).sum())
        for k in range(0, len(points), several)
    )
    return before <= LEAST_SHARE * len(points)
