"""Standard deviations of measures against the spread over many noisy copies of a solid."""

from collections import defaultdict
from collections.abc import Callable

import numpy as np
import pytest

from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Edge, Face, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    cuboid,
    fit_plane_through_loop,
    l_block,
    stick_table,
    wedge,
)

SD = 0.002
COPIES = 40
FUNCTORS = {
    "area", "length", "width", "fill", "edge_length", "protrusion", "reach_behind", "offset",
    "elevation", "top_of", "bottom_of", "share", "dihedral", "tilt", "angle",
}  # fmt: skip


def noisy(scene: Scene, rng: np.random.Generator) -> Scene:
    """The scene with vertices off by SD in every direction, and planes fitted to them."""
    points = scene.points + SD * rng.standard_normal((len(scene.vertices), 3))
    return Scene(
        scene.name,
        (),
        tuple(Vertex(p, SD**2 * np.eye(3)) for p in points),
        tuple(Edge(e.start, e.end) for e in scene.edges),
        tuple(
            Face(f.outline, fit_plane_through_loop(points[list(f.outline)], SD))
            for f in scene.faces
        ),
        scene.up,
        scene.metric,
    )


# Planes are taken as independent of one another and of vertices; those of one solid share
# vertices, which makes some of the figures too large and some too small.
@pytest.mark.parametrize("build", [cuboid, wedge, l_block, stick_table])
@pytest.mark.slow
def test_deviations_are_those_of_the_spread(build: Callable[..., Scene]) -> None:
    rng = np.random.default_rng(7)
    values: dict[tuple[object, ...], list[float]] = defaultdict(list)
    sds: dict[tuple[object, ...], list[float]] = defaultdict(list)
    scene = build(sd=SD)
    for _ in range(COPIES):
        for functor, args in scene_facts(noisy(scene, rng)):
            if functor in FUNCTORS:
                *names, value, sd = args
                values[functor, *names].append(float(value))
                sds[functor, *names].append(float(sd))
    truth = {
        (functor, *args[:-2]): float(args[-2])
        for functor, args in scene_facts(scene)
        if functor in FUNCTORS
    }
    assert set(values) == set(truth)
    ratios: dict[str, list[float]] = defaultdict(list)
    for key, found in values.items():
        error = np.sqrt(np.mean((np.array(found) - truth[key]) ** 2))
        stated = np.sqrt(np.mean(np.square(sds[key])))
        # What is pressed against a bound (0 or 1, 0° or 180°) has no spread of its own.
        if stated > 0.0 and not _at_the_end(str(key[0]), truth[key]):
            ratios[str(key[0])].append(float(error / stated))
    for functor, found in ratios.items():
        assert 0.4 < np.median(found) < 1.4, (functor, np.median(found))
        assert max(found) < 1.8, (functor, max(found))


def _at_the_end(functor: str, value: float) -> bool:
    if functor == "fill":  # a triangle's is a half, whatever its corners do
        return value == pytest.approx(0.5) or value == pytest.approx(1.0)
    if functor == "tilt":
        return min(value, 90.0 - value) < 1.0
    if functor == "angle":
        return min(value, 180.0 - value) < 1.0
    bounded = {"share", "protrusion", "elevation", "top_of", "bottom_of"}
    return functor in bounded and (value == pytest.approx(0.0) or value == pytest.approx(1.0))


def test_a_thing_reaches_behind_a_face_as_far_as_the_side_opposite_whatever_its_edges_are() -> None:
    scene = cuboid(0.4, 0.3, 0.25)
    reaches = sorted(args[1] for functor, args in scene_facts(scene) if functor == "reach_behind")
    assert reaches == pytest.approx([0.25, 0.25, 0.3, 0.3, 0.4, 0.4])
