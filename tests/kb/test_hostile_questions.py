"""Hostile questions: refused with the place of the fault, or ended by a limit; no effects."""

import time
from collections.abc import Iterator

import pytest

from facetlog.errors import EngineError, FacetlogError, InputError, QueryError
from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from tests.patience import allowed

from .hostile_cases import Aviary, cases

LIMITS = Limits(seconds=1.0, inferences=2_000_000, stack_mb=64)

REFUSED = cases("refused_questions.txt")
BOUNDED = cases("bounded_questions.txt")

MADE = {
    "a question longer than any": ("true, " * 10_000 + "true", "too long"),
    "ten thousand brackets": ("X = " + "[" * 4_900 + "]" * 4_900, "nested too deeply"),
    "more brackets than that": ("(" * 15_000, "too many brackets"),
    "ten thousand negations": ("\\+ " * 5_000 + "true", "nested too deeply"),
    "ten thousand levels": ("X = " + "f(" * 4_000 + "1" + ")" * 4_000, "nested too deeply"),
    "NUL": ("X = 'a\0b'", "a control character (code 0)"),
    "a text that runs backwards": ("X = '\u202e'", "the direction of writing"),
    "half a character, escaped": ("X = '\\xD800\\'", "syntax error"),
}


@pytest.fixture(scope="module")
def aviary(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Aviary]:
    with KnowledgeBase(LIMITS) as base:
        yield Aviary(base, tmp_path_factory.mktemp("questions"))


@pytest.mark.parametrize(
    ("question", "fault", "message"),
    [(question, *mark.split(" >>> ")) for question, mark, _ in REFUSED],
)
def test_a_hostile_question_is_refused_at_its_fault(
    aviary: Aviary, question: str, fault: str, message: str
) -> None:
    with aviary.unchanged(), pytest.raises(QueryError) as caught:
        aviary.rows(question)
    error = caught.value
    assert message in str(error)
    assert error.text == question
    assert question[error.start : error.end] == fault
    assert "\n" not in str(error)


@pytest.mark.parametrize(("question", "message", "_"), BOUNDED)
@pytest.mark.slow
def test_a_question_without_end_ends_at_a_limit(
    aviary: Aviary, question: str, message: str, _: str
) -> None:
    begin = time.monotonic()
    with aviary.unchanged(), pytest.raises((EngineError, InputError), match=message):
        aviary.rows(question)
    assert time.monotonic() - begin < allowed(LIMITS.seconds)


@pytest.mark.parametrize("title", MADE)
def test_a_monstrous_question_is_refused_at_once(aviary: Aviary, title: str) -> None:
    question, message = MADE[title]
    begin = time.monotonic()
    with aviary.unchanged(), pytest.raises(QueryError) as caught:
        aviary.rows(question)
    assert time.monotonic() - begin < allowed(1.0)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("question", "value"),
    [
        ("Given", Atom("halt")),
        ("call(Given)", Struct("shell", (Atom("true"),))),
        ("findall(X, Given, L)", Struct(":", (Atom("user"), Atom("halt")))),
        ("maplist(Given, [1])", Atom("halt")),
        ("fact(Given)", Atom("halt")),
        ("in(s, Given)", Struct(",", (Atom("true"), Atom("halt")))),
        ("X is Given", Struct("shell", (Atom("true"),))),
        ("holds(Given)", Struct("at_most", (Struct("shell", (1,)), 3))),
    ],
)
def test_a_given_value_never_becomes_a_goal_unseen(
    aviary: Aviary, question: str, value: Term
) -> None:
    with aviary.unchanged(), pytest.raises(QueryError) as caught:
        list(aviary.base.query(question, bindings={"Given": value}))
    error = caught.value
    assert "Given" in question[error.start : error.end]


def test_a_given_value_stays_a_value(aviary: Aviary) -> None:
    goal = Struct(",", (Atom("halt"), Struct("shell", (Atom("true"),))))
    with aviary.unchanged():
        assert list(aviary.base.query("X = Given", bindings={"Given": goal})) == [(goal,)]


def test_many_faulty_questions_leave_nothing_behind(aviary: Aviary) -> None:
    with aviary.unchanged():
        for number in range(100):
            with pytest.raises(FacetlogError):
                aviary.rows(f"face(F), halt{number}(F)")


@pytest.mark.parametrize("question", ["X is E**64", "X is E + 1", "X is 3*E, Y is X", "E > 3"])
def test_a_given_number_too_long_for_arithmetic_is_refused(aviary: Aviary, question: str) -> None:
    with aviary.unchanged(), pytest.raises(EngineError, match="the length of a number"):
        list(aviary.base.query(question, bindings={"E": 1 << 70_000}))
