"""Clouds into scenes: faces with corners and outer sides, objects, up, and what is not known."""

import numpy as np
import pytest

from facetlog.perception.facts.all_facts import fact_rows, scene_facts
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.shapes.regions.floor_and_walls import FROM_FLOOR, HELD_OTHERWISE
from facetlog.perception.shapes.regions.point_bodies import cluster_bodies
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import (
    box_points,
    boxes_points,
    cylinder_points,
    rectangle,
    turned,
)

SIZE = (3.0, 2.0, 1.0)
X, Y, Z = np.eye(3)


def lengths(scene: Scene) -> list[float]:
    points = scene.points
    return sorted(float(np.linalg.norm(points[e.start] - points[e.end])) for e in scene.edges)


def table(count: int = 20_000, noise: float = 0.0) -> FloatArray:
    """A table 1.2 × 0.8 × 0.7 with legs of 8 cm, its top 6 cm thick, closed all round."""
    parts = [((1.2, 0.8, 0.06), (0.0, 0.0, 0.64))]
    parts += [((0.08, 0.08, 0.64), (x, y, 0.0)) for x in (0.0, 1.12) for y in (0.0, 0.72)]
    return boxes_points(*parts, count=count, noise=noise)


@pytest.mark.parametrize("noise", [0.0, 0.005 * np.sqrt(14.0)])
@pytest.mark.slow
def test_box_has_eight_corners_twelve_edges_and_looks_outwards(noise: float) -> None:
    points = turned(box_points(SIZE, 12_000, noise=noise))
    scene = make_cloud_scene(Cloud.of(points))
    assert len(scene.faces) == 6
    assert all(len(face.outline) == 4 for face in scene.faces)
    assert len({vertex for face in scene.faces for vertex in face.outline}) == 8
    np.testing.assert_allclose(lengths(scene), np.repeat([1.0, 2.0, 3.0], 4), atol=0.02)
    middle = points.mean(axis=0)
    assert all(float(face.plane.distance(middle)) < 0.0 for face in scene.faces)
    assert [body.whole for body in scene.bodies] == [True]
    convex = [fact for fact in scene_facts(scene) if fact.functor == "convex"]
    assert len(convex) == 24


def test_points_in_the_air_beside_an_edge_do_not_widen_the_object() -> None:
    rng = np.random.default_rng(0)
    points = box_points(SIZE, 6000, noise=0.002)
    # flying points as depth sensors make them: few, close together, off an edge
    cluster = np.array([SIZE[0] + 0.08, 0.5, 0.5]) + rng.normal(0.0, 0.01, (12, 3))
    clean, flying = (make_cloud_scene(Cloud.of(p)) for p in (points, np.vstack([points, cluster])))
    assert len(clean.faces) == len(flying.faces) == 6
    assert np.ptp(flying.points, axis=0) == pytest.approx(np.ptp(clean.points, axis=0), abs=0.02)


def floor_and_boxes() -> FloatArray:
    rng = np.random.default_rng(0)
    floor = rectangle(rng, 20_000, np.array([-2.0, -2.0, 0.0]), 4.0 * X, 4.0 * Y)
    boxes = [
        box_points((0.4, 0.3, 0.5), 3000, seed=k, sides=("-x", "+x", "-y", "+y", "+z")) + place
        for k, place in enumerate(([-1.0, -1.0, 0.0], [0.5, 0.5, 0.0]))
    ]
    # no scanner sees what the boxes stand on
    under = [
        ((floor[:, :2] > p) & (floor[:, :2] < np.add(p, (0.4, 0.3)))).all(axis=1)
        for p in ((-1.0, -1.0), (0.5, 0.5))
    ]
    points = np.vstack([floor[~np.any(under, axis=0)], *boxes])
    return points + rng.normal(0.0, 0.003, points.shape)


