"""Why something of a thing was not seen, and from where it could be."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from facetlog.grammar.library import BUILTIN
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.sight import ImpliedFace, Place, Point, Sight
from facetlog.kb.explaining.unseen import Unseen, unseen
from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.scene_file import read_scene
from tests.kb.asked import asked
from tests.perception.space.simulated_scans import eye_at, scanned

UP = (0.0, 0.0, 1.0)
CUBE = tuple((x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5))


def camera(number: int, azimuth_deg: float, *, high: float = 0.0, count: int = 8) -> Place:
    """Return a camera 2 m away; 0° looks from +x, 90° from +y."""
    turn, rise = math.radians(azimuth_deg), math.radians(high)
    at = (
        2 * math.cos(rise) * math.cos(turn),
        2 * math.cos(rise) * math.sin(turn),
        2 * math.sin(rise),
    )
    return Place(f"view{number}", f"{number}.png", at, count)


def sight(
    *places: Place,
    normals: tuple[Point, ...] = (),
    implied: tuple[ImpliedFace, ...] = (),
    up: Point | None = UP,
    whole: bool = False,
) -> Sight:
    return Sight(whole, up, CUBE, places, normals, implied)


def told(seen: Sight, unit: str | None = "m") -> list[Unseen]:
    return list(unseen(seen, "t1", unit))


FRONT = [camera(1, -30), camera(2, 0), camera(3, 30)]


def test_the_middle_of_the_widest_gap_between_views_is_where_to_look_from() -> None:
    behind, *_ = told(sight(*FRONT))
    assert behind.direction == pytest.approx((-1, 0, 0), abs=1e-9)
    assert behind.place == pytest.approx((-2, 0, 0), abs=1e-9)
    assert behind.why == "no view looks at t1 from behind and the left, as view1 sees it"


def test_the_way_there_is_told_from_the_nearest_view_in_metres() -> None:
    # Of views from +x to +y the middle of the widest gap is at 225°.
    first, *_ = told(sight(camera(1, 0), camera(2, 45), camera(3, 90)))
    place = np.array(first.place)
    assert place == pytest.approx(2 * np.array([-math.sqrt(0.5), -math.sqrt(0.5), 0]), abs=1e-9)
    # view1 looks along -x: its left is -y.
    assert first.look == (
        "look at it from a place 1.4 m to the left and 3.4 m further on as seen from view1 (1.png)"
    )


def test_what_is_looked_at_from_all_round_and_above_asks_for_nothing() -> None:
    ring = [camera(i, 60 * i, high=50) for i in range(6)]
    assert told(sight(*ring)) == []


def test_low_views_miss_what_faces_up_unless_such_a_face_was_found() -> None:
    ring = [camera(i, 60 * i, high=10) for i in range(6)]
    (above,) = told(sight(*ring))
    assert above.why == "from above, t1 is seen only at a grazing angle of 10°"
    assert told(sight(*ring, normals=(UP,))) == []


ROUND = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), UP)
OPENING = (((0.0, 1.0, 0.0), 0.25), ((-1.0, 0.0, 0.0), 0.75))


def test_where_faces_look_everywhere_the_side_that_shows_most_unseen_space_is_named() -> None:
    (found,) = told(replace(sight(normals=ROUND), opening=OPENING))
    assert found.why == "there is space round t1 that nobody looked into"
    assert found.look == ("look at it from the side towards -x: 75 % of it would show from there")
    assert found.direction == (-1.0, 0.0, 0.0)


def test_a_side_that_is_named_for_another_reason_is_not_named_again() -> None:
    (behind, *rest) = told(replace(sight(*FRONT, normals=(UP,)), opening=OPENING))
    assert behind.direction == pytest.approx((-1, 0, 0), abs=1e-9)
    assert not any("space" in found.why for found in rest)


def test_where_a_view_looks_into_unseen_space_a_pattern_behind_it_is_missing() -> None:
    seen = replace(sight(*FRONT, normals=ROUND), opening=(((1.0, 0.0, 0.0), 0.5),))
    found = told(seen)[0]
    assert found.look.startswith("put something with a pattern there, and look at it as view2")
    assert found.place is None


def test_a_camera_in_the_middle_of_the_thing_says_nothing_of_its_sides() -> None:
    assert told(sight(Place("view1", "1.png", (0.0, 0.0, 0.0), 8))) == [
        Unseen("too few views: view1 alone shows something of t1")
    ]


def test_of_what_is_known_from_all_sides_nothing_is_missed() -> None:
    assert told(sight(*FRONT, whole=True)) == []


@pytest.mark.parametrize(
    ("example", "model"),
    [
        ("chair_two_legs", "chair"),
        ("desk_one_end", "desk"),
        ("stool_two_legs", "stool"),
        ("table_two_legs", "table"),
    ],
)
def test_of_an_example_that_is_open_it_is_said_from_where_to_look(example: str, model: str) -> None:
    scene = read_scene(BUILTIN / "scenes" / f"{example}.json")
    with asked([f.row for f in (*scene_facts(scene), *facts_on_demand(scene))]) as ask:
        (miss,) = ask.why_not(model, count=1)
    assert miss.state is not State.HOLDS
    assert any(found.look for found in miss.unseen)


def test_who_asks_why_not_is_told_which_part_and_from_where(facts_of) -> None:  # type: ignore[no-untyped-def]
    places: list[Fact] = []
    for i in range(1, 4):
        place = camera(i, 20.0 * i, high=20).at
        places += [("view", f"view{i}", f"{i}.png"), ("viewpoint", f"view{i}", *place)]
    kept = facts_of("chair", seen=(0,))
    corners = [fact[3] for fact in kept if fact[0] == "corner"]
    seen = [("observed", v, f"view{i}", 1.0, 1.0, 0.1, 0.1) for v in corners for i in range(1, 4)]
    with asked([*kept, *places, *seen]) as ask:
        verdict = ask.why("chair")
        (miss, *_) = ask.why_not("chair", count=1)
    text = "\n".join(verdict.lines())
    assert re.search("^  unseen: (seat and )?back – no view looks at t1 from ", text, re.MULTILINE)
    assert "as seen from view" in text
    assert list(miss.unseen) == list(verdict.unseen)
    data = verdict.to_json()["unseen"][0]
    assert set(data) == {"why", "look", "direction", "place"}


def test_the_whole_proof_says_how_much_of_a_thing_is_only_taken_to_be_full() -> None:
    whole = build("cuboid", {})
    scan = scanned(whole, eye_at(whole, 30.0, 30.0))
    said, shares = [], []
    for scene in (whole, scan):
        with asked([f.row for f in (*scene_facts(scene), *facts_on_demand(scene))]) as ask:
            verdict = ask.why("box")
        said.append([line for line in verdict.lines(full=True) if line.startswith("  space:")])
        shares.append(verdict.to_json().get("assumed"))
        assert not any(line.startswith("  space:") for line in verdict.lines())
    (of_whole, (of_scan,)), (none, share) = said, shares
    assert (of_whole, none) == ([], None)
    assert 0.5 < share < 1.0
    assert of_scan.startswith(f"  space: {share:.0%} of what t1 fills was not seen;")


def test_what_is_in_no_piece_of_a_whole_thing_is_said_with_its_place() -> None:
    low, high = (0.5, -0.1, 0.25), (1.0, 0.1, 0.5)
    whole = replace(sight(whole=True), filled=0.96, gaps=((low, high),))
    (found,) = told(whole)
    bottom = min(z for _, _, z in CUBE)
    span = f"{0.25 - bottom:.2g}–{0.5 - bottom:.2g} m up"
    assert found.why.startswith("4% of the volume of t1 is in no piece: towards +x")
    assert found.why.endswith(span)
    assert not told(sight(whole=True))
