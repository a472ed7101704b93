"""Facts on their way into a scene: exactly, in order, and refused by name."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Term
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact, format_fact_clause
from facetlog.kb.loading.fact_columns import build_facts_request

NAMES = st.text(st.characters(exclude_categories=["Cs", "Co"]), max_size=6) | st.sampled_from(
    ["", "\x1f", "\0", "\n", "[]", "f1", "😀", "'", "\\"]
)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.integers() | st.just(2**200)
SCENES = st.lists(
    st.tuples(st.just("face"), NAMES)
    | st.tuples(st.just("area"), NAMES, NUMBERS, NUMBERS)
    | st.tuples(st.just("corner"), NAMES, st.integers(), NAMES)
    | st.tuples(st.just("point_cov"), NAMES, *[NUMBERS] * 6)
    | st.tuples(st.just("observed"), NAMES, NAMES, *[st.floats(0, 1e9)] * 4),
    max_size=12,
)
ARITY = {"face": 1, "area": 3, "corner": 3, "point_cov": 7, "observed": 6}


def loaded(base: KnowledgeBase, facts: list[Fact], name: str) -> list[tuple[Term, ...]]:
    """Return facts of one kind that the scene holds, atoms as texts."""
    base.load_scene("s", facts)
    variables = ",".join(f"V{i}" for i in range(ARITY[name]))
    rows = base.query(f"{name}({variables})", scenes=("s",))
    return [tuple(v.name if isinstance(v, Atom) else v for v in row) for row in rows]


@settings(max_examples=60)
@given(SCENES)
def test_facts_arrive_exactly_and_in_order(base: KnowledgeBase, facts: list[Fact]) -> None:
    for name in ARITY:
        wanted = [fact[1:] for fact in facts if fact[0] == name]
        found = loaded(base, facts, name)
        # repr tells 0.0 from -0.0 and 1 from 1.0.
        assert repr(found) == repr(wanted)


@pytest.mark.parametrize(
    ("fact", "named"),
    [
        (("wobbly", "f1", 0.5), r"wobbly\(f1,0\.5\)"),
        (("area", "f1", 2.0), r"area\(f1,2\.0\)"),
        (("halt",), "halt"),
    ],
)
def test_a_fact_that_the_schema_lacks_is_named(base: KnowledgeBase, fact: Fact, named: str) -> None:
    with pytest.raises(EngineError, match=named):
        base.load_scene("bad", [("face", "f1"), fact])
    assert "bad" not in base.scenes


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_a_number_that_is_none_is_refused(number: float) -> None:
    fact: Fact = ("area", "f1", number, 0.0)
    with pytest.raises(ValueError, match="area"):
        format_fact_clause(fact)
    with pytest.raises(ValueError, match="area"):
        build_facts_request("s", [fact])


@pytest.mark.parametrize(
    "fact", [("area", "f1", (1.0,)), ("area", None), (1, "f1"), ("area", b"f")]
)
def test_what_is_no_fact_is_refused(fact: Fact) -> None:
    with pytest.raises(TypeError):
        format_fact_clause(fact)
    with pytest.raises(TypeError):
        build_facts_request("s", [fact])


def test_no_text_becomes_a_goal(base: KnowledgeBase) -> None:
    names = ["x').\n:- halt.\n", "]), halt, (["]
    facts: list[Fact] = [("corner", name, number, name) for name in names for number in (1, 2.5)]
    assert loaded(base, facts, "corner") == [fact[1:] for fact in facts]
