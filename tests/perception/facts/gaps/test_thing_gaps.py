"""The least distance of two things: known solids, any triangles, and its standard deviation."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.facts.gaps.thing_gaps import gaps
from facetlog.perception.flat_faces import Estimate
from facetlog.perception.scene import Edge, Face, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    chair,
    cuboid,
    fit_plane_through_loop,
    moved,
    polyhedron,
    pyramid,
    stick_table,
    table,
    together,
)
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.things import Thing

SIZE = (0.254, 0.2032, 0.1524)  # the default cuboid


def gap(scene: Scene, split: int, *, loose: Sequence[tuple[int, int]] = ()) -> Estimate:
    """Between a thing of the first `split` faces and one of the others and the loose edges."""
    count = len(scene.faces)
    things = [
        Thing(tuple(range(split)), ()),
        Thing(tuple(range(split, count)), tuple(range(len(loose)))),
    ]
    edges = np.array(loose, dtype=np.intp).reshape(-1, 2)
    found = gaps(FaceTable.of(scene), edges, things)
    assert [(g.first, g.second) for g in found] == [(0, 1)]
    return found[0].distance


def apart(first: Scene, second: Scene) -> Estimate:
    return gap(together(first, second), len(first.faces))


def facts(scene: Scene) -> dict[tuple[str, str], tuple[float, float]]:
    return {
        (str(a), str(b)): (float(d), float(sd))
        for functor, args in scene_facts(scene)
        if functor == "gap"
        for a, b, d, sd in [args]
    }


@pytest.mark.parametrize(
    ("shift", "wanted"),
    [
        ((1.0, 0.0, 0.0), 1.0 - SIZE[0]),  # faces that lie square to each other
        ((1.0, 0.1, 0.05), 1.0 - SIZE[0]),  # ... in part
        ((1.0, 0.5, 0.05), np.hypot(1.0 - SIZE[0], 0.5 - SIZE[1])),  # ... in part
        ((1.0, 0.5, 0.0), np.hypot(1.0 - SIZE[0], 0.5 - SIZE[1])),  # two sides
        ((1.0, 0.5, 0.4), np.linalg.norm(np.array([1.0, 0.5, 0.4]) - SIZE)),  # two corners
        ((SIZE[0], 0.0, 0.0), 0.0),  # a common face
        ((SIZE[0], SIZE[1], SIZE[2]), 0.0),  # a common corner
        ((0.1, 0.1, 0.1), 0.0),  # one goes into the other
        ((0.0, 0.0, 0.0), 0.0),  # one is the other
    ],
)
def test_two_blocks(shift: tuple[float, float, float], wanted: float) -> None:
    found = apart(cuboid(), moved(cuboid(), translation=shift))
    assert found.value == pytest.approx(wanted, abs=1e-12)
    assert 0.0 < found.sd < 0.002


def test_a_tip_over_the_middle_of_a_face() -> None:
    tip = moved(pyramid(), np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 1.0))
    ground = polyhedron([(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)], [(0, 1, 2, 3)])
    low = tip.points[:, 2].min()
    found = apart(tip, ground)
    assert found.value == pytest.approx(low)
    # the tip's deviation, and that of the middle of four corners: 1 / 4 of their variance
    assert found.sd == pytest.approx(0.001 * np.sqrt(1.25), rel=0.05)
    assert apart(ground, tip) == pytest.approx(found)


def test_a_bar_goes_through_a_hole_without_touching() -> None:
    square = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)
    bar = moved(cuboid(0.4, 0.4, 2.0), translation=(-0.2, -0.2, -1.0))
    start = len(bar.vertices)
    vertices = tuple(Vertex(p, 1e-6 * np.eye(3)) for p in (*square, *0.5 * square))
    plane = fit_plane_through_loop(square, 0.001)
    for holes, wanted in ((), 0.0), (((4, 5, 6, 7),), 0.3):
        face = Face(
            tuple(start + i for i in range(4)),
            plane,
            tuple(tuple(start + i for i in ring) for ring in holes),
        )
        scene = Scene("frame", (), (*bar.vertices, *vertices), (), (*bar.faces, face))
        assert gap(scene, len(bar.faces)).value == pytest.approx(wanted)


def triangle_distance(first: np.ndarray, second: np.ndarray) -> float:
    """By minimising over the two triangles' barycentric coordinates, from several starts."""
    sums = ({"type": "eq", "fun": lambda x: x[:3].sum() - 1.0},
            {"type": "eq", "fun": lambda x: x[3:].sum() - 1.0})  # fmt: skip

    def square(x: np.ndarray) -> float:
        return float(((x[:3] @ first - x[3:] @ second) ** 2).sum())

    best = min(
        minimize(square, np.repeat(1 / 3, 6), bounds=[(0.0, 1.0)] * 6, constraints=sums,
                 method="SLSQP", options={"ftol": 1e-14, "maxiter": 300}).fun
        for _ in range(1)
    )  # fmt: skip
    return float(np.sqrt(max(best, 0.0)))


