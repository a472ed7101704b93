"""The whole proof of a condition: every step that it rests on, with its depth, or as a line."""

from collections.abc import Iterator
from typing import NamedTuple

from facetlog.kb.explaining.proof import MARKS, Proof, State

__all__ = ["Step", "describe_first_reason", "steps", "trace"]

_OPEN = f"{MARKS[State.UNKNOWN]} not known"

# Of a list of steps that all hold, this many are written out: the rest says the same again.
HOLDING_SHOWN = 6


def describe_first_reason(proof: Proof, length_unit: str | None = None) -> str:
    """Return the first reason for the state, in words."""
    if proof.shape:
        return proof.sentence(length_unit)
    if proof.name == "not" and proof.children:
        reason = describe_first_reason(proof.children[0], length_unit)
        return f"{reason}, which should not be" if proof.state is State.FAILS else reason
    if proof.name == "implies":
        then = (
            "" if proof.is_void else f"then {describe_first_reason(proof.children[1], length_unit)}"
        )
        return f"{_describe_condition_of(proof, length_unit)}{then}"
    same = [child for child in proof.children if child.state is proof.state]
    if proof.name == "counted" or not same:
        return proof.sentence(length_unit)
    # Of alternatives that all fail, the one that lacks least is worth saying.
    first = min(same, key=Proof.lacking) if proof.name == "any" else same[0]
    return describe_first_reason(first, length_unit)


class Step(NamedTuple):
    """A step of a proof, in words after its mark, and how many steps it stands below."""

    depth: int
    text: str


def trace(proof: Proof, length_unit: str | None = None) -> Iterator[str]:
    """Return the steps as text, each on a line, indented by its depth."""
    return (f"{'  ' * step.depth}{step.text}" for step in steps(proof, length_unit))


def steps(proof: Proof, length_unit: str | None = None, depth: int = 0) -> Iterator[Step]:
    """Return the tree from top to bottom; steps that only join others are left out.

    Of alternatives that hold, those that do not are left out as well: they are no reason. Nor
    are more than a few of many steps that hold written out, nor anything twice.
    """
    if proof.name == "not" and (proof.children[0].other_shape or not proof.children[0].children):
        yield Step(depth, f"{MARKS[proof.state]} {describe_first_reason(proof, length_unit)}")
        return
    if proof.name == "implies":
        yield from _iter_implication_steps(proof, length_unit, depth)
        return
    if proof.shape:
        yield Step(depth, f"{MARKS[proof.state]} {proof.sentence(length_unit)}")
        return
    joins = _joins(proof)
    if not joins:
        yield Step(depth, f"{MARKS[proof.state]} {proof.sentence(length_unit)}")
    inner = depth if joins else depth + 1
    shown: set[tuple[Step, ...]] = set()
    open_ones: set[Step] = set()
    holding = 0
    for child in _list_shown_children(proof):
        holding += child.state is State.HOLDS
        if child.state is State.HOLDS and holding > HOLDING_SHOWN:
            continue
        found = tuple(steps(child, length_unit, inner))
        if found not in shown:
            shown.add(found)
            # What leaves several alternatives open is said with the first.
            yield from (step for step in found if step not in open_ones)
            open_ones.update(step for step in found if step.text.startswith(_OPEN))
    if holding > HOLDING_SHOWN:
        yield Step(inner, f"+ and {holding - HOLDING_SHOWN} more that hold")


def _iter_implication_steps(proof: Proof, length_unit: str | None, depth: int) -> Iterator[Step]:
    then = proof.children[1]
    head = f"{MARKS[proof.state]} {_describe_condition_of(proof, length_unit)}"
    if proof.is_void:
        yield Step(depth, head)
    elif not then.children:
        yield Step(depth, f"{head}then {then.sentence(length_unit)}")
    else:
        yield Step(depth, f"{head}then:")
        yield from steps(then, length_unit, depth + 1)


def _describe_condition_of(proof: Proof, length_unit: str | None) -> str:
    where = f"where {describe_first_reason(proof.children[0], length_unit)}, "
    return f"{where}nothing is required" if proof.is_void else where


def _joins(proof: Proof) -> bool:
    if proof.name == "any":
        return proof.state is State.HOLDS or len(proof.children) == 1
    if proof.name == "expect":
        return proof.children[0].state is State.HOLDS
    return proof.name in ("short", "if_known", "all")


def _list_shown_children(proof: Proof) -> tuple[Proof, ...]:
    if proof.name == "any":
        if proof.state is State.HOLDS:
            return tuple(c for c in proof.children if c.state is State.HOLDS)
        return tuple(c for child in proof.children for c in _split_alternatives(child))
    if proof.name == "counted":
        # Those that hold are too many, or enough; else the best of the others are what lacks.
        others = tuple(c for c in proof.children if c.state is not State.HOLDS)
        wanting = others[:HOLDING_SHOWN] if proof.state is State.UNKNOWN else ()
        return tuple(c for c in proof.children if c.state is State.HOLDS) + wanting
    return proof.children


def _split_alternatives(proof: Proof) -> tuple[Proof, ...]:
    """Return an alternative that itself lists alternatives, taken apart."""
    if proof.state is State.HOLDS or not proof.children:
        return (proof,)
    if proof.name == "short":
        return _split_alternatives(proof.children[0])
    if proof.name == "any":
        return tuple(c for child in proof.children for c in _split_alternatives(child))
    return (proof,)
