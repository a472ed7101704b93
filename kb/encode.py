"""Where a Python field meets a functor: facts to Prolog text, Prolog's verdicts to Verdict."""

from collections.abc import Iterable, Iterator
from typing import TypeAlias

from facetlog.errors import EngineError
from facetlog.kb.proof import Comparison, Note, Proof, State, Within
from facetlog.kb.terms import Atom, Struct, Term, Var, term_text
from facetlog.kb.verdict import Condition, Part, Size, Verdict

__all__ = ["Fact", "decode_verdict", "fact_text", "facts_program"]

Fact: TypeAlias = tuple[str | int | float, ...]
"""A functor's name and its arguments: strings are atoms."""

UNSEEN = "unseen"  # what rules write for a part of which no face was measured


def fact_text(fact: Fact) -> str:
    """The fact as one clause, with its full stop.

    >>> fact_text(("angle", "f1", "f2", 90.25, 1e-05))
    "'angle'('f1','f2',90.25,1.0e-05)."
    """
    functor, *args = fact
    if not isinstance(functor, str):
        raise TypeError(f"a fact begins with the name of its functor, not {functor!r}")
    terms = tuple(Atom(a) if isinstance(a, str) else a for a in args)
    return term_text(Struct(functor, terms)) + "."


def facts_program(facts: Iterable[Fact]) -> Iterator[str]:
    """Lines of a file that `swipl` loads by itself, for `facts.pl`."""
    yield "% Facts of one scene; docs/facts.md says what they mean."
    yield ":- style_check(-discontiguous)."
    yield from map(fact_text, facts)


def decode_verdict(term: Term, *, length_unit: str | None) -> Verdict:
    """The verdict that verdict/9 of kb/judge.pl says."""
    match term:
        case Struct(
            "verdict",
            (
                Atom(model),
                Atom(thing),
                Atom(state),
                int() | float() as low,
                int() | float() as high,
                tuple(parts),
                tuple(sizes),
                tuple(conditions),
                int(also),
            ),
        ):
            return Verdict(
                model=model,
                thing=thing,
                state=State(state),
                degree=float(low),
                degree_at_most=float(high),
                parts=tuple(map(_part, parts)),
                sizes=tuple(map(_size, sizes)),
                conditions=tuple(map(_condition, conditions)),
                also=also,
                length_unit=length_unit,
            )
    raise _unreadable(term)


def _part(term: Term) -> Part:
    match term:
        case Struct("-", (Atom(role), Atom(name))):
            return Part(role, () if name == UNSEEN else (name,))
        case Struct("-", (Atom(role), tuple(names))):
            return Part(role, tuple(str(n) for n in names))
    raise _unreadable(term)


def _size(term: Term) -> Size:
    match term:
        case Struct("size", (Atom(name), int() | float() as value, int() | float() as sd)):
            return Size(name, float(value), float(sd))
    raise _unreadable(term)


def _condition(term: Term) -> Condition:
    match term:
        case Struct("condition", (Atom(label), str(reason), proof)):
            return Condition(label, reason, _proof(proof))
    raise _unreadable(term)


def _proof(term: Term) -> Proof:
    match term:
        case Struct(
            "proof",
            (
                Atom(state),
                int() | float() as low,
                int() | float() as high,
                test,
                detail,
                tuple(kids),
            ),
        ):
            return Proof(
                state=State(state),
                low=float(low),
                high=float(high),
                test=readable(test),
                detail=_detail(test, detail),
                children=tuple(map(_proof, kids)),
            )
    raise _unreadable(term)


def _detail(test: Term, detail: Term) -> Comparison | Note:
    match test, detail:
        case (
            Struct(_, (measure, *_)),
            Struct(
                "compared" | "uncertain",
                (int() | float() as value, int() | float() as sd, kind, within),
            ),
        ):
            return Comparison(
                readable(measure), float(value), float(sd), readable(kind), _within(within)
            )
        case _, Struct(name, (argument,)):
            return Note(name, readable(argument))
        case _, Atom(name):
            return Note(name)
    raise _unreadable(detail)


def _within(term: Term) -> Within:
    match term:
        case Struct(sort, limits):
            return Within(sort, tuple(float(x) for x in limits if isinstance(x, int | float)))
    raise _unreadable(term)


def readable(term: Term) -> str:
    """The term as a person writes it.

    >>> readable(Struct("at_least", (Struct("share", (Atom("f1"),)), 0.8)))
    'at_least(share(f1), 0.8)'
    """
    match term:
        case Struct("+" | "-" | "*" | "/" as operator, (left, right)):
            return f"{readable(left)}{operator}{readable(right)}"
        case Struct("-", (inside,)):
            return f"-{readable(inside)}"
        case Struct(functor, args):
            return f"{functor}({', '.join(map(readable, args))})"
        case tuple():
            return f"[{', '.join(map(readable, term))}]"
        case Atom(name) | Var(name):
            return name
        case _:
            return str(term)


def _unreadable(term: Term) -> EngineError:
    return EngineError(f"Prolog's verdict cannot be read: {readable(term)[:80]}")
