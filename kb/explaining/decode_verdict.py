"""Prolog's verdicts, verdict/10 of judge.pl, as Verdict."""

from collections.abc import Sequence
from dataclasses import replace

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, Side, State, Within
from facetlog.kb.explaining.verdict import Condition, Part, Size, Verdict
from facetlog.kb.explaining.wording import (
    UNSEEN,
    cause_words,
    readable,
    relation_words,
    unknown_words,
)
from facetlog.kb.explaining.wording_of_steps import Tally, model_cause, model_words

__all__ = ["decode_verdict", "decode_verdicts"]


def decode_verdicts(term: Term, *, length_unit: str | None) -> tuple[Verdict, ...]:
    """The verdicts of a list, in its order. Raises EngineError if it cannot be read."""
    if isinstance(term, tuple):
        return tuple(decode_verdict(item, length_unit=length_unit) for item in term)
    raise _unreadable(term)


def decode_verdict(term: Term, *, length_unit: str | None) -> Verdict:
    """The verdict that verdict/10 of judge.pl says. Raises EngineError if it cannot be read."""
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
                tuple(general),
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
                specialises=tuple(map(readable, general)),
                length_unit=length_unit,
            )
    raise _unreadable(term)


def _part(term: Term) -> Part:
    match term:
        case Struct("-", (Atom(role), Atom(name))):
            return Part(role, () if name == UNSEEN else (name,))
        case Struct("-", (Atom(role), tuple(names))):
            return Part(role, tuple(str(n) for n in names))
        case Struct("group", (Atom(role), tuple(names))):
            return Part(role, tuple(str(n) for n in names), is_group=True)
    raise _unreadable(term)


def _size(term: Term) -> Size:
    match term:
        case Struct("size", (Atom(name), measure, int() | float() as value, int() | float() as sd)):
            return Size(name, float(value), float(sd), readable(measure))
    raise _unreadable(term)


def _condition(term: Term) -> Condition:
    match term:
        case Struct("condition", (label, reason, place, text, proof)):
            return Condition(
                readable(label), readable(reason), _proof(proof), readable(place), readable(text)
            )
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
                detail=_detail(test, detail, State(state)),
                children=tuple(map(_proof, kids)),
            )
    raise _unreadable(term)


def _detail(test: Term, detail: Term, state: State) -> Comparison | Note:
    match test, detail:
        case (
            Struct("fading" | "soft", (Struct(_, (measure, *limits)), _))
            | Struct(_, (measure, *limits)),
            Struct(
                "compared" | "uncertain",
                (int() | float() as value, int() | float() as sd, kind, within, margin),
            ),
        ):
            return Comparison(
                readable(measure),
                float(value),
                float(sd),
                readable(kind),
                _within(within),
                _shortfall(margin),
                _measured_limits(limits),
            )
        case _, Struct("unseen", (int() | float() as free, int() | float() as full, nearer)):
            found = _detail(test, nearer, state)
            if isinstance(found, Comparison):
                return replace(found, unseen=(float(free), float(full)))
        case _, Struct("missing", (measure, Atom(cause))):
            text = readable(measure)
            return Note("missing", text, unknown_words(measure, cause), cause_words(cause, measure))
        case _, Struct("fact", (Atom(truth), Atom(cause))):
            words = relation_words(test, truth, cause)
            return Note("fact", truth, words, cause_words(cause, test))
        case (
            Struct("at_least_of" | "at_least_in" | "at_most_of" as bound, (int(count), groups)),
            Struct("counted", (int(holding), int(undecided), member)),
        ):
            deciding = "" if member == Atom("none") else readable(member)
            at_least, is_all = bound != "at_most_of", state is State.FAILS
            grouped = isinstance(groups, tuple) and any(map(_is_several, groups))
            tally = Tally(at_least, count, holding, undecided, deciding, is_all, grouped)
            return Note("counted", tally.brief(), tally.words(), counted=(holding, count))
        case Struct("is_a", (thing, Atom(model))), Struct("judged", (Atom(cause),)):
            words = model_words(readable(thing), model, state)
            return Note("judged", "", words, model_cause(cause))
        case _, Struct(name, (argument,)):
            return Note(name, readable(argument))
        case _, Atom(name):
            return Note(name)
    raise _unreadable(detail)


def _is_several(group: Term) -> bool:
    """Whether several members of a group count as one."""
    return isinstance(group, tuple) and len(group) > 1


def _measured_limits(limits: Sequence[Term]) -> tuple[str, ...]:
    """Limits that were measured themselves, as the rules have them; none if no limit was."""
    found = tuple("" if _is_given(limit) else readable(limit) for limit in limits)
    return found if any(found) else ()


def _is_given(limit: Term) -> bool:
    match limit:
        case Struct("metres"):
            return True
        case Struct("+" | "-" | "*" | "/", args):
            return all(map(_is_given, args))
        case _:
            return isinstance(limit, int | float)


def _shortfall(term: Term) -> Shortfall | None:
    match term:
        case Struct("margin", (Atom(side), int() | float() as distance, int() | float() as sd)):
            return Shortfall(-float(distance), float(sd), Side(side)) if distance < 0 else None
    raise _unreadable(term)


def _within(term: Term) -> Within:
    match term:
        case Struct("fading", (inner, int() | float() as width)):
            return replace(_within(inner), fading=float(width))
        case Struct("soft", (inner, int() | float() as width)):
            return replace(_within(inner), soft=float(width))
        case Struct(sort, limits):
            return Within(sort, tuple(float(x) for x in limits if isinstance(x, int | float)))
    raise _unreadable(term)


def _unreadable(term: Term) -> EngineError:
    return EngineError(f"Prolog's verdict cannot be read: {readable(term)[:80]}")
