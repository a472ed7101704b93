"""Points all over faces: as many as a grid has within them, and none outside."""

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.space.surface_points import inner_points


def face(polygon: shapely.Geometry) -> FlatFace:
    """A face in the plane z = 2 with that polygon."""
    return FlatFace(
        0,
        ((0, 1, 2),),
        (0, 1, 2),
        np.array([0.0, 0.0, 1.0]),
        np.array([0.0, 0.0, 2.0]),
        np.zeros((3, 3, 3)),
        np.eye(3)[:2],
        1.0,
        np.zeros((3, 3)),
        polygon,
    )


def polygon(seed: int) -> shapely.Geometry:
    """A star, with a hole, or in two parts."""
    rng = np.random.default_rng(seed)
    turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, 9))
    ring = np.column_stack([np.cos(turn), np.sin(turn)]) * rng.uniform(0.3, 1.5, (9, 1))
    whole = shapely.Polygon(ring).buffer(0.0)
    hole = shapely.box(*(rng.uniform(-0.3, 0.0, 2)), *(rng.uniform(0.05, 0.3, 2)))
    return shapely.difference(whole, hole) if seed % 2 else shapely.union(whole, hole)


@settings(max_examples=15)
@given(st.lists(st.integers(0, 10_000), min_size=1, max_size=4), st.floats(0.06, 0.4))
def test_every_place_on_a_face_has_a_point_near_and_no_point_is_off_it(
    seeds: list[int], spacing: float
) -> None:
    polygons = [polygon(seed) for seed in seeds]
    points, of = inner_points([face(each) for each in polygons], spacing)
    assert sorted(set(of.tolist())) == list(range(len(polygons)))
    every = shapely.union_all(polygons)
    assert ((points[:, 2] < 2.0) & (points[:, 2] > 1.999)).all()
    dots = shapely.points(points[:, :2])
    assert (shapely.distance(dots, every) <= 1e-5).all()
    covered = shapely.union_all(shapely.buffer(dots, spacing))
    assert shapely.difference(every, covered).area <= 1e-5


def test_no_face_and_a_face_without_area_have_no_points() -> None:
    assert inner_points([], 0.1)[0].shape == (0, 3)
    assert inner_points([face(shapely.Polygon())], 0.1)[0].shape == (0, 3)