@pytest.mark.parametrize("seed", range(40))
def test_any_two_triangles_agree_with_an_optimiser(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = rng.normal(size=(2, 3, 3))
    second = second + rng.normal(size=3) * (seed % 4)
    scene = polyhedron(np.vstack([first, second]), [(0, 1, 2), (3, 4, 5)])
    assert gap_exact(scene).value == pytest.approx(triangle_distance(first, second), abs=2e-5)


def gap_exact(scene: Scene) -> Estimate:
    """Between the first face and the others, of exact vertices: no mean over several places."""
    exact = tuple(Vertex(p, 1e-18 * np.eye(3)) for p in scene.points)
    return gap(Scene(scene.name, (), exact, scene.edges, scene.faces), 1)


PAIRS: dict[str, Callable[[], tuple[Scene, Scene]]] = {
    "faces": lambda: (cuboid(), moved(cuboid(), translation=(0.5, 0.07, 0.03))),
    "sides": lambda: (cuboid(), moved(cuboid(), translation=(0.5, 0.5, 0.0))),
    "corners": lambda: (cuboid(), moved(cuboid(), translation=(0.5, 0.5, 0.5))),
    "tip": lambda: (cuboid(), moved(pyramid(), np.diag([1.0, -1, -1]), (0.1, 0.1, 0.6))),
    "crossing": lambda: (cuboid(2, 0.2, 0.2), moved(cuboid(0.2, 2, 0.2), None, (0.9, -0.9, 0.4))),
    "table and chair": lambda: (table(), moved(chair(), translation=(1.6, 0.2, 0.0))),
    "sticks": lambda: (stick_table(), moved(stick_table(), translation=(1.7, 0.2, 0.0))),
}


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("seed", [1, 2])
def test_order_motion_and_scale(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = PAIRS[name]()
    scene = together(first, second)
    here = gap(scene, len(first.faces))
    assert gap(together(second, first), len(second.faces)) == pytest.approx(here, rel=1e-6)
    rotation = Rotation.random(random_state=seed).as_matrix()
    scale = float(10.0 ** rng.uniform(-2, 2))
    there = gap(moved(scene, rotation, 3.0 * scale * rng.normal(size=3), scale), len(first.faces))
    assert there == pytest.approx((scale * here.value, scale * here.sd), rel=1e-5)


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.slow
def test_deviations_are_those_of_the_spread(name: str) -> None:
    sd, copies = 0.002, 80
    rng = np.random.default_rng(5)
    first, second = PAIRS[name]()
    scene = together(first, second)
    truth = gap(scene, len(first.faces)).value
    errors, stated = [], []
    for _ in range(copies):
        points = scene.points + sd * rng.standard_normal(scene.points.shape)
        found = gap(
            Scene(
                "noisy",
                (),
                tuple(Vertex(p, sd**2 * np.eye(3)) for p in points),
                tuple(Edge(e.start, e.end) for e in scene.edges),
                tuple(
                    Face(f.outline, fit_plane_through_loop(points[list(f.outline)], sd))
                    for f in scene.faces
                ),
            ),
            len(first.faces),
        )
        errors.append(found.value - truth)
        stated.append(found.sd)
    error = float(np.sqrt(np.mean(np.square(errors))))
    expected = float(np.sqrt(np.mean(np.square(stated))))
    assert 0.7 < error / expected < 1.4
    assert abs(np.mean(errors)) < 0.5 * expected


def test_facts_tell_both_orders_of_every_two_things() -> None:
    blocks = [moved(cuboid(), translation=(0.5 * i, 0.0, 0.0)) for i in range(3)]
    found = facts(together(*blocks))
    assert set(found) == {(f"t{i}", f"t{j}") for i in (1, 2, 3) for j in (1, 2, 3) if i != j}
    assert all(found[a, b] == found[b, a] for a, b in found)
    near, far = 0.5 - SIZE[0], 1.0 - SIZE[0]
    assert sorted(d for d, _ in found.values()) == pytest.approx([near] * 4 + [far] * 2)