def test_up_is_found_from_the_floor_and_boxes_on_it_are_two_objects() -> None:
    scene = make_cloud_scene(Cloud.of(turned(floor_and_boxes(), 4)))
    up = turned(Z[None], 4)[0]
    assert scene.up is not None
    assert float(scene.up @ up) > 0.9999
    assert any("up was found from the plane" in said for said in scene.warnings)
    assert sorted(len(body.faces) for body in scene.bodies) == [5, 5]
    assert all(body.whole for body in scene.bodies)  # seen all round, but from below
    floor = set(range(len(scene.faces))) - {i for body in scene.bodies for i in body.faces}
    assert len(floor) == 1
    assert float(scene.faces[floor.pop()].plane.normal @ up) > 0.999
    scene_facts(scene)


def box_on_a_floor(
    noise: float | FloatArray = 0.001, seed: int = 0, count: int = 12_000
) -> FloatArray:
    """A box of 40 × 30 × 25 cm amid a floor of 2 m, its noise that of all points or of each."""
    rng = np.random.default_rng(seed)
    floor = rectangle(rng, round(0.895 * count), np.array([-1.0, -1.0, 0.0]), 2.0 * X, 2.0 * Y)
    sides = ("-x", "+x", "-y", "+y", "+z")
    box = box_points((0.4, 0.3, 0.25), count - len(floor), seed=seed, sides=sides)
    points = np.vstack([floor, box - [0.2, 0.15, 0.0]])
    return points + rng.normal(size=points.shape) * noise


def strays(count: int, place: str) -> FloatArray:
    low, high = {
        "above": ([-2.0, -2.0, 0.5], [2.0, 2.0, 2.5]),
        "below": ([-1.0, -1.0, -3.0], [1.0, 1.0, -0.05]),
        "near": ([-0.8, -0.8, 0.0], [0.8, 0.8, 0.6]),
        "far": ([-100.0, -100.0, -100.0], [100.0, 100.0, 100.0]),
    }[place]
    return np.random.default_rng(count).uniform(low, high, (count, 3))


def checked_box(scene: Scene) -> None:
    """The floor is no thing's, and the one thing with faces is the box."""
    (body,) = (body for body in scene.bodies if body.faces)
    assert len(body.faces) == 5
    corners = scene.points[[i for face in body.faces for i in scene.faces[face].outline]]
    np.testing.assert_allclose(np.ptp(corners, axis=0), [0.4, 0.3, 0.25], atol=0.02)
    assert len(scene.faces) > 5


@pytest.mark.parametrize("place", ["above", "below", "near", "far"])
@pytest.mark.parametrize("count", [1, 10, 100])
def test_strays_change_no_floor_and_no_box(count: int, place: str) -> None:
    points = np.vstack([box_on_a_floor(), strays(count, place)])
    scene = make_cloud_scene(Cloud.of(points), up=Z)
    checked_box(scene)
    if place == "far":
        assert scene.warnings == (
            f"{count} of {len(points)} points left out: they lie alone, far from any surface",
        )


@pytest.mark.parametrize("walls", [2, 4, 5])
@pytest.mark.slow
def test_walls_and_ceiling_of_a_room_are_no_things(walls: int) -> None:
    rng = np.random.default_rng(0)
    low, high = np.array([-1.5, -1.5, 0.0]), np.array([1.5, 1.5, 0.0])
    sheets = [
        (low, 3.0 * X, 3.0 * Y),
        (low, 3.0 * X, 2.0 * Z),
        (low, 3.0 * Y, 2.0 * Z),
        (high, -3.0 * X, 2.0 * Z),
        (high, -3.0 * Y, 2.0 * Z),
        (low + 2.0 * Z, 3.0 * X, 3.0 * Y),
    ]
    room = [rectangle(rng, 5000, *sheet) for sheet in sheets[: walls + 1]]
    box = box_points((0.8, 0.6, 0.5), 2000, sides=("-x", "+x", "-y", "+y", "+z"))
    points = np.vstack([*room, box])
    points += rng.normal(0.0, 0.002, points.shape)
    scene = make_cloud_scene(Cloud.of(turned(points, 5)), up=turned(Z[None], 5)[0])
    assert [len(body.faces) for body in scene.bodies] == [5]
    around = set(range(len(scene.faces))) - set(scene.bodies[0].faces)
    assert len(around) == walls + 1
    middle = turned(np.array([[0.0, 0.0, 1.0]]), 5)[0]
    assert all(float(scene.faces[i].plane.distance(middle)) > 0.0 for i in around)


