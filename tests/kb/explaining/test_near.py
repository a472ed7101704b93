"""Near misses of sets of too few or too many, and whether one is a member."""

import json
from collections.abc import Mapping
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import QueryError
from facetlog.kb.explaining.near import list_nearest
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Condition, Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

LIMIT = 0.5
MODELS = """model cart
  "A deck on wheels."
  board deck
  at least 4 blocks wheel where curved(wheel) at least 50 %
  flat: thickness(deck) at most 50 % of width(deck)

model sledge
  "A deck without many wheels."
  board deck
  at most 1 block wheel where curved(wheel) at least 50 %
  flat: thickness(deck) at most 50 % of width(deck)

model rail
  "A bar, and something round."
  bar body
  thin: thickness(body) at most 50 % of width(body)
  round: there is a block other where curved(other) at least 50 %

model holder
  "A board, and a bar beside which something round is."
  board deck
  held: there is a bar arm where arm is bar and there is a block x where curved(x) at least 50 %

model roofed
  "Boards, and a thin level one."
  board left where left is upright
  board right where right is upright
  board back where back is upright
  board roof where roof is level, thickness(roof) at most 1 cm
  large: length(left) at least 10 cm
"""
MODELS += """
model stack
  "Three boards, the first of which is long."
  board first
  board second
  board third
  long: length(first) at least 5 m

model couple
  "Two boards that touch."
  board first
  board second
  touch: first joins second
"""
SIZES = {"board": (1.0, 0.6, 0.1), "bar": (1.0, 0.1, 0.1), "block": (0.1, 0.1, 0.1)}


def pieces(rounds: Mapping[str, float], shapes: Mapping[str, str] = {}) -> list[Fact]:
    """Return the facts of a deck p1 and blocks, or other shapes, of these roundnesses."""
    facts: list[Fact] = [("scene", "s"), ("scale", "metric"), ("thing", "t1"), ("whole", "t1")]
    for name, curved in {"p1": 0.0, **rounds}.items():
        size = SIZES[shapes.get(name, "board" if name == "p1" else "block")]
        facts += [("piece", name), ("piece_of", name, "t1"), ("piece_measured", name)]
        facts += [("piece_size", name, *size, 0.001), ("piece_round", name, curved)]
    return facts


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> KnowledgeBase:
    path = tmp_path_factory.mktemp("near") / "near.model"
    path.write_text(MODELS, encoding="utf-8")
    base = KnowledgeBase()
    base.load_rules(path)
    return base


def why(base: KnowledgeBase, facts: list[Fact], model: str = "cart", **parts: str) -> Verdict:
    base.load_scene("s", facts)
    return base.why("s", model, parts=parts)


def wheel(verdict: Verdict, label: str = "wheel") -> Condition:
    return next(c for c in verdict.conditions if c.label == label)


def test_the_next_one_of_a_count_is_named_with_what_it_lacks(base: KnowledgeBase) -> None:
    rounds = {"p2": 0.9, "p3": 0.9, "p4": 0.9, "p5": 0.1, "p6": 0.4231}
    said = "\n".join(why(base, pieces(rounds)).lines())
    assert "3 were found, at least 4 are wanted" in said
    assert "nearest p6: curved = 42.31 %, needs at least 50 %" in said


@settings(max_examples=25, deadline=None)
@given(st.lists(st.integers(0, 49), min_size=1, max_size=6), st.randoms())
def test_the_nearest_misses_by_the_least_whatever_the_order(
    base: KnowledgeBase, hundredths: list[int], random: Random
) -> None:
    values = [number / 100 for number in hundredths]
    rounds = {f"p{number}": value for number, value in enumerate(values, start=2)}
    facts = pieces(rounds)
    random.shuffle(facts)
    near = wheel(why(base, facts)).near
    found = [rounds[one.name] for one in near if one.name in rounds]
    assert found[0] == max(values)
    assert found == sorted(values, reverse=True)
    for one in list_nearest(near):
        miss, least = LIMIT - rounds[one.name], LIMIT - max(values)
        assert miss - least <= 0.1 * miss + 1e-9


def test_those_that_miss_alike_are_joined(base: KnowledgeBase) -> None:
    rounds = {"p2": 0.42, "p3": 0.42, "p4": 0.421, "p5": 0.1}
    verdict = why(base, pieces(rounds))
    assert {one.name for one in list_nearest(wheel(verdict).near)} == {"p2", "p3", "p4"}
    assert "p2–p3 likewise" in "\n".join(verdict.lines())


def test_of_too_many_the_least_sure_one_is_named(base: KnowledgeBase) -> None:
    verdict = why(base, pieces({"p2": 0.9, "p3": 0.51, "p4": 0.8}), "sledge")
    condition = wheel(verdict)
    assert condition.proof.state is State.FAILS
    assert (condition.near[0].sort, condition.near[0].name) == ("many", "p3")


def test_what_should_be_there_is_named(base: KnowledgeBase) -> None:
    facts = pieces({"p2": 0.3, "p3": 0.4}, {"p1": "bar"})
    assert wheel(why(base, facts, "rail"), "round").near[0].name == "p3"


