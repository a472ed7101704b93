"""Solids put together: where they are, and that they are measured as meshes would be."""

import numpy as np
import pytest

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.shapes.meshes.built_solids import Solid, build_solids
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build


def test_a_single_flat_solid_stays_exact():
    scene = build_solids([Solid("table", {"height": 0.7})])
    assert len(scene.faces) == len(build("table", {}).faces)
    assert np.array_equal(scene.points, build("table", {"height": 0.7}).points)


def test_copies_are_spread_over_the_lengths_that_are_given():
    block = {"width": 0.1, "depth": 0.1, "height": 0.1, "x": 0.5}
    spread = {"along": 1.0, "across": 0.8, "columns": 3, "over": 0.1, "levels": 2}
    places = Solid("cuboid", block | spread).find_places(np.array([0.1, 0.1, 0.1]))
    assert sorted({round(x, 9) for x in places[:, 0]}) == [0.5, 0.95, 1.4]
    assert sorted({round(y, 9) for y in places[:, 1]}) == [0.0, 0.7]
    assert set(places[:, 2]) == {0.0}


@pytest.mark.parametrize("name", [name for name, b in BUILDERS.items() if b.is_solid])
def test_each_builder_is_one_whole_thing_as_a_mesh(name):
    """Also those whose exact scene has no faces where two pieces lie against each other."""
    scene = build_solids([Solid(name, {"x": 0.0})])
    assert [body.whole for body in scene.bodies] == [True]
    assert scene.warnings == ()
    low, high = (getattr(build(name, {}).points, end)(axis=0) for end in ("min", "max"))
    seen = np.concatenate([scene.points, *(patch.points for patch in scene.patches)])
    assert np.ptp(seen, axis=0) == pytest.approx(high - low, rel=0.02)


def test_a_wheel_is_curved():
    (row,) = fact_rows(build_solids([Solid("wheel")]), {"curved"})["curved"]
    assert row[1] > 0.3


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ({"along": 0.1}, "alone takes"),
        ({"columns": 3}, "say along which length"),
        ({"along": 1, "columns": 2.5}, "whole number"),
        ({"x": -1}, "outside"),
        ({"x": 1e9}, "outside"),
        ({"along": 9, "across": 9, "columns": 50, "rows": 50}, "more than 400"),
        ({"along": float("nan")}, "outside"),
    ],
)
def test_a_place_that_nothing_can_have_is_refused(sizes, message):
    with pytest.raises(ValueError, match=message):
        build_solids([Solid("cuboid", sizes)])