@pytest.mark.slow
def test_up_is_not_known_where_nothing_is_a_floor() -> None:
    for points in (box_points(SIZE, 4000, noise=0.01), table(6000, noise=0.002)):
        scene = make_cloud_scene(Cloud.of(points))
        assert scene.up is None
        assert scene.warnings == ()


def test_up_is_that_of_the_cameras_where_there_is_no_floor() -> None:
    ups = np.array([[0.0, -1.0, 0.1], [0.1, -1.0, 0.0], [0.0, -1.0, -0.1]])
    ups /= np.linalg.norm(ups, axis=1)[:, None]
    points = box_points(SIZE, 4000, noise=0.01)
    scene = make_cloud_scene(Cloud.of(points, camera_ups=ups))
    assert scene.up is not None
    assert float(scene.up @ -Y) > 0.99
    assert any("cameras" in said for said in scene.warnings)


@pytest.mark.slow
def test_a_floor_goes_before_cameras_that_look_straight_down() -> None:
    # along z their up lies in the floor
    down = make_cloud_scene(Cloud.of(floor_and_boxes(), camera_ups=np.tile(-Y, (3, 1))))
    assert down.up is not None
    assert float(down.up @ Z) > 0.9999
    assert HELD_OTHERWISE in down.warnings
    upright = make_cloud_scene(Cloud.of(floor_and_boxes(), camera_ups=np.tile(Z, (3, 1))))
    assert upright.up is not None
    assert float(upright.up @ Z) > 0.9999
    assert FROM_FLOOR in upright.warnings


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_single_sheet_looks_to_where_it_was_seen_from(side: float) -> None:
    rng = np.random.default_rng(0)
    points = rectangle(rng, 2000, np.zeros(3), X, Y)
    seen = np.tile(side * 5.0 * Z, (2000, 1))
    by_place = make_cloud_scene(Cloud.of(points, seen_from=seen))
    by_normal = make_cloud_scene(Cloud.of(points, normals=np.sign(seen)))
    for scene in (by_place, by_normal):
        assert len(scene.faces) == 1
        assert float(scene.faces[0].plane.normal @ Z) == pytest.approx(side)


def test_window_is_a_hole_in_its_wall() -> None:
    rng = np.random.default_rng(0)
    wall = rectangle(rng, 12_000, np.zeros(3), 3.0 * X, 2.0 * Z)
    window = (np.abs(wall[:, 0] - 1.5) < 0.5) & (np.abs(wall[:, 2] - 1.0) < 0.4)
    scene = make_cloud_scene(Cloud.of(wall[~window]))
    (face,) = scene.faces
    assert len(face.outline) == 4
    assert len(face.holes) == 1
    hole = scene.points[list(face.holes[0])]
    np.testing.assert_allclose(np.ptp(hole, axis=0)[[0, 2]], [1.0, 0.8], atol=0.03)
    # a corner of the hole that no point marks may be cut off
    assert len(hole) <= 6


@pytest.mark.parametrize("count", [250, 320])
def test_a_block_strewn_so_thinly_that_one_looks_through_it_is_not_whole(count: int) -> None:
    for seed in range(4):
        scene = make_cloud_scene(Cloud.of(box_points(SIZE, count, seed=seed)), up=Z)
        assert len(scene.faces) == 6 or not fact_rows(scene, {"whole"})["whole"]


@pytest.mark.parametrize("walls", [1, 2, 4])
@pytest.mark.slow
def test_an_empty_room_in_metres_is_no_thing(walls: int) -> None:
    rng = np.random.default_rng(walls)
    a, b, h = 3.0 * X, 2.2 * Y, 2.4 * Z
    sheets = [(0.0 * X, a, h), (0.0 * X, b, h), (b, a, h), (a, b, h)][:walls]
    points = np.concatenate(
        [rectangle(rng, 3000, 0.0 * X, a, b), *(rectangle(rng, 3000, *each) for each in sheets)]
    )
    points += rng.normal(0.0, 0.002, points.shape)
    scene = make_cloud_scene(Cloud.of(points), up=Z, metric=True)
    assert len(scene.faces) == walls + 1
    assert not any(body.faces for body in scene.bodies)
    # of a carton of the same shape nobody says so
    carton = make_cloud_scene(Cloud.of(points / 4.0), up=Z, metric=True)
    assert any(body.faces for body in carton.bodies)
    assert not fact_rows(scene, {"thing_size"}).get("thing_size")


