"""Answers from arrays are those of Prolog: the same rows in the same order, and the same errors."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import EngineError, FacetlogError, QueryError
from facetlog.kb import questions
from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact
from facetlog.kb.questions import PosedQuestion

SCENES = ("s", "t")
NAMES = ("f1", "f2", "f10", "F", "é", "", "[]", "a b")

names = st.sampled_from(NAMES)
floats = st.sampled_from([0.0, -0.0, 0.5, 90.0, 90.5, -3.25, 1e308, 5e-324])
integers = st.sampled_from([0, 1, 90, -7, 1 << 53, (1 << 53) + 1, 1 << 64])
numbers = st.one_of(floats, floats, integers)


@st.composite
def some_facts(draw: st.DrawFn) -> list[Fact]:
    """Few names and numbers, so that facts join, compare equal, and occur twice."""
    value = draw(st.sampled_from([floats, floats, integers, numbers, st.one_of(numbers, names)]))
    fact = st.one_of(
        st.tuples(st.just("face"), names),
        st.tuples(st.just("evidence"), names, names),
        st.tuples(st.just("area"), names, value, floats),
        st.tuples(st.just("angle"), names, names, value, floats),
        st.tuples(st.just("angle"), names, names, value, floats),
    )
    return draw(st.lists(fact, max_size=14))


VARIABLES = ("A", "B", "C", "X", "Y", "_")


@st.composite
def arguments(draw: st.DrawFn, *, number: bool) -> str:
    if draw(st.integers(0, 5)):
        return draw(st.sampled_from(VARIABLES if not number else ("X", "Y", "Z", "_")))
    return draw(
        st.sampled_from(["90", "0.0", "-0.0", "90.5", "f1"] if number else ["f1", "é", "[]"])
    )


def fact(draw: st.DrawFn) -> str:
    kind = draw(st.sampled_from(["face/n", "evidence/nn", "area/nvv", "angle/nnvv", "angle/nnvv"]))
    name, _, sorts = kind.partition("/")
    args = [draw(arguments(number=sort == "v")) for sort in sorts]
    return f"{name}({', '.join(args)})"


def expression(draw: st.DrawFn, depth: int = 2) -> str:
    if not depth or draw(st.booleans()):
        return draw(st.sampled_from(["X", "Y", "Z", "90", "0.5", "-7", "1.0e308", "A"]))
    left, right = (expression(draw, depth - 1) for _ in range(2))
    form = draw(st.sampled_from(["{} + {}", "{} - {}", "{} * {}", "{} / {}", "-({})", "abs({})"]))
    return f"({form.format(left, right)})"


def test_of(draw: st.DrawFn) -> str:
    if draw(st.booleans()):
        op = draw(st.sampled_from(["<", "=<", ">", ">=", "=:=", "=\\="]))
        return f"{expression(draw)} {op} {expression(draw)}"
    op = draw(st.sampled_from(["@<", "@=<", "@>", "@>=", "==", "\\=="]))
    left, right = (draw(st.sampled_from(["A", "B", "C", "X", "f1", "é"])) for _ in range(2))
    return f"{left} {op} {right}"


test_of.__test__ = False  # type: ignore[attr-defined]


def conjunction(draw: st.DrawFn) -> str:
    more = draw(st.lists(st.sampled_from([fact, fact, test_of]), max_size=4))
    return ", ".join(step(draw) for step in (fact, *more))


@st.composite
def goals(draw: st.DrawFn) -> str:
    """Mostly of what arrays answer."""
    goal = conjunction(draw)
    match draw(st.integers(0, 5)):
        case 0:
            return f"{goal}, \\+ ({conjunction(draw)})"
        case 1:
            what = draw(
                st.sampled_from(["count", "sum(X)", "max(X)", "min(Y)", "max(A)", "bag(X)"])
            )
            return f"aggregate_all({what}, ({goal}), N)"
        case 2:
            return f"aggregate_all(count, ({goal}), N), area(A, X, Y), N > 1"
        case _:
            return goal


@pytest.fixture(autouse=True, scope="module")
def few_facts_are_enough() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(questions, "FEWEST_FACTS", 0)
        yield


@dataclass
class Ways:
    """How many questions were answered on arrays, and whether they may be."""

    base: KnowledgeBase
    arrays: bool = True
    answered: int = 0


@pytest.fixture
def ways(monkeypatch: pytest.MonkeyPatch) -> Iterator[Ways]:
    with KnowledgeBase(Limits(seconds=20)) as base:
        ways = Ways(base)
        asked = PosedQuestion._on_arrays

        def on_arrays(self: PosedQuestion, plan: object) -> Iterator[object]:
            if not ways.arrays:
                raise AssertionError("no array is to be asked")
            yield from asked(self, plan)  # type: ignore[arg-type]
            ways.answered += 1

        monkeypatch.setattr(PosedQuestion, "_on_arrays", on_arrays)
        yield ways


def exact(value: Term) -> object:
    match value:
        case float():
            return value.hex()
        case tuple():
            return tuple(map(exact, value))
        case Struct(functor, args):
            return functor, tuple(map(exact, args))
        case _:
            return type(value), value


def said(ask: Callable[[], Iterator[tuple[Term, ...]]]) -> tuple[list[object], str]:
    """The rows that are answered, and the error after them."""
    rows: list[object] = []
    try:
        rows.extend(map(exact, ask()))
    except FacetlogError as exc:
        return rows, str(exc)
    return rows, ""


def by_prolog(goal: str) -> str:
    """The same question in words that arrays do not know."""
    return f"({goal} ; fail)"


@settings(max_examples=120)
@given(st.data())
def test_arrays_answer_as_prolog_does(data: st.DataObject) -> None:
    facts = [data.draw(some_facts(), label=name) for name in SCENES]
    asked = data.draw(st.lists(goals(), min_size=1, max_size=6), label="goals")
    one = data.draw(st.booleans(), label="one scene")
    most = data.draw(st.sampled_from([None, None, 0, 1, 3]), label="most")
    base = shared_base()
    for name, loaded in zip(SCENES, facts, strict=True):
        base.load_scene(name, loaded)
    scenes = SCENES[:1] if one else SCENES
    for goal in asked:
        found = said(lambda: base.query(goal, scenes=scenes, most=most))  # noqa: B023
        wanted = said(lambda: base.query(by_prolog(goal), scenes=scenes, most=most))  # noqa: B023
        assert found[0] == wanted[0], goal
        assert bool(found[1]) == bool(wanted[1]), goal


_BASES: list[KnowledgeBase] = []


def shared_base() -> KnowledgeBase:
    if not _BASES:
        _BASES.append(KnowledgeBase(Limits(seconds=20)))
    return _BASES[0]


@st.composite
def measured_faces(draw: st.DrawFn) -> list[Fact]:
    """Faces with angles about 90, some of them twice, at a limit, or of a face not measured."""
    faces = draw(st.lists(names, max_size=6))
    angles = st.one_of(st.sampled_from([75.0, 105.0, 90.0]), st.floats(70, 110))
    deviations = st.sampled_from([0.0, 0.1, 3.0, 40.0])
    facts: list[Fact] = [("face", name) for name in faces]
    evidence = st.sampled_from(["measured", "measured", "measured", "implied"])
    facts += [("evidence", name, draw(evidence)) for name in faces]
    pairs = st.tuples(st.just("angle"), names, names, angles, deviations)
    adjoin = st.tuples(st.just("adjoins"), names, names, st.just("e1"))
    return facts + draw(st.lists(st.one_of(pairs, pairs, adjoin), max_size=30))


PAIR_TESTS = (
    "near(angle(X, Y), 90, 15)",
    "near(angle(Y, X), 90, 15.0)",
    "between(angle(X, Y), 75, 105)",
    "at_least(angle(X, Y), 75)",
    "at_most(angle(X, Y), 105.0)",
    "at_most(angle(X, Y), tolerance(upright) * 10)",
    "fading(near(angle(X, Y), 90, 15), 5)",
    "near(angle(X, X), 90, 15)",
    "adjoins(X, Y)",
    "not(adjoins(X, Y))",
    "at_most(offset(X, Y), 3)",
)
FACE_LISTS = ("[A]", "[A, B]", "[A, B, C]", "[A, f1]", "[f2, B, C]", "[A, A]", "[A, X]", "[]", "L")


@settings(max_examples=60)
@given(st.data())
def test_pairs_on_arrays_are_those_of_prolog(data: st.DataObject) -> None:
    base = shared_base()
    base.load_scene("s", data.draw(measured_faces(), label="facts"))
    test = data.draw(st.sampled_from(PAIR_TESTS))
    for faces in data.draw(st.lists(st.sampled_from(FACE_LISTS), min_size=1, max_size=4)):
        goal = f"each_pair(X, Y, {faces}, {test})"
        counted = f"aggregate_all(count, {goal}, N)"
        for asked in (goal, counted, f"{goal}, angle(A, B, D, _), D > 80"):
            found = said(lambda: base.query(asked, scenes=["s"]))  # noqa: B023
            wanted = said(lambda: base.query(by_prolog(asked), scenes=["s"]))  # noqa: B023
            assert found[0] == wanted[0], asked
            assert bool(found[1]) == bool(wanted[1]), asked


def test_pairs_of_a_crisp_base_have_no_deviations() -> None:
    facts: list[Fact] = [("face", "f1"), ("face", "f2"), ("angle", "f1", "f2", 104.0, 40.0)]
    facts += [("evidence", name, "measured") for name in ("f1", "f2")]
    for crisp in (False, True):
        with KnowledgeBase(crisp=crisp) as base:
            base.load_scene("s", facts)
            found = list(base.query("each_pair(X, Y, [A, B], near(angle(X, Y), 90, 15))"))
            assert len(found) == crisp


def test_pairs_follow_the_facts(ways: Ways) -> None:
    goal = "each_pair(X, Y, [A, B], near(angle(X, Y), 90, 15))"
    facts = [*FACTS, *((("evidence", f, "measured")) for f in ("f1", "f2", "f3"))]
    scene = ways.base.load_scene("s", facts)
    assert [tuple(map(str, row)) for row in ways.base.query(goal)] == [("f1", "f2")]
    ways.base._facts.add(scene.module, [("angle", "f2", "f3", 88.0, 0.1)])
    assert len(list(ways.base.query(goal))) == 2
    assert ways.answered == 2


FACTS: list[Fact] = [
    ("face", "f1"),
    ("face", "f2"),
    ("face", "f3"),
    ("angle", "f1", "f2", 90.5, 0.1),
    ("angle", "f2", "f1", 90.5, 0.1),
    ("angle", "f3", "f1", 20.0, 0.1),
    ("area", "f1", 2.0, 0.1),
]


@pytest.mark.parametrize(
    "goal",
    [
        "face(F)",
        "angle(_, _, X, Sd)",
        "angle(A, f1, X, _), face(A)",
        "angle(A, B, X, _), A @< B, abs(X - 90) =< 15",
        "face(A), angle(A, B, X, _), area(B, Y, _), X > Y",
        "face(F), \\+ area(F, _, _)",
        "aggregate_all(count, (face(A), face(B), A \\== B), N)",
        "aggregate_all(sum(X), angle(_, _, X, _), S)",
        "aggregate_all(max(X), (angle(A, _, X, _), A == f9), S)",
        "each_pair(X, Y, [A, B], near(angle(X, Y), 90, 15))",
        "aggregate_all(count, each_pair(X, Y, [A, B, C], adjoins(X, Y)), N)",
    ],
)
def test_what_looks_facts_up_is_answered_on_arrays(ways: Ways, goal: str) -> None:
    ways.base.load_scene("s", FACTS)
    found = said(lambda: ways.base.query(goal))
    assert ways.answered == 1
    ways.arrays = False
    assert found == said(lambda: ways.base.query(by_prolog(goal)))


@pytest.mark.parametrize(
    "goal",
    [
        "(face(F) ; fail)",
        "face(f1)",
        "angle(f1, B, X, _), X > 80",
        "is_a(T, box)",
        "shared_edge(A, B, E)",
        "in(S, face(F))",
        "face(F), F = f1",
        "X > 1, angle(_, _, X, _)",
        "face(F), atom_length(F, N)",
        "limit(2, face(F))",
        "own(F)",
        "face(F), holds(near(angle(f1, F), 90, 15))",
    ],
)
def test_all_else_is_answered_by_prolog(ways: Ways, goal: str) -> None:
    ways.base.define("own", 1, lambda _: [(Atom("f1"),)])
    ways.base.load_scene("s", FACTS)
    ways.arrays = False
    said(lambda: ways.base.query(goal))
    assert ways.answered == 0


def test_of_few_facts_prolog_is_asked(ways: Ways, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(questions, "FEWEST_FACTS", 50)
    for count, on_arrays in ((49, False), (50, True)):
        ways.base.load_scene("s", [("face", f"f{i}") for i in range(count)])
        answers = ways.base.query("face(F)")
        assert answers.on_arrays == on_arrays
        assert len(list(answers)) == count
        assert ways.answered == on_arrays


def test_a_python_function_hides_the_fact_of_its_name(ways: Ways) -> None:
    ways.base.load_scene("s", FACTS)
    ways.base.define("face", 1, lambda _: [(7,)])
    assert list(ways.base.query("face(F)")) == [(7,)]
    assert ways.answered == 0


def test_facts_are_those_of_the_scene_as_it_is(ways: Ways) -> None:
    ways.base.load_scene("s", FACTS, on_demand=lambda: [("line", "view1", "e1", "f1", "f2")])
    assert [str(f) for (f,) in ways.base.query("face(F)")] == ["f1", "f2", "f3"]
    before = ways.base.query("face(F)")
    ways.base.load_scene("s", [("face", "g")])
    assert [str(f) for (f,) in ways.base.query("face(F)")] == ["g"]
    assert [str(f) for (f,) in before] == ["f1", "f2", "f3"]
    ways.base.drop_scene("s")
    assert list(ways.base.query("face(F)")) == []


def test_facts_that_come_later_are_looked_up_too(ways: Ways) -> None:
    scene = ways.base.load_scene("s", FACTS)
    assert len(list(ways.base.query("face(F)"))) == 3
    ways.base._facts.add(scene.module, [("face", "f4"), ("area", "f4", 1.5, 0.1)])
    assert [str(f) for (f,) in ways.base.query("face(F)")] == ["f1", "f2", "f3", "f4"]
    assert [x for _, x in ways.base.query("area(F, X, _)")] == [2.0, 1.5]


def test_a_scene_that_was_loaded_compiled_is_looked_up(ways: Ways) -> None:
    def nobody() -> Iterator[Fact]:
        raise AssertionError("the facts are to come from the cache")
        yield

    key = "a scene of test_array_answers"
    ways.base.load_scene("s", FACTS, cache_key=key)
    first = list(ways.base.query("angle(A, B, X, _)"))
    ways.base.load_scene("s", nobody(), cache_key=key)
    assert list(ways.base.query("angle(A, B, X, _)")) == first
    assert ways.answered == 2


def test_an_error_in_the_middle_comes_after_the_same_answers(ways: Ways) -> None:
    count = 5000
    facts: list[Fact] = [("area", f"f{i}", float(i + 1), 0.1) for i in range(count)]
    facts += [("angle", f"f{i}", "g", 1e308 if i == count - 1 else 1.0, 0.1) for i in range(count)]
    ways.base.load_scene("s", facts)
    goal = "area(F, X, _), angle(F, _, Y, _), X * Y > 0"
    rows, error = said(lambda: ways.base.query(goal))
    assert (rows, error) == said(lambda: ways.base.query(by_prolog(goal)))
    assert len(rows) == count - 1
    assert error


def test_time_is_limited_on_arrays(ways: Ways) -> None:
    ways.base.load_scene("s", [("face", f"f{i}") for i in range(3000)])
    goal = "face(A), face(B), face(C), A == B, B \\== A"
    with pytest.raises(EngineError, match="the time limit was reached"):
        list(ways.base.query(goal, limits=Limits(seconds=0.3)))


def test_a_long_answer_begins_at_once_and_may_be_left(ways: Ways) -> None:
    ways.base.load_scene("s", [("face", f"f{i}") for i in range(3000)])
    with ways.base.query("face(A), face(B), face(C)", limits=Limits(seconds=5)) as answers:
        assert next(answers) == (Atom("f0"),) * 3
        answers.close()
        assert list(answers) == []


def test_a_fault_of_a_question_is_one_where_it_is_asked(ways: Ways) -> None:
    ways.base.load_scene("s", FACTS)
    with pytest.raises(QueryError):
        ways.base.query("angle(A, B, X, _), A > 3")
    ways.base.load_scene("t", FACTS)
    with pytest.raises(QueryError, match="Scene is the name"):
        ways.base.query("face(Scene)")


def test_an_isolated_base_answers_the_same() -> None:
    with KnowledgeBase(isolated=True) as base:
        base.load_scene("s", FACTS)
        goal = "angle(A, B, X, _), A @< B"
        assert list(base.query(goal)) == list(base.query(by_prolog(goal)))


def test_sums_are_added_in_the_order_of_the_facts(ways: Ways) -> None:
    values = [0.1 * i * (-1) ** i + 1e-9 for i in range(2000)]
    ways.base.load_scene("s", [("area", f"f{i}", x, 0.0) for i, x in enumerate(values)])
    ((total,),) = ways.base.query("aggregate_all(sum(X), area(_, X, _), S)")
    assert ways.answered == 1
    running = 0.0
    for x in values:
        running += x
    assert total == running
    assert not math.isclose(running, 0.0)
