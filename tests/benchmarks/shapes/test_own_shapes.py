"""Our own shapes are what their labels say: boxes closed and thick enough, the same by seed."""

import numpy as np
import pytest
import trimesh

from benchmarks.shapes.own_boxes import BOXES, LEAST_SIDE
from benchmarks.shapes.own_shapes import KINDS, OWN_SHAPES, make_own_shape
from facetlog.perception.types import FloatArray

# What lies on a box's faces sticks out by this share of its shortest side at most.
DETAIL = 0.03


def upright(seed: int) -> FloatArray:
    """The vertices of a shape in a frame in which up is z and its plan lies along its longest."""
    own = make_own_shape(seed)
    across = np.linalg.svd(own.up[None, :])[2][1:]
    return np.asarray(own.vertices @ np.vstack([across, own.up]).T)


def test_a_seed_gives_the_same_shape_and_others_another() -> None:
    one, again, other = make_own_shape(7), make_own_shape(7), make_own_shape(7 + len(KINDS))
    np.testing.assert_array_equal(one.vertices, again.vertices)
    assert one.name == other.name
    assert np.ptp(one.vertices, axis=0) != pytest.approx(np.ptp(other.vertices, axis=0))


@pytest.mark.parametrize("name", BOXES)
def test_box_fills_its_least_box_and_is_no_board(name: str) -> None:
    mesh = BOXES[name](np.random.default_rng(1))
    hull = trimesh.convex.convex_hull(mesh.vertices)
    sides = sorted(trimesh.bounds.oriented_bounds(hull)[1])
    assert sides[0] >= LEAST_SIDE * sides[2]
    assert hull.volume >= (1.0 - 4.0 * DETAIL) * np.prod(sides)


@pytest.mark.parametrize("label", ["table", "chair", "shelf", "cabinet_on_legs", "stairs"])
def test_furniture_stands_on_its_lowest_points(label: str) -> None:
    for seed in (s for s in range(OWN_SHAPES) if KINDS[s % len(KINDS)][1] == label):
        points = upright(seed)
        low = points[points[:, 2] <= points[:, 2].min() + 0.02 * np.ptp(points[:, 2])]
        # what it stands on spans most of its plan: it does not lie on its side or its head
        assert np.ptp(low[:, :2], axis=0).max() >= 0.4 * np.ptp(points[:, :2], axis=0).max()
