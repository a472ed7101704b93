"""Builders of exact scenes: each builds one closed thing of its size, or says what is wrong."""

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.facts.fact_schema import check_fact
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build

# The extent along x, y and z of what was asked for.
SIZES = {
    "cuboid": ({"width": 0.3, "depth": 0.2, "height": 0.1}, (0.3, 0.2, 0.1)),
    "tray": ({"width": 0.4, "depth": 0.3, "height": 0.05}, (0.4, 0.3, 0.05)),
    "wedge": ({"width": 0.3, "depth": 0.2, "height": 0.1}, (0.3, 0.2, 0.1)),
    "pyramid": ({"width": 0.3, "height": 0.2}, (0.3, 0.3, 0.2)),
    "l_block": ({"width": 0.4, "depth": 0.2, "height": 0.3}, (0.4, 0.2, 0.3)),
    "room_corner": ({"width": 2.0, "height": 2.4}, (2.0, 2.0, 2.4)),
    "table": ({"width": 0.7, "length": 1.4, "height": 0.74}, (1.4, 0.7, 0.74)),
    "desk": ({"width": 0.7, "length": 1.5, "height": 0.72}, (1.5, 0.7, 0.72)),
    "chair": ({"width": 0.4, "depth": 0.45, "seat": 0.46, "height": 0.95}, (0.4, 0.45, 0.95)),
    "stool": ({"width": 0.3, "depth": 0.35, "height": 0.6}, (0.3, 0.35, 0.6)),
    "bench": ({"width": 0.3, "length": 1.1, "height": 0.4}, (1.1, 0.3, 0.4)),
    "bed": ({"width": 0.9, "length": 2.0, "height": 0.5, "head": 0.9}, (2.0, 0.9, 0.9)),
    "sofa": (
        {"width": 1.8, "depth": 0.8, "seat": 0.4, "height": 0.75, "arm": 0.15},
        (1.8, 0.8, 0.75),
    ),
    "frame": ({"width": 0.5, "height": 0.4, "thickness": 0.03, "rim": 0.05}, (0.5, 0.03, 0.4)),
    "shelf": ({"width": 0.9, "depth": 0.25, "height": 1.9, "boards": 4}, (0.9, 0.25, 1.9)),
    "cabinet": ({"width": 0.9, "depth": 0.5, "height": 1.3}, (0.9, 0.5, 1.3)),
    "cylinder": ({"diameter": 0.4, "height": 0.5}, (0.4, 0.4, 0.5)),
    "wheel": ({"diameter": 0.2, "thickness": 0.05}, (0.2, 0.05, 0.2)),
    "stairs": ({"steps": 5, "width": 0.9, "rise": 0.17, "going": 0.29}, (1.45, 0.9, 0.85)),
}

VOLUMES = {
    "cuboid": 0.3 * 0.2 * 0.1,
    "tray": 0.4 * 0.3 * 0.05 - 0.39 * 0.29 * 0.045,
    "wedge": 0.3 * 0.2 * 0.1 / 2,
    "pyramid": 0.3 * 0.3 * 0.2 / 3,
    "l_block": 0.4 * 0.2 * 0.3 * 0.75,
    "bed": 2.0 * 0.9 * 0.5 + 0.06 * 0.9 * 0.4,
    "sofa": 1.8 * 0.8 * 0.4 + 1.8 * 0.2 * 0.35 + 2 * 0.15 * 0.6 * 0.175,
    "frame": 0.03 * (0.5 * 0.4 - 0.4 * 0.3),
    "cylinder": 0.5 * 48 * 0.2**2 * math.sin(math.pi / 24) / 2,
    "wheel": 0.05 * 48 * 0.1**2 * math.sin(math.pi / 24) / 2,
    "stairs": 0.9 * 0.17 * 0.29 * 15,
}


def volume(scene: Scene) -> float:
    """By the divergence theorem, over fans of triangles; holes are subtracted by their sense."""
    total = 0.0
    for face in scene.faces:
        for ring in (face.outline, *face.holes):
            p = scene.points[list(ring)]
            total += sum(float(p[0] @ np.cross(p[i], p[i + 1])) / 6 for i in range(1, len(p) - 1))
    return total


