"""A scene of one flat face is nothing that takes several faces to be."""

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.scene import Body, Face, Plane, Scene, Vertex
from facetlog.perception.types import FloatArray

HOLE = np.array([[0.15, 0.15], [0.15, 0.85], [0.85, 0.85], [0.85, 0.15]])


def flat_scene(outline: FloatArray, holes: Sequence[FloatArray], turn: Rotation) -> Scene:
    """Return one face (k, 2) with holes, all given in its plane."""
    loops, begin = [], 0
    for ring in (outline, *holes):
        loops.append(tuple(range(begin, begin + len(ring))))
        begin += len(ring)
    flat = np.concatenate([outline, *holes])
    points = turn.apply(np.column_stack([flat, np.zeros(len(flat))]))
    normal = turn.apply([0.0, 0.0, 1.0])
    plane = Plane(normal, -float(normal @ points[0]), np.zeros((4, 4)))
    return Scene(
        name="one face",
        vertices=tuple(Vertex(p, 1e-6 * np.eye(3)) for p in points),
        faces=(Face(loops[0], plane, tuple(loops[1:])),),
        up=np.array([0.0, 0.0, 1.0]),
        metric=True,
        bodies=(Body((0,)),),
    )


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    with open_knowledge_base(()) as found:
        yield found


@settings(max_examples=30, deadline=None)
@given(
    size=st.tuples(st.floats(0.02, 2.5), st.floats(0.02, 2.5)),
    slants=st.tuples(st.floats(0.0, 0.8), st.floats(0.0, 0.8)),
    has_hole=st.booleans(),
    tilt=st.sampled_from([0.0, 60.0, 90.0, 180.0]),
)
@example((1.18, 0.085), (0.4, 0.0), False, 90.0)
@example((1.18, 0.085), (0.0, 0.7), False, 90.0)
@example((0.5, 0.4), (0.0, 0.0), True, 90.0)
@example((2.0, 0.9), (0.0, 0.0), False, 0.0)
@pytest.mark.slow
def test_it_is_a_door_or_nothing(
    base: KnowledgeBase,
    size: tuple[float, float],
    slants: tuple[float, float],
    has_hole: bool,
    tilt: float,
) -> None:
    a, b = slants
    corners = np.array([[0.0, 0.0], [1.0 - a, b], [1.0, 1.0], [a, 1.0 - b]])
    holes = [HOLE * size] if has_hole and not a and not b else []
    scene = flat_scene(corners * size, holes, Rotation.from_euler("x", tilt, degrees=True))
    found = judge_scene(
        base,
        scene.name,
        [fact.row for fact in scene_facts(scene)],
        on_demand=lambda: (fact.row for fact in facts_on_demand(scene)),
    )
    holding = {verdict.model for verdict in found.best}
    # A leaf shows one face; it is upright, and higher than broad.
    spread = np.ptp(scene.points, axis=0)
    assert holding <= ({"door"} if spread[2] > max(spread[:2]) else set())
