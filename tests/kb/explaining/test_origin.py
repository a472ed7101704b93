"""From names and facts down to vertices and pixels."""

import json
from collections.abc import Callable

import pytest

from facetlog.errors import QueryError
from facetlog.kb.explaining.origin import (
    FaceOrigin,
    FactOrigin,
    OpeningOrigin,
    PieceOrigin,
    VertexOrigin,
)
from facetlog.kb.loading.encode import Fact
from tests.kb.asked import asked

Build = Callable[..., tuple[Fact, ...]]


OWN = {"point_cov", "plane", "plane_sd"}  # stated by the tests


@pytest.fixture
def facts(facts_of: Build) -> list[Fact]:
    """Return three faces of a box, f1 seen by 22 views."""
    seen: list[Fact] = [("view", f"view{k}", f"{k:02}.png") for k in range(22)]
    for v in (4, 5, 6, 7):
        seen += [("observed", f"v{v}", f"view{k}", 100.0 + v, 50.25, 0.5, 0.4) for k in range(22)]
    return [
        *(fact for fact in facts_of("box", seen=(1, 2, 3)) if fact[0] not in OWN),
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


@pytest.fixture
def with_pieces(facts: list[Fact]) -> list[Fact]:
    """Return the facts with a piece that owns two of the faces, and an opening in one of them."""
    return [
        *facts,
        ("piece", "p1"),
        ("piece_of", "p1", "t1"),
        ("piece_size", "p1", 0.4, 0.3, 0.02, 0.001),
        ("piece_heights", "p1", 0.1, 0.12, 0.001),
        ("piece_measured", "p1"),
        ("piece_round", "p1", 0.0),
        ("piece_face", "p1", "f1"),
        ("piece_face", "p1", "f2"),
        ("opening", "o1"),
        ("opening_of", "o1", "t1"),
        ("opening_size", "o1", 0.1, 0.05, 0.001),
        ("frames", "p1", "o1"),
        ("opening_in", "o1", "f3"),
        ("opening_in", "o1", "p1"),
    ]


def test_a_piece_comes_from_the_faces_of_its_own(with_pieces: list[Fact]) -> None:
    with asked(with_pieces) as ask:
        piece = ask.origin("p1")
    assert isinstance(piece, PieceOrigin)
    assert piece.size == (0.4, 0.3, 0.02)
    assert [face.name for face in piece.faces] == ["f1", "f2"]
    assert piece.faces[0].corners[1].sightings[0].picture == "00.png"
    kind, limit, measured, thing, size, heights = next(piece.lines(length_unit="m")).split(", ")
    assert (kind, limit) == ("p1: a board (thickness 6.667 % of width", "limit 35 %)")
    assert (measured, thing) == ("measured", "part of t1")
    assert (size, heights) == ("(40.0 × 30.0 × 2.0) ± 0.1 cm", "(10.0 to 12.0) ± 0.1 cm up")
    assert json.loads(json.dumps(piece.to_json()))["kind"] == "piece"


def test_an_opening_comes_from_what_is_round_it(with_pieces: list[Fact]) -> None:
    with asked(with_pieces) as ask:
        opening = ask.origin("o1")
        piece, fact = ask.origin("p1"), ask.origin("frames(p1, o1)")
    assert isinstance(opening, OpeningOrigin)
    assert (opening.pieces, opening.heights) == (("p1",), None)
    assert [face.name for face in opening.faces] == ["f3"]
    first = next(opening.lines(length_unit="m"))
    assert first == "o1: an opening, through t1, (10.0 × 5.0) ± 0.1 cm, framed by p1"
    assert isinstance(fact, FactOrigin)
    assert fact.of == (piece, opening)


@pytest.mark.parametrize("about", ["f9", "angel(f1)"])
def test_what_the_scene_does_not_have_is_named(facts: list[Fact], about: str) -> None:
    with asked(facts) as ask, pytest.raises(QueryError, match="neither a name nor a fact"):
        ask.origin(about)