def test_of_a_set_within_a_set_the_nearest_is_named(base: KnowledgeBase) -> None:
    facts = pieces({"p2": 0.0, "p3": 0.4, "p4": 0.3}, {"p2": "bar"})
    verdict = why(base, facts, "holder")
    near = wheel(verdict, "held").near[0]
    assert (near.name, near.within[0].name) == ("p2", "p3")
    assert "nearest p2: nearest p3: curved = 40 %" in "\n".join(verdict.lines())


def test_a_piece_of_another_shape_is_said_to_be_one(base: KnowledgeBase) -> None:
    said = "\n".join(why(base, pieces({"p2": 0.9}), "rail", body="p1").lines())
    assert "p1 is no bar: it is a board (thickness 16.67 % of width, limit 35 %)" in said
    said = "\n".join(why(base, pieces({"p2": 0.9}), "cart", deck="p2").lines())
    assert "p2 is no board: it is a block (thickness 100.0 % of width, limit 35 %)" in said


@pytest.mark.parametrize(
    ("name", "state", "played"),
    [("p2", State.HOLDS, ()), ("p3", State.FAILS, ()), ("p1", State.FAILS, ("deck",))],
)
def test_one_is_asked_whether_it_is_a_member(
    base: KnowledgeBase, name: str, state: State, played: tuple[str, ...]
) -> None:
    verdict = why(base, pieces({"p2": 0.9, "p3": 0.4}), wheel=name)
    (member,) = verdict.asked
    assert (member.role, member.name, member.state, member.played) == (
        "wheel",
        name,
        state,
        played,
    )
    assert json.dumps(member.to_json(None))
    assert verdict.parts == base.why("s", "cart").parts


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(0, 100), min_size=1, max_size=5))
def test_members_are_those_of_the_verdict(base: KnowledgeBase, hundredths: list[int]) -> None:
    rounds = {f"p{number}": value / 100 for number, value in enumerate(hundredths, start=2)}
    members = next(p.faces for p in why(base, pieces(rounds)).parts if p.role == "wheel")
    for name in rounds:
        (asked,) = base.why("s", "cart", parts={"wheel": name}).asked
        assert (asked.state is State.HOLDS) == (name in members)


def test_what_cannot_be_a_member_is_an_error(base: KnowledgeBase) -> None:
    facts = [*pieces({"p2": 0.9}), ("face", "f1"), ("part_of", "f1", "t1")]
    with pytest.raises(QueryError, match="wheel=f1: the set has no members of that kind"):
        why(base, facts, wheel="f1")
    with pytest.raises(QueryError, match="p9"):
        why(base, facts, wheel="p9")


def test_only_who_asks_why_pays_for_it(base: KnowledgeBase) -> None:
    base.load_scene("s", pieces({"p2": 0.4}))
    assert not any(c.near for c in base.judge("s", "cart", "t1").conditions)
    (miss, *_) = base.why_not("s", "cart")
    assert wheel(miss).near


@pytest.mark.parametrize("level", ["p2", "p5", "p9"])
def test_a_single_part_is_missed_nearest_by_what_lies_as_it_should(
    base: KnowledgeBase, level: str
) -> None:
    names = {f"p{number}": "board" for number in range(2, 10)}
    facts = [
        *pieces(dict.fromkeys(names, 0.0), names),
        ("explained", "t1", 1.0),
        ("up", 0.0, 0.0, 1.0),
    ]
    facts += [("piece_tilt", p, 0.0 if p == level else 90.0, 0.1) for p in ("p1", *names)]
    parts = {part.role: part.faces for part in why(base, facts, "roofed").parts}
    assert parts["roof"] == (level,)


@pytest.mark.parametrize("role", ["first", "second", "third"])
@pytest.mark.parametrize("piece", ["p1", "p2", "p3"])
def test_a_part_that_is_given_changes_places_with_what_stood_there(
    base: KnowledgeBase, role: str, piece: str
) -> None:
    names = {"p2": "board", "p3": "board"}
    facts = [*pieces(dict.fromkeys(names, 0.0), names), ("explained", "t1", 1.0)]
    verdict = why(base, facts, "stack", **{role: piece})
    parts = {part.role: part.faces for part in verdict.parts}
    assert verdict.state is State.FAILS
    assert parts[role] == (piece,)
    assert sorted(parts.values()) == [("p1",), ("p2",), ("p3",)]


@pytest.mark.parametrize(
    ("explained", "between", "state"),
    [(0.9, True, State.UNKNOWN), (0.9, False, State.FAILS), (1.0, True, State.FAILS)],
)
def test_pieces_touch_or_not_unless_volume_between_them_is_in_no_piece(
    base: KnowledgeBase, explained: float, between: bool, state: State
) -> None:
    facts = [*pieces({"p2": 0.0}, {"p2": "board"}), ("explained", "t1", explained)]
    facts += [("may_join", "p1", "p2"), ("may_join", "p2", "p1")] if between else []
    verdict = why(base, facts, "couple", first="p1", second="p2")
    touch = next(c for c in verdict.conditions if c.label == "touch")
    assert touch.proof.state is state
