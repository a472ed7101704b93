"""Questions as text: what they ask, which columns they have, where a fault is."""

from collections.abc import Iterator
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import QueryError
from facetlog.kb.engine.engine import decode_piece
from facetlog.kb.engine.engine_pool import engine_pool
from facetlog.kb.engine.terms import Atom, Failure, Struct, Term, Var, decode_reply
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.fact_schema import FACT_SCHEMA

from .hostile_cases import FACTS

F1, F2, S, T1 = Atom("f1"), Atom("f2"), Atom("s"), Atom("t1")


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        base.load_scene("s", FACTS)
        base.define("double", 2, lambda x, _: [(x, 2 * x)] if isinstance(x, int) else [])
        yield base


def ask(base: KnowledgeBase, question: str, **given: Term) -> list[dict[str, Term]]:
    answers = base.query(question, bindings=given)
    return [dict(zip(answers.names, row, strict=True)) for row in answers]


@pytest.mark.parametrize(
    ("question", "answers"),
    [
        ("face(F)", [{"F": F1}, {"F": F2}]),
        ("  face(F) . % all of them", [{"F": F1}, {"F": F2}]),
        ("face(f1)", [{}]),
        ("face(f9)", []),
        ("angle(f1, B, Deg, _Sd)", [{"B": F2, "Deg": 88.0}]),
        ("angle(A, B, D, _), A @< B, abs(D - 90) =< 15", [{"A": F1, "B": F2, "D": 88.0}]),
        ("face_of(t1, F), holds(level(F))", [{"F": F1}]),
        ("face(F), possible(all([upward(F), near(angle(F, f2), 90, 5)]))", [{"F": F1}]),
        ("measure(tilt(F), V, _, K)", [{"F": F1, "V": 2.0, "K": Atom("deg")},
                                       {"F": F2, "V": 88.0, "K": Atom("deg")}]),
        ("verdict(t1, box, State, _)", [{"State": Atom("unknown")}]),
        ("in(S, face(f2))", [{"S": S}]),
        ("double(4, X)", [{"X": 8}]),
        ("face(F) -> true ; F = none", [{"F": F1}]),
        ("\\+ face(f9), forall(face(F), atom(F))", [{}]),
        # all solutions
        ("findall(F-A, tilt(F, A, _), L)",
         [{"L": (Struct("-", (F1, 2.0)), Struct("-", (F2, 88.0)))}]),
        ("aggregate_all(count, face(_), N)", [{"N": 2}]),
        ("aggregate_all(max(A, F), tilt(F, A, _), max(M, F))", [{"M": 88.0, "F": F2}]),
        ("aggregate_all(r(count, min(A), bag(F)), tilt(F, A, _), R)",
         [{"R": Struct("r", (2, 2.0, (F1, F2)))}]),
        ("bagof(F, A^S^tilt(F, A, S), L)", [{"L": (F1, F2)}]),
        ("setof(A, S^( tilt(F, A, S), A > 1 ), L)",
         [{"F": F1, "L": (2.0,)}, {"F": F2, "L": (88.0,)}]),
        ("order_by([desc(A)], tilt(F, A, _))", [{"A": 88.0, "F": F2}, {"A": 2.0, "F": F1}]),
        ("limit(1, offset(1, face(F)))", [{"F": F2}]),
        # closures
        ("include(face, [f1, f9], L)", [{"L": (F1,)}]),
        ("maplist(angle(f1), [f2], Degs, Sds)", [{"Degs": (88.0,), "Sds": (1.0,)}]),
        ("foldl(plus, [1, 2, 3], 0, Sum)", [{"Sum": 6}]),
        ("include(holds, [upward(f1), upward(f9), level(f1)], L)",
         [{"L": (Struct("upward", (F1,)), Struct("level", (F1,)))}]),
        # text, lists, terms, numbers
        ("atomic_list_concat([a, 1, \"b\"], X)", [{"X": Atom("a1b")}]),
        ("split_string(\"a b\", \" \", \"\", P)", [{"P": ("a", "b")}]),
        ("T =.. [f, X], X = 1", [{"T": Struct("f", (1,)), "X": 1}]),
        ("X is 2**100 - 1", [{"X": 2**100 - 1}]),
        ("X is 1 + log2(2**10)", [{"X": 11.0}]),
        ("X is 1 rdiv 3", [{"X": Fraction(1, 3)}]),
        ("M = table, verdict(t1, M, S, _)", [{"M": Atom("table"), "S": Atom("unknown")}]),
        ("X = tabel, face(F), F \\== X, F \\== f1", [{"X": Atom("tabel"), "F": F2}]),
        ("E = 2*3, X is E + 1", [{"E": Struct("*", (2, 3)), "X": 7}]),
        ("X = point(1, \"a\", [b|_])",
         [{"X": Struct("point", (1, "a", Struct("[|]", (Atom("b"), Var("X0")))))}]),
    ],
)  # fmt: skip
def test_what_a_question_says(
    base: KnowledgeBase, question: str, answers: list[dict[str, Term]]
) -> None:
    assert ask(base, question) == answers


