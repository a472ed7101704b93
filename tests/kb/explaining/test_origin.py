"""From names and facts down to vertices and pixels."""

import json
from collections.abc import Callable

import pytest

from facetlog.errors import QueryError
from facetlog.kb.explaining.origin import FaceOrigin, FactOrigin, ThingOrigin, VertexOrigin
from facetlog.kb.loading.encode import Fact
from tests.kb.asked import asked

Build = Callable[..., tuple[Fact, ...]]


@pytest.fixture
def facts(facts_of: Build) -> list[Fact]:
    """Three faces of a box, f1 seen by 22 views."""
    seen: list[Fact] = [("view", f"view{k}", f"{k:02}.png") for k in range(22)]
    for v in (4, 5, 6, 7):
        seen += [("observed", f"v{v}", f"view{k}", 100.0 + v, 50.25, 0.5, 0.4) for k in range(22)]
    return [
        *facts_of("box", seen=(1, 2, 3)),
        *seen,
        ("point_cov", "v5", 1e-6, 0.0, 0.0, 4e-6, 0.0, 9e-6),
        ("vertex_label", "v5", "front_right_top"),
        ("plane", "f1", 0.0, 0.0, 1.0, -0.1524),
        ("plane_sd", "f1", 0.3, 0.001),
    ]


def test_a_face_comes_from_its_vertices_in_order_and_their_pixels(facts: list[Fact]) -> None:
    with asked(facts) as ask:
        face = ask.origin("f1")
    assert isinstance(face, FaceOrigin)
    assert [v.name for v in face.corners] == ["v4", "v5", "v6", "v7"]
    assert (face.evidence, face.thing) == ("measured", "t1")
    assert face.plane is not None
    assert face.plane.tilt_sd_deg == 0.3
    corner = face.corners[1]
    assert corner.sd == pytest.approx((0.001, 0.002, 0.003))
    assert corner.label == "front_right_top"
    assert corner.sightings[0].picture == "00.png"
    assert (corner.sightings[0].column_px, corner.sightings[0].row_px) == (105.0, 50.25)


def test_long_lists_are_shortened_unless_all_is_wanted(facts: list[Fact]) -> None:
    with asked(facts) as ask:
        vertex = ask.origin("v5")
    assert isinstance(vertex, VertexOrigin)
    short = list(vertex.lines(length_unit="m"))
    assert short[0] == "v5 (front_right_top) at (25.4, 0.0, 15.2) ± 0.3 cm"
    assert short[-1] == "  and 19 more views"
    assert len(list(vertex.lines(full=True))) == 23


def test_a_fact_comes_from_the_faces_that_it_names(facts: list[Fact]) -> None:
    with asked(facts) as ask:
        fact = ask.origin("angle(f1, f2)")
        same = ask.origin("angle(f1, f2, D, S)")
    assert isinstance(fact, FactOrigin)
    assert fact == same
    assert fact.to_json()["facts"] == ["angle(f1, f2, 90.0, 0.4)"]
    assert next(fact.lines(length_unit="m")) == "angle(f1, f2) = 90.0° ± 0.4°"
    assert [face.name for face in fact.of if isinstance(face, FaceOrigin)] == ["f1", "f2"]


@pytest.mark.parametrize("name", ["f1", "e0", "v5", "t1", "view3"])
def test_every_sort_of_name_has_text_and_plain_data(facts: list[Fact], name: str) -> None:
    with asked(facts) as ask:
        origin = ask.origin(name)
    assert next(iter(origin.lines())).startswith(name)
    assert name in json.dumps(origin.to_json())


def test_a_thing_comes_from_its_faces(facts: list[Fact]) -> None:
    with asked(facts) as ask:
        thing = ask.origin("t1")
    assert isinstance(thing, ThingOrigin)
    assert [face.name for face in thing.faces] == ["f1", "f2", "f3"]


@pytest.mark.parametrize("about", ["f9", "angel(f1)"])
def test_what_the_scene_does_not_have_is_named(facts: list[Fact], about: str) -> None:
    with asked(facts) as ask, pytest.raises(QueryError, match="neither a name nor a fact"):
        ask.origin(about)