def test_scene_turns_and_scales_with_its_cloud() -> None:
    points = box_points(SIZE, 6000, noise=0.01)
    one, two = (make_cloud_scene(Cloud.of(p)) for p in (points, 1000.0 * turned(points)))
    assert len(one.faces) == len(two.faces) == 6
    np.testing.assert_allclose(1000.0 * np.array(lengths(one)), lengths(two), rtol=1e-3)


@pytest.mark.slow
def test_table_top_looks_up_and_its_underside_down() -> None:
    scene = make_cloud_scene(Cloud.of(table(noise=0.002)), up=Z)
    level = [f for f in scene.faces if abs(f.plane.normal @ Z) > 0.99]
    top = [f for f in level if abs(f.plane.distance(np.array([0.6, 0.4, 0.7]))) < 0.01]
    under = [f for f in level if abs(f.plane.distance(np.array([0.6, 0.4, 0.64]))) < 0.01]
    assert [bool(f.plane.normal @ Z > 0.0) for f in top] == [True]
    assert not any(f.plane.normal @ Z > 0.0 for f in under)
    assert len(under) >= 1
    assert len(top[0].outline) == 4
    assert len(scene.bodies) == 1


def test_cylinder_wall_gives_no_box() -> None:
    scene = make_cloud_scene(Cloud.of(cylinder_points(0.3, 0.6, 8000, 0.002)))
    areas = sum(float(p.areas.sum()) for p in scene.patches)
    assert areas > 0.85 * 2.0 * np.pi * 0.3 * 0.6


def test_a_box_that_is_noisier_than_its_floor_reaches_no_further() -> None:
    still = box_on_a_floor(0.0)
    on_box = (np.abs(still[:, :2]) <= [0.2, 0.15]).all(axis=1) & (still[:, 2] > 0.0)
    points = box_on_a_floor(np.where(on_box, 0.01, 0.001)[:, None])
    scene = make_cloud_scene(Cloud.of(points), up=Z)
    (body,) = (body for body in scene.bodies if body.faces)
    assert len(body.faces) == 5
    assert not any(patch.areas.any() for patch in scene.patches)


@pytest.mark.parametrize("apart", [0.5, 0.8])
@pytest.mark.slow
def test_boxes_near_a_floors_corners_stand_on_it(apart: float) -> None:
    rng = np.random.default_rng(0)
    floor = rectangle(rng, 15_000, np.array([-1.2, -1.2, 0.0]), 2.4 * X, 2.4 * Y)
    boxes = [
        box_points((0.4, 0.3, 0.25), 1200, seed=k, sides=("-x", "+x", "-y", "+y", "+z"))
        + np.array([x * apart - 0.2, y * apart - 0.15, 0.0])
        for k, (x, y) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1)))
    ]
    points = np.vstack([floor, *boxes])
    scene = make_cloud_scene(Cloud.of(points + rng.normal(0.0, 0.001, points.shape)), up=Z)
    assert [len(body.faces) for body in scene.bodies] == [5, 5, 5, 5]


@pytest.mark.slow
def test_an_empty_shell_is_a_thing() -> None:
    points = box_points((3.0, 3.0, 2.0), 12_000, noise=0.002)
    scene = make_cloud_scene(Cloud.of(points), up=Z)
    assert [len(body.faces) for body in scene.bodies] == [6]


def test_a_region_is_of_one_object_though_its_points_are_far_apart() -> None:
    rng = np.random.default_rng(0)
    halves = [rng.uniform(size=(200, 3)) * 0.1 + [x, 0.0, 0.0] for x in (0.0, 1.0)]
    points = np.vstack(halves)
    alone = cluster_bodies(points, np.full(400, -1), 0.02)
    joined = cluster_bodies(points, np.zeros(400, dtype=np.intp), 0.02)
    assert set(alone.tolist()) == {0, 1}
    assert set(joined.tolist()) == {0}