@pytest.mark.parametrize(
    ("question", "names"),
    [
        ("angle(B, A, _, _Sd)", ("B", "A")),
        ("X = Y", ("X", "Y")),
        ("findall(F, face(F), L)", ("L",)),
        ("findall(F-L, face(F), L), F = 1", ("F", "L")),
        ("forall(face(F), atom(F))", ()),
        ("\\+ face(F), G = 1", ("G",)),
        ("bagof(G, S^angle(F, G, _, S), L)", ("F", "L")),
        ("aggregate_all(max(D, F), G, angle(F, G, D, _), M)", ("M",)),
        ("aggregate_all(count, face(F), N), ( F = 1 ; true )", ("F", "N")),
        ("in(S, face(F))", ("S", "F")),
        ("once(face(F)) ; ignore(face(G))", ("F", "G")),
        ("maplist(angle(F), Gs, Ds, _)", ("F", "Gs", "Ds")),
        ("double(X, Y)", ("X", "Y")),
    ],
)
def test_columns_are_what_an_answer_can_bind(
    base: KnowledgeBase, question: str, names: tuple[str, ...]
) -> None:
    assert base.query(question).names == names


@pytest.mark.parametrize(
    ("question", "once"),
    [
        ("X = 1", True),
        ("in(a, face(X))", True),
        ("in(S, face(X)), in(R, face(X)), R @< S", True),
        ("findall(F, in(_, face(F)), X)", True),
        ("double(1, X)", True),
        ("face(X)", False),
        ("in(a, face(_)), face(X)", False),
        ("findall(F, face(F), X)", False),
        ("\\+ face(f9), X = 1", False),
        ("maplist(face, [f1]), X = 1", False),
        ("aggregate_all(count, face(_), X)", False),
        ("bagof(F, F^face(F), X)", False),
        ("is_a(_, _) ; X = 1", False),
    ],
)
def test_what_asks_no_scene_is_asked_once(question: str, once: bool) -> None:
    with KnowledgeBase() as base:
        base.load_scene("a", FACTS)
        base.load_scene("b", FACTS)
        base.define("double", 2, lambda x, _: [(x, 2 * x)] if isinstance(x, int) else [])
        assert ("Scene" not in base.query(question).names) == once


