"""Prolog's verdicts, verdict/10 of judge.pl, as Verdict."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.explaining.near import AskedMember
from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, Side, State, Within
from facetlog.kb.explaining.records import decode_record, unreadable
from facetlog.kb.explaining.verdict import Part, Verdict
from facetlog.kb.explaining.wording import (
    NOUNS,
    UNSEEN,
    add_article,
    describe_cause,
    describe_relation,
    describe_unknown,
    readable,
)
from facetlog.plurals import many

__all__ = ["decode_explained", "decode_verdict", "decode_verdicts"]


def decode_verdicts(term: Term, *, length_unit: str | None) -> tuple[Verdict, ...]:
    """Return the verdicts of a list, in its order. Raise EngineError if it cannot be read."""
    if isinstance(term, tuple):
        return tuple(decode_verdict(item, length_unit=length_unit) for item in term)
    raise unreadable(term)


def decode_verdict(term: Term, *, length_unit: str | None) -> Verdict:
    """Return the verdict of verdict/10 of judge.pl. Raise EngineError if it cannot be read."""
    verdict: Verdict = decode_record(term, Verdict, {Part: _part, Proof: _decode_proof})
    singles = {part.role for part in verdict.parts if not part.is_group}
    conditions = tuple(
        replace(line, proof=_describe_left_part(line.proof, line.label, verdict.thing))
        if line.label in singles
        else line
        for line in verdict.conditions
    )
    return replace(verdict, conditions=conditions, length_unit=length_unit)


def _describe_left_part(proof: Proof, role: str, thing: str) -> Proof:
    """Return the proof of a single part's line, where what is counted is all that there is for it
    and for the parts before it."""
    step = proof.detail
    if proof.name == "all":
        children = (_describe_left_part(child, role, thing) for child in proof.children)
        return replace(proof, children=tuple(children))
    if not isinstance(step, Note) or step.counted is None or not proof.test.startswith("at_least"):
        return proof
    found, wanted = step.counted
    kind = next((NOUNS[m[1]] for m in re.finditer(r"\b([pohf])\d", proof.test)), "")
    if not kind:
        return proof
    there = many(found, kind)
    words = f"{thing} has {there} for {wanted} parts"
    if proof.state is not State.HOLDS:
        so_far = " so far" if proof.state is State.UNKNOWN else ""
        words = f"nothing is left for {role}: {thing} has but {there}{so_far} for {wanted} parts"
    return replace(proof, detail=replace(step, words=words))


def decode_explained(term: Term, *, length_unit: str | None) -> Verdict:
    """Return the verdict of explained/2 of near_miss.pl, with what was asked of members of sets."""
    match term:
        case Struct("explained", (verdict, asked)):
            members = decode_record(asked, tuple[AskedMember, ...], {Proof: _decode_proof})
            return replace(decode_verdict(verdict, length_unit=length_unit), asked=members)
    raise unreadable(term)


def _part(term: Term) -> Part:
    match term:
        case Struct("-", (Atom(role), Atom(name))):
            return Part(role, () if name == UNSEEN else (name,))
        case Struct("-", (Atom(role), tuple(names))):
            return Part(role, tuple(str(n) for n in names))
        case Struct("group", (Atom(role), tuple(names))):
            return Part(role, tuple(str(n) for n in names), is_group=True)
    raise unreadable(term)


def _decode_proof(term: Term) -> Proof:
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
                detail=_decode_detail(test, detail, State(state)),
                children=tuple(map(_decode_proof, kids)),
            )
    raise unreadable(term)


def _decode_detail(test: Term, detail: Term, state: State) -> Comparison | Note:
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
                _decode_within(within),
                _decode_shortfall(margin),
                _list_measured_limits(limits),
            )
        case _, Struct("unseen", (int() | float() as free, int() | float() as full, nearer)):
            found = _decode_detail(test, nearer, state)
            if isinstance(found, Comparison):
                return replace(found, unseen=(float(free), float(full)))
        case _, Struct("missing", (measure, Atom(cause))):
            text = readable(measure)
            return Note(
                "missing", text, describe_unknown(measure, cause), describe_cause(cause, measure)
            )
        case _, Struct("fact", (Atom(truth), Atom(cause))):
            words = describe_relation(test, truth, cause)
            return Note("fact", truth, words, describe_cause(cause, test))
        case (
            Struct("at_least_of" | "at_least_in" | "at_most_of" as bound, (int(count), groups)),
            Struct("counted", (int(holding), int(undecided), member)),
        ):
            deciding = "" if member == Atom("none") else readable(member)
            at_least, is_all = bound != "at_most_of", state is State.FAILS
            grouped = isinstance(groups, tuple) and any(map(_is_several, groups))
            tally = _Tally(at_least, count, holding, undecided, deciding, is_all, grouped)
            return Note("counted", tally.brief(), tally.words(), counted=(holding, count))
        case Struct("is_a", (thing, Atom(model))), Struct("judged", (Atom(cause),)):
            words = _describe_model_verdict(readable(thing), model, state)
            return Note("judged", "", words, _MODEL_CAUSES.get(cause, ""))
        case _, Struct(name, (argument,)):
            return Note(name, readable(argument))
        case _, Atom(name):
            return Note(name)
    raise unreadable(detail)


def _is_several(group: Term) -> bool:
    """Return whether several members of a group count as one."""
    return isinstance(group, tuple) and len(group) > 1


def _list_measured_limits(limits: Sequence[Term]) -> tuple[str, ...]:
    """Return limits that were measured themselves, as the rules have them; none if no limit was."""
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


def _decode_shortfall(term: Term) -> Shortfall | None:
    match term:
        case Struct("margin", (Atom(side), int() | float() as distance, int() | float() as sd)):
            return Shortfall(-float(distance), float(sd), Side(side)) if distance < 0 else None
    raise unreadable(term)


def _decode_within(term: Term) -> Within:
    match term:
        case Struct("fading", (inner, int() | float() as width)):
            return replace(_decode_within(inner), fading=float(width))
        case Struct("soft", (inner, int() | float() as width)):
            return replace(_decode_within(inner), soft=float(width))
        case Struct(sort, limits):
            return Within(sort, tuple(float(x) for x in limits if isinstance(x, int | float)))
    raise unreadable(term)


_MODEL_CAUSES = {
    "unseen": "the thing was not seen",
    "unstated": "the scene has no such thing",
    "cycle": "that model is itself being judged for this thing",
}


@dataclass(frozen=True, slots=True)
class _Tally:
    """How many groups are wanted (at least or at most `count`), how many hold and how many may.

    `deciding` is the member of a group that decides, or empty; `is_all` says that there are no more
    groups than these, `grouped` that some have several members, which do not stand apart.
    """

    at_least: bool
    count: int
    holding: int
    undecided: int
    deciding: str
    is_all: bool = False
    grouped: bool = False

    def brief(self) -> str:
        """Return the numbers alone.

        >>> _Tally(True, 3, 4, 0, "f7").brief()
        '4 hold, 0 may, f7 decides'
        """
        decides = f", {self.deciding} decides" if self.deciding else ""
        return f"{self.holding} hold, {self.undecided} may{decides}"

    def words(self) -> str:
        """Return the numbers in a sentence.

        >>> _Tally(True, 3, 2, 1, "f7").words()
        '2 were found, at least 3 are wanted, but there may be more; f7 comes next'
        >>> _Tally(False, 1, 2, 0, "f9").words()
        '2 were found, at most 1 is wanted; f9 is one too many'
        >>> _Tally(True, 3, 4, 0, "f7", grouped=True).words()
        '4 that stand apart were found, at least 3 are wanted; f7 decides'
        """
        bound = "at least" if self.at_least else "at most"
        more = f", {self.undecided} more may be" if self._is_open_above() else ""
        wanted = f"{bound} {self.count} {'is' if self.count == 1 else 'are'} wanted"
        apart = " that stand apart" if self.grouped else ""
        found = {0: "none was", 1: "1 was"}.get(self.holding, f"{self.holding}{apart} were")
        return f"{found} found{more}, {wanted}{self._end()}"

    def _is_open_above(self) -> bool:
        some = self.holding <= self.count < self.holding + self.undecided
        return not self.at_least and some

    def _end(self) -> str:
        if self.at_least and self.holding < self.count:
            if self.is_all:
                return ""
            following = f"; {self.deciding} comes next" if self.deciding else ""
            return f", but there may be more{following}"
        if not self.at_least and self.holding > self.count:
            return f"; {self.deciding} is one too many"
        return f"; {self.deciding} decides" if self.deciding else ""


def _describe_model_verdict(thing: str, model: str, state: State) -> str:
    """Return the verdict of another model as a clause.

    >>> _describe_model_verdict("t2", "table", State.FAILS)
    't2 is no table'
    """
    one = add_article(model)
    match state:
        case State.HOLDS:
            return f"{thing} is {one}"
        case State.FAILS:
            return f"{thing} is no {model}"
        case State.UNKNOWN:
            return f"it is open whether {thing} is {one}"
