"""Space that whole things fill and leave: shares and lengths known from their construction."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Face, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved
from tests.perception.facts.scene_values import first_values
from tests.perception.space.simulated_scans import eye_at, one_body, scanned

CELL = 1 / 40
"""Share of the longest side that the grid resolves."""


def turned(scene: Scene, radians: float, scale: float = 1.0) -> Scene:
    """The scene turned about the vertical, scaled and moved away."""
    c, s = np.cos(radians), np.sin(radians)
    return moved(scene, [[c, -s, 0], [s, c, 0], [0, 0, 1]], (3.0, -2.0, 5.0), scale)


TABLE = one_body(build("table", {"width": 0.8, "length": 1.2, "height": 0.74}), whole=True)
CHAIR = one_body(build("chair", {}), whole=True)


def test_a_table_top_covers_the_plan_with_room_and_sight_beneath() -> None:
    assert first_values(TABLE, "cover")["f2"] == pytest.approx(1.0)
    assert first_values(TABLE, "built_over")["f2"] == 0.0
    # the board is 4 cm thick; 4 legs take a little of the plan
    assert first_values(TABLE, "room_below")["f2"] == pytest.approx(0.70, abs=2 * CELL * 1.2)
    assert first_values(TABLE, "room_above")["f2"] == 0.0
    assert first_values(TABLE, "see_through")["f2"] > 0.8
    assert "f2" not in first_values(TABLE, "rise_side")
    assert first_values(TABLE, "footprint")["t1"] == pytest.approx(0.96, rel=0.1)


def test_a_back_rises_at_the_rim_of_a_seat_along_all_of_one_side() -> None:
    seat = "f2"
    assert first_values(CHAIR, "rise_side")[seat] == pytest.approx(1.0, abs=0.2)
    assert first_values(CHAIR, "rise_off_middle")[seat] == pytest.approx(0.0, abs=2 * CELL)
    assert first_values(CHAIR, "rise_span")[seat] == pytest.approx(1.0, abs=2 * CELL)
    assert first_values(CHAIR, "room_above")[seat] > 0.3


@pytest.mark.parametrize(("width", "depth"), [(0.40, 0.48), (0.48, 0.40), (0.45, 0.45)])
@pytest.mark.parametrize("radians", [0.0, 0.4, 2.0])
def test_a_seat_is_as_broad_as_its_front_whichever_side_is_longer(
    width: float, depth: float, radians: float
) -> None:
    chair = turned(one_body(build("chair", {"width": width, "depth": depth}), whole=True), radians)
    assert first_values(chair, "front_width")["f2"] == pytest.approx(width)
    # what lies in front of the back
    assert first_values(chair, "front_depth")["f2"] == pytest.approx(depth, abs=0.04)
    assert "front_width" not in {fact.functor for fact in scene_facts(replace(chair, up=None))}


def test_a_block_that_is_tipped_over_is_as_solid_as_upright() -> None:
    tilt = np.radians(30.0)
    c, s = np.cos(tilt), np.sin(tilt)
    tipped = moved(cuboid(), [[1, 0, 0], [0, c, -s], [0, s, c]], (0.0, 0.0, 0.0), 1.0)
    assert first_values(one_body(tipped, whole=True), "solidity")["t1"] == pytest.approx(1.0)


def apart(scene: Scene, share: float, sd: float) -> Scene:
    """The scene with faces that have corners of their own, known to `sd`, drawn in."""
    vertices: list[Vertex] = []
    faces: list[Face] = []
    for face in scene.faces:
        corners = scene.points[list(face.outline)]
        middle = corners.mean(axis=0)
        start = len(vertices)
        vertices += [Vertex(middle + share * (c - middle), sd**2 * np.eye(3)) for c in corners]
        faces.append(replace(face, outline=tuple(range(start, len(vertices)))))
    return replace(scene, vertices=tuple(vertices), edges=(), faces=tuple(faces), bodies=())


@pytest.mark.parametrize("up", [True, False])
def test_a_block_whose_faces_miss_each_other_within_their_error_is_solid(up: bool) -> None:
    block = cuboid(1.0, 1.0, 1.0) if up else replace(cuboid(1.0, 1.0, 1.0), up=None)
    known, vague = (one_body(apart(block, 0.84, sd), whole=True) for sd in (0.001, 0.04))
    assert "t1" not in {f.args[0] for f in scene_facts(known) if f.functor == "whole"}
    assert "t1" in {f.args[0] for f in scene_facts(vague) if f.functor == "whole"}
    assert first_values(vague, "solidity")["t1"] > 0.9


@settings(max_examples=10)
@given(st.floats(0.0, 6.3), st.floats(0.01, 1000.0))
@pytest.mark.slow
def test_neither_the_frame_nor_the_unit_matters(radians: float, scale: float) -> None:
    after = turned(CHAIR, radians, scale)
    for functor in ("cover", "see_through", "rise_side", "solidity", "built_over"):
        before, now = first_values(CHAIR, functor), first_values(after, functor)
        assert now["t1" if functor == "solidity" else "f2"] == pytest.approx(
            before["t1" if functor == "solidity" else "f2"], abs=4 * CELL
        )
    room = first_values(CHAIR, "room_below")["f2"]
    assert first_values(after, "room_below")["f2"] / scale == pytest.approx(room, abs=2 * CELL)


def test_only_measures_that_unseen_space_could_change_have_bounds_about_their_value() -> None:
    scan = scanned(TABLE, eye_at(TABLE, 30.0, 40.0))
    bounds = {f.args[:2]: f.args[2:] for f in scene_facts(scan) if f.functor == "unseen_bounds"}
    stated = {(f.functor, f.args[0]): f.args[1:] for f in scene_facts(scan) if len(f.args) == 3}
    assert bounds.keys() < stated.keys()
    assert ("free_below", "f1") in bounds
    for key, ends in bounds.items():
        if_free, if_full = map(float, ends)
        assert if_free != if_full
        assert float(stated[key][0]) == pytest.approx((if_free + if_full) / 2.0)
    free, full = bounds["free_below", "f1"]
    assert free > full
    assert not [f for f in scene_facts(TABLE) if f.functor == "unseen_bounds"]