@pytest.mark.parametrize("name", BUILDERS)
def test_a_builder_gives_the_size_that_was_asked_for(name: str) -> None:
    arguments, size = SIZES[name]
    scene = build(name, arguments)
    assert np.ptp(scene.points, axis=0) == pytest.approx(size)
    assert scene.points[:, 2].min() == 0.0
    assert scene.metric
    assert scene.up is not None
    assert scene.up.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("name", VOLUMES)
def test_what_is_of_one_piece_is_closed(name: str) -> None:
    scene = build(name, SIZES[name][0])
    assert volume(scene) == pytest.approx(VOLUMES[name])
    shared = Counter(
        frozenset(pair)
        for face in scene.faces
        for ring in (face.outline, *face.holes)
        for pair in zip(ring, (*ring[1:], ring[0]), strict=True)
    )
    assert set(shared.values()) == {2}


@pytest.mark.parametrize("name", BUILDERS)
def test_every_builder_without_sizes_is_one_thing_with_sound_facts(name: str) -> None:
    scene = build(name, {})
    assert scene.name == name
    facts = scene_facts(scene)
    assert [fault for fact in facts if (fault := check_fact(fact))] == []
    count = Counter(fact.functor for fact in facts)
    assert count["thing"] == 1
    assert count["face"] == len(scene.faces)
    assert count["vertex"] == len(scene.vertices)


def test_the_walls_of_a_corner_meet_at_the_angle_that_was_asked_for() -> None:
    scene = build("room_corner", {"angle": math.radians(100)})
    (angle,) = (
        fact.args[2]
        for fact in scene_facts(scene)
        if fact.functor == "dihedral" and fact.args[:2] == ("f2", "f3")
    )
    assert angle == pytest.approx(360 - 100)


@pytest.mark.parametrize(
    ("name", "arguments", "message"),
    [
        ("tabel", {}, r"no builder 'tabel'; did you mean 'table'\? there are cuboid, "),
        ("table", {"hight": 0.7}, r"table has no size 'hight'; did you mean 'height'\?"),
        ("table", {"height": 0.0}, r"height of a table is 0 m: give one between"),
        ("table", {"height": math.nan}, r"must be a number, not nan"),
        ("table", {"leg": 0.5}, r"two legs with their rims .* less than the shorter side"),
        ("table", {"height": 0.03}, r"the thickness \(0.04 m\) must be less than the height"),
        ("desk", {"length": 3.0, "panel": 0.5}, r"half the width"),
        ("chair", {"seat": 1.0}, r"the seat's height .* the height"),
        ("shelf", {"boards": 2.5}, r"boards of a shelf is 2.5: give a whole number"),
        ("shelf", {"boards": 50, "height": 1.0}, r"the boards with their rims"),
        ("cabinet", {"foot": 1.2}, r"the foot"),
        ("room_corner", {"angle": math.pi}, r"is 180 deg: give one between 5 deg and 175 deg"),
    ],
)
def test_what_cannot_be_built_is_refused_with_the_way_out(
    name: str, arguments: dict[str, float], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        build(name, arguments)


@settings(max_examples=60)
@given(st.sampled_from(sorted(BUILDERS)), st.data())
@pytest.mark.slow
def test_any_size_is_built_or_refused(name: str, data: st.DataObject) -> None:
    """And what is built has facts, no face without area, and no piece inside out."""
    limits = {"length": (0.0005, 3.0), "count": (1, 12), "angle": (0.0, math.pi)}
    arguments = {
        p.name: data.draw(
            st.integers(1, 12) if p.kind == "count" else st.floats(*limits[p.kind]), label=p.name
        )
        for p in BUILDERS[name].parameters
    }
    try:
        scene = build(name, arguments)
    except ValueError:
        assume(False)
    assert [fault for fact in scene_facts(scene) if (fault := check_fact(fact))] == []
    assert volume(scene) > 0 or name == "room_corner"
    for face in scene.faces:
        ring = scene.points[list(face.outline)]
        middle = ring.mean(axis=0)
        spokes = ring - middle
        area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0) @ face.plane.normal
        assert area > 0
        assert np.ptp(ring, axis=0).max() >= 0.0009