@pytest.mark.parametrize(
    ("question", "fault", "message"),
    [
        ("angel(A, B, C, D)", "angel", "angel/4 is no fact and no word of questions; did you mean "
         "angle/4?"),
        ("face(F), angle(F, G)", "angle(F, G)", "angle has 4 arguments, not 2: "
         "angle(F1, F2, Angle, Sd)"),
        ("face_of(T)", "face_of(T)", "face_of has 2 arguments, not 1: face_of(Thing, Face)"),
        ("findall(X, fase(X), L)", "fase", "did you mean face/1?"),
        ("holds(at_most(tlit(f1), 2))", "tlit", "tlit/1 is no measure of the vocabulary; did you "
         "mean tilt?"),
        ("face(F), X is sqr(2)", "sqr", "sqr/1 is no function of arithmetic; did you mean sqrt?"),
        ("X is pie * 2", "pie", "pie is no number; did you mean pi?"),
        ("aggregate_all(maxi(A), tilt(_, A, _), X)", "maxi", "did you mean max?"),
        ("in(s, angel(A, B, C, D))", "angel", "did you mean angle/4?"),
        ("include(fase, [f1], L)", "fase", "did you mean face/1?"),
        ("face(F) face(G)", "f", "a comma, an operator or a full stop is missing here"),
        ("face(F), tilt(F, A, 'x", "'x", "a quotation is not closed"),
        ("face(F), (tilt(F, A, _)", "", "the text ends too early"),
        ("face(F). face(G).", " face(G).", "a question is one goal"),
        ("X = '😀😀', fase(X)", "fase", "did you mean face/1?"),
        ("is_a(T, tabel)", "tabel", "there is no model tabel; did you mean table?"),
        ("verdict(T, box, hold, _)", "hold", "a verdict is holds, fails or unknown"),
        ('is_a(T, "box")', '"box"', "a name has no double quotes: write box"),
        ('tilt("f1", A, _)', '"f1"', "write f1"),
        ("tilt(F, A, _), A != 90", "!=", "X =\\= Y of numbers"),
        ("tilt(F, A, _), A ≤ 90", "≤", "write X =< Y"),
        ("face(F) and tilt(F, A, _)", "and", "write a comma"),
        ("X = 'and != %', not face(X)", "not", "write \\+ before"),
        ("Face(F)", "Face", "write face(...)"),
        ("length(F, L, _), L > 20 cm", "20 cm", "write 0.2 for 20 cm"),
        ("length(F, L, _), L > 0,5", "5", "written with a point"),
        # a constant that is compared with what stands for a model, a verdict or a name
        ("is_a(T, M), M = tabel", "tabel", "did you mean table?"),
        ('is_a(T, M), "box" = M', '"box"', "write box"),
        ("member(M, [box, tabel]), is_a(T, M)", "tabel", "did you mean table?"),
        ("maplist(is_a(t1), [box, tabel])", "tabel", "did you mean table?"),
        ("verdict(T, M, S, D), member(M-S, [box-holds, table-fail])", "fail", "a verdict is holds"),
        ("relation(upward(f1), R), R = yes", "yes", "a relation is true, false or unknown"),
        ('face(F), F == "f1"', '"f1"', "write f1"),
        # words that are asked in another way
        ("area(F, A, _), tilt(F) > 5", "tilt(F)", "tilt(F, Angle, Sd)"),
        ("level(F)", "level(F)", "write holds(level("),
        ("face(F) | edge(F, _, _)", "|", "write a semicolon"),
        ("¬ face(F)", "¬", "write \\+ before"),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_its_place(
    base: KnowledgeBase, question: str, fault: str, message: str
) -> None:
    with pytest.raises(QueryError) as caught:
        base.query(question)
    error = caught.value
    assert message in str(error)
    assert question[error.start : error.end] == fault
    assert error.text == question


def test_given_values_are_values(base: KnowledgeBase) -> None:
    assert ask(base, "angle(A, B, D, _)", A=F1) == [{"B": F2, "D": 88.0}]
    assert ask(base, "X = V", V=Struct("f", (Atom("'), halt, X = ("), "é\0", 2**70))) == [
        {"X": Struct("f", (Atom("'), halt, X = ("), "é\0", 2**70))}
    ]
    assert ask(base, "holds(T)", T=Struct("upward", (F1,))) == [{}]
    assert ask(base, "call(G)", G=Struct("=", (1, 1))) == [{}]


def test_a_value_for_no_variable_is_a_fault(base: KnowledgeBase) -> None:
    with pytest.raises(QueryError, match="no variable Facs; did you mean Face"):
        base.query("face(Face), X = 1", bindings={"Facs": F1})


def test_reading_leaves_operators_and_flags_alone(base: KnowledgeBase) -> None:
    for question in ("X = (a ===> b)", "op(700, xfx, ===>)", ":- op(700, xfx, ===>)"):
        with pytest.raises(QueryError):
            base.query(question)
    with pytest.raises(QueryError, match="syntax error"):
        base.query("X = (a ===> b)")
    assert ask(base, 'X = "s", Y = `ab`') == [{"X": "s", "Y": (97, 98)}]


SCRAPS = [*"()[]{}|,.;'\"`\\ \n%/*_-:^=<>!?@#0159aXé😀\0\a", "face(F)", ":-", "0'", "'é'", ". "]


@settings(max_examples=300)
@given(text=st.lists(st.sampled_from(SCRAPS), max_size=12).map("".join))
def test_any_text_is_answered_or_refused_within_itself(base: KnowledgeBase, text: str) -> None:
    fault = QueryError("", text=text)
    try:
        list(base.query(text, most=3))
    except QueryError as error:
        fault = error
    assert 0 <= fault.start <= fault.end <= len(text)
    assert ask(base, "face(f1)") == [{}]


def words() -> dict[tuple[str, int, str], tuple[str, str]]:
    reply = engine_pool().reply("question_words", "", seconds=9.0)
    found = decode_reply(decode_piece(reply[0]))
    assert not isinstance(found, Failure)
    assert isinstance(found, tuple)
    result = {}
    for word in found:
        match word:
            case Struct("word", (Struct("/", (Atom(n), int(a))), Atom(kind), str(s), str(m))):
                result[n, a, kind] = (s, m)
            case _:
                pytest.fail(f"not a word: {word}")
    return result


def test_every_fact_is_a_word_with_its_arguments(base: KnowledgeBase) -> None:
    known = words()
    for fact in FACT_SCHEMA:
        names = ", ".join(argument.name for argument in fact.arguments)
        assert known[fact.functor, fact.arity, "fact"] == (f"{fact.functor}({names})", fact.meaning)


def test_every_word_has_a_signature_and_a_meaning(base: KnowledgeBase) -> None:
    for (name, arity, kind), (signature, meaning) in words().items():
        assert name in signature, (name, kind)
        assert meaning, (name, arity, kind)
