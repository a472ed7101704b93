"""The floor of a mesh is no part of what stands on it; a base, a plinth or a platform is a part."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts.all_facts import scene_facts
from tests.perception.shapes.meshes.made_meshes import Point, block, scene_of, table, together

Z = np.array([0.0, 0.0, 1.0])


def posts(low: Point, high: Point, side: float) -> trimesh.Trimesh:
    """Four posts at the corners of a block."""
    return together(
        *(
            block((x, y, low[2]), (x + side, y + side, high[2]))
            for x in (low[0], high[0] - side)
            for y in (low[1], high[1] - side)
        )
    )


def chair(x: float, y: float) -> trimesh.Trimesh:
    legs = posts((x, y, 0), (x + 0.45, y + 0.45, 0.43), 0.04)
    seat = block((x, y, 0.43), (x + 0.45, y + 0.45, 0.47))
    return together(legs, seat, block((x, y + 0.41, 0.47), (x + 0.45, y + 0.45, 0.95)))


def things() -> trimesh.Trimesh:
    return together(table(), chair(0.4, 1.5), block((2.4, 0, 0), (3.0, 0.4, 0.5)))


def sheet(low: tuple[float, float], high: tuple[float, float], level: float) -> trimesh.Trimesh:
    made = block((*low, level), (*high, level + 1.0))
    return trimesh.Trimesh(made.vertices, made.faces[made.face_normals[:, 2] < -0.5])


FLOORS = {
    "slab": block((-1, -1, -0.1), (4, 3, 0)),
    "sheet": sheet((-1, -1), (4, 3), 0.0),
    "sheet below a gap": sheet((-1, -1), (4, 3), -0.01),
    "slab that feet sink into": block((-1, -1, -0.1), (4, 3, 0.002)),
    "loose sides of a slab": together(
        *(sheet((-1, -1), (4, 3), level) for level in (-0.1, 0.0)),
        trimesh.Trimesh(
            *(lambda b: (b.vertices, b.faces[abs(b.face_normals[:, 0]) > 0.5]))(
                block((-1, -1, -0.1), (4, 3, 0))
            )
        ),
    ),
    "tiles": together(
        *(sheet((x, y), (x + 0.98, y + 0.98), 0.0) for x in range(-1, 4) for y in range(-1, 3))
    ),
}


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.slow
def test_things_on_a_floor_are_what_they_are_without_it(floor: str) -> None:
    on_floor, bare = scene_of(together(FLOORS[floor], things())), scene_of(things())
    counts, expected = (
        Counter(len(body.faces) for body in scene.bodies) for scene in (on_floor, bare)
    )
    assert expected.total() == 3
    assert counts == expected


def models_of(made: trimesh.Trimesh) -> frozenset[str]:
    facts = [fact.row for fact in scene_facts(scene_of(made))]
    with open_knowledge_base() as base:
        return frozenset(judge_scene(base, "s", facts).models)


@settings(max_examples=5)
@given(st.integers(0, 2**31), st.sampled_from([1e-3, 1.0, 1e3]))
@pytest.mark.slow
def test_a_floor_is_found_in_any_frame_and_unit(seed: int, unit: float) -> None:
    made = together(FLOORS["slab"], things())
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    turned = trimesh.Trimesh(unit * made.vertices @ turn.T, made.faces, process=False)
    assert len(scene_of(turned, turn @ Z).bodies) == 3


def test_a_floor_that_shares_corners_with_feet_is_apart_from_them() -> None:
    x, y = (
        np.unique(np.r_[-1.0:2.3:12j, 0.05, 0.11, 1.09, 1.15]),
        np.r_[-1.0, 0.05, 0.11, 0.69, 0.75, 2],
    )
    floor = together(*(sheet((a, b), (c, d), 0.0) for a, c in pairwise(x) for b, d in pairwise(y)))
    scene = scene_of(together(floor, table()))
    assert len(scene.bodies) == 1


@pytest.mark.slow
def test_a_table_alone_on_a_large_slab_is_a_table() -> None:
    made = together(block((-1, -1, -0.05), (2.5, 2, 0)), table())
    assert len(scene_of(made).bodies) == 1
    assert models_of(made) == {"table"}


PARTS_BELOW = {
    "pedestal table": [
        block((0.2, 0.2, 0), (0.7, 0.7, 0.02)),
        block((0.42, 0.42, 0.02), (0.48, 0.48, 0.7)),
        block((0, 0, 0.7), (0.9, 0.9, 0.73)),
    ],
    "lamp": [block((0, 0, 0), (0.3, 0.3, 0.01)), block((0.14, 0.14, 0.01), (0.16, 0.16, 1.5))],
    "bed with a head and a foot": [
        block((0, 0, 0), (2, 1.6, 0.05)),
        block((0, 0, 0.05), (0.05, 1.6, 0.9)),
        block((1.95, 0, 0.05), (2, 1.6, 0.6)),
    ],
    "bed with a mattress": [
        block((0, 0, 0), (2, 1.6, 0.05)),
        block((0.05, 0.05, 0.05), (1.95, 1.55, 0.25)),
    ],
    "cabinet on a plinth": [
        block((0.03, 0.03, 0), (0.97, 0.5, 0.05)),
        block((0, 0, 0.05), (1, 0.53, 0.9)),
    ],
    "stairs": [block((0, 0.3 * k, 0.2 * k), (1.2, 1.2, 0.2 * k + 0.2)) for k in range(4)],
    "platform with posts": [
        block((0, 0, 0), (1.2, 0.8, 0.04)),
        posts((0.2, 0.2, 0.04), (1, 0.6, 0.7), 0.05),
    ],
    "keyboard": [
        block((0, 0, 0), (0.46, 0.16, 0.005)),
        *(
            block((x, y, 0.005), (x + 0.088, y + 0.044, 0.012))
            for x in (0.06, 0.15, 0.24, 0.33)
            for y in (0.015, 0.06, 0.105)
        ),
    ],
}


@pytest.mark.parametrize("thing", PARTS_BELOW)
@pytest.mark.slow
def test_what_is_below_stays_a_part_where_it_is_no_floor(thing: str) -> None:
    assert len(scene_of(together(*PARTS_BELOW[thing])).bodies) == 1


@pytest.mark.parametrize("gap", [0.0, 0.005, 0.01])
def test_parts_of_a_chair_with_gaps_are_one_thing_beside_others(gap: float) -> None:
    apart = posts((0, 0, 0), (0.45, 0.45, 0.43 - gap), 0.04)
    seat = block((0, 0, 0.43), (0.45, 0.45, 0.47))
    back = block((0, 0.41, 0.47 + gap), (0.45, 0.45, 0.95))
    one = together(apart, seat, back)
    far = block((30.0, 0, 0), (30.4, 0.4, 0.4))
    assert len(scene_of(together(one, far)).bodies) == 2


@pytest.mark.parametrize("count", [3, 16])
def test_chairs_in_a_row_are_as_many_whatever_the_row_is_long(count: int) -> None:
    row = together(*(chair(0.6 * k, 0.0) for k in range(count)))
    scene = scene_of(row)
    assert len(scene.bodies) == count
    assert len({len(body.faces) for body in scene.bodies}) == 1
