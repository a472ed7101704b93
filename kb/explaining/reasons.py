"""Why a condition holds or not in one step: what a reader needs of a proof, and no more.

Of steps that are all needed the one nearest to its limit (proof.py) stands for the others: of
what holds it would be the first to give way, of what does not the first to be mended. Of
alternatives one is enough.
"""

import re
from dataclasses import dataclass
from typing import Any

from facetlog.kb.explaining.proof import Comparison, Nearness, Proof, State
from facetlog.kb.explaining.wording import HOW_SEEN

__all__ = ["Reason", "reason"]


@dataclass(frozen=True, slots=True)
class Reason:
    """The step of a proof that decides, of which `more` are needed beside it.

    `is_wanted` unless a `not` stands before it; `holds` is whether the condition does.
    """

    step: Proof
    holds: bool
    is_wanted: bool = True
    more: int = 0

    def texts(self, length_unit: str | None) -> tuple[str, ...]:
        """Return the reason in words, from the longest to the shortest; how many more there are
        goes last."""
        said = self.step.sentences(length_unit, is_wanted=self.is_wanted)
        end = ""
        if self.holds and self.is_wanted and self.step.state is State.FAILS:
            end = ", not required"
        elif not self.holds and not self.is_wanted and self.step.state is State.HOLDS:
            end = ", which should not be"
        more = (f" (+ {self.more} more)", "") if self.more else ("",)
        return (*(f"{text}{end}{more[0]}" for text in said), f"{said[-1]}{end}")

    def to_json(self, length_unit: str | None, *, measured: bool = True) -> dict[str, Any]:
        """Return the reason as plain data, with its numbers if `measured`; lengths as they are
        measured, whatever the text has them in."""
        comparison = self.step.comparison
        numbers = comparison.to_json() if measured and comparison is not None else {}
        text = self.texts(length_unit)[0]
        return {"text": text, "state": self.step.state.value, "more": self.more, **numbers}


def reason(proof: Proof) -> Reason | None:
    """Return the reason for the state of a condition.

    None if it holds only because it does not apply to such a thing: a guard exempts it, there is
    nothing to choose from, or what it needs is not known.
    """
    holds = proof.state is State.HOLDS
    steps = _steps(proof, holds=holds, is_wanted=True, beside=False)
    if not steps:
        return None if holds else Reason(proof, holds)
    different: dict[object, _Step] = {}
    for step in steps:
        different.setdefault(_build_meaning_key(step.proof), step)
    first = min(different.values(), key=lambda step: _measure_step_nearness(step.proof))
    return Reason(first.proof, holds, first.is_wanted, len(different) - 1)


@dataclass(frozen=True, slots=True)
class _Step:
    proof: Proof
    is_wanted: bool


def _steps(proof: Proof, *, holds: bool, is_wanted: bool, beside: bool) -> tuple[_Step, ...]:
    """Return the steps that together suffice for the state of a proof; none where it does not
    apply.

    `holds` is whether the condition that it belongs to does, `beside` whether the proof is an
    alternative to others: what was seen of a thing is then only said of things seen so.
    """

    def of(child: Proof, *, beside: bool = beside) -> tuple[_Step, ...]:
        return _steps(child, holds=holds, is_wanted=is_wanted, beside=beside)

    same = tuple(child for child in proof.children if child.state is proof.state)
    if proof.shape and proof.state is State.HOLDS and not is_wanted:
        return (_Step(proof, is_wanted),)
    match proof.name:
        case "short" if proof.other_shape:
            return (_Step(proof, is_wanted),)
        case "all" | "short" if proof.state is State.HOLDS:
            # The text forbids such a piece: its shape tells which one is meant, and is no reason.
            telling = () if is_wanted else tuple(child for child in same if not child.shape)
            return tuple(step for child in telling or same for step in of(child))
        case "all" | "short" if same:
            # One that fails is enough beneath a `not`; else all have to be mended.
            found = tuple(map(of, same))
            return (
                min(found, key=len) if holds else tuple(step for steps in found for step in steps)
            )
        case "any" if proof.state is State.HOLDS:
            found = () if any(map(_is_exempt, same)) else tuple(of(c, beside=True) for c in same)
            return min(filter(None, found), key=len, default=())
        case "any" if holds:
            # Beneath a `not`: all of them have to fail.
            return tuple(step for child in same for step in of(child, beside=True))
        case "any" if same:
            return of(min(same, key=Proof.lacking))
        case "not":
            (inside,) = proof.children
            return _steps(inside, holds=holds, is_wanted=not is_wanted, beside=beside)
        case "if_known" | "not_applied":
            return () if _is_exempt(proof) else of(proof.children[0])
        case "expect":
            (inside,) = proof.children
            if inside.state is State.UNKNOWN:
                return ()
            is_met = inside.state is State.HOLDS
            return _steps(inside, holds=is_met, is_wanted=is_wanted, beside=beside)
        case "implies":
            where, then = proof.children
            if proof.is_void:
                return ()
            return of(then) if then.state is proof.state else of(where)
    if holds and beside and _is_about_seeing(proof):
        return ()
    return (_Step(proof, is_wanted),)


def _is_exempt(proof: Proof) -> bool:
    """Return whether a proof holds because what it says does not apply to such a thing."""
    if proof.state is not State.HOLDS:
        return False
    match proof.name:
        case "not":
            (inside,) = proof.children
            nothing = inside.name == "any" and not inside.children
            return nothing or _is_about_seeing(inside)
        case "if_known":
            return proof.children[0].state is State.UNKNOWN
        case "not_applied":
            return True
        case "implies":
            return proof.is_void
        case "all" | "short":
            return all(map(_is_exempt, proof.children))
    return False


def _is_about_seeing(proof: Proof) -> bool:
    return proof.name == "fact" and proof.test.partition("(")[0] in HOW_SEEN


def _build_meaning_key(proof: Proof) -> object:
    """Return a key that is equal for steps that say the same: of two faces in either order."""
    what = proof.detail.measure if isinstance(proof.detail, Comparison) else proof.test
    words = tuple(sorted(re.findall(r"[\w.]+", what)))
    if isinstance(proof.detail, Comparison):
        return words, proof.detail.within
    return words, proof.state


def _measure_step_nearness(proof: Proof) -> tuple[bool, Nearness]:
    """Return the key that sorts steps nearest to their limits first, those without one last."""
    if proof.comparison is not None:
        return False, proof.comparison.nearness
    return True, (True, 0.0)
