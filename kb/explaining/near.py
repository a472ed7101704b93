"""Near misses of a set that has too few or too many members, and whether one is a member."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from facetlog.kb.explaining.proof import NOISE_SDS, Comparison, Proof, State
from facetlog.kb.explaining.reasons import reason
from facetlog.kb.explaining.wording import add_article, listed, runs

__all__ = ["AskedMember", "NearMember", "format_nearest", "list_nearest"]

# Misses that differ by no more than this share of the greater one are mended by the same change.
ABOUT = 0.1


@dataclass(frozen=True, slots=True)
class NearMember:
    """Near miss of a set with too `few` members, or one of too `many`, and why."""

    functor: ClassVar[str] = "near"
    sort: str
    name: str
    proof: Proof
    within: "tuple[NearMember, ...]" = ()

    def texts(self, length_unit: str | None) -> tuple[str, ...]:
        """Return why it is a member or not, from the longest text to the shortest."""
        if self.within:
            return format_nearest(self.within, length_unit)
        return _list_texts(self.name, self.proof, length_unit)

    def is_like(self, other: "NearMember") -> bool:
        """Return whether both miss the same condition by about the same."""
        steps = [(near.name, _find_step(near.proof)) for near in (self, other)]
        one, two = (
            (step.other_shape, re.sub(rf"\b{re.escape(name)}\b", "", step.test))
            for name, step in steps
        )
        if one != two:
            return False
        gaps = [(_measure_gap(c), c.sd) for _, step in steps if (c := step.comparison) is not None]
        if len(gaps) < len(steps):
            return True
        noise = NOISE_SDS * max(sd for _, sd in gaps)
        least, most = sorted(gap for gap, _ in gaps)
        return most - least <= max(ABOUT * most, noise)

    def to_json(self, length_unit: str | None) -> dict[str, Any]:
        """Return the name and the reason as plain data."""
        found = reason(self.proof)
        because = None if found is None else found.to_json(length_unit)
        within = [near.to_json(length_unit) for near in list_nearest(self.within)]
        return {
            "name": self.name,
            "state": self.proof.state.value,
            "because": because,
            **({"nearest": within} if within else {}),
        }


def _measure_gap(comparison: Comparison) -> float:
    """Return how far a value is from the limit that it misses, or from the nearest one."""
    if comparison.shortfall is not None:
        return comparison.shortfall.amount
    return min((abs(edge - comparison.value) for edge in comparison.within.edges), default=0.0)


def _find_step(proof: Proof) -> Proof:
    found = reason(proof)
    return proof if found is None else found.step


def _list_texts(name: str, proof: Proof, length_unit: str | None) -> tuple[str, ...]:
    found = reason(proof)
    texts = ("it does not apply to it",) if found is None else found.texts(length_unit)
    return tuple(text.replace(f"({name})", "") for text in texts)


def list_nearest(near: Sequence[NearMember]) -> tuple[NearMember, ...]:
    """Return the nearest and those that miss like it; of members that are too many the first."""
    alike = (other for other in near if other.sort == "few" and other.is_like(near[0]))
    return tuple(alike) or tuple(near[:1])


def format_nearest(near: Sequence[NearMember], length_unit: str | None) -> tuple[str, ...]:
    """Return for example 'nearest p8: curved = 42 %, needs at least 50 %; p9–p11 likewise'.

    From the longest text to the shortest; none where nothing comes near.
    """
    if not near:
        return ()
    first, *others = list_nearest(near)
    alike = f"; {runs([other.name for other in others], ', ')} likewise" if others else ""
    head = "nearest" if first.sort == "few" else "the first to give way would be"
    texts = first.texts(length_unit)
    return tuple(
        f"{head}{':' if text.startswith(f'{first.name} ') else f' {first.name}:'} {text}{alike}"
        for text in texts
    )


@dataclass(frozen=True, slots=True)
class AskedMember:
    """Whether something belongs to a set: `played` are other parts that it is, where it is none."""

    functor: ClassVar[str] = "asked"
    role: str
    name: str
    played: tuple[str, ...]
    proof: Proof

    @property
    def state(self) -> State:
        """Whether it is a member."""
        return State.FAILS if self.played else self.proof.state

    def texts(self, length_unit: str | None) -> tuple[str, ...]:
        """Return whether it is a member and why, from the longest text to the shortest."""
        said = {
            State.HOLDS: f"{self.name} is {add_article(self.role)}",
            State.FAILS: f"{self.name} is no {self.role}",
            State.UNKNOWN: f"{self.name} may be {add_article(self.role)}",
        }[self.state]
        if self.played:
            return (f"{said}: it is the {listed(self.played)}",)
        if self.state is State.HOLDS:
            return (said,)
        shape = re.compile(rf"^{re.escape(self.name)} is no \w+: (?=it is)")
        whys = _list_texts(self.name, self.proof, length_unit)
        return *(f"{said}: {shape.sub('', why)}" for why in whys), said

    def to_json(self, length_unit: str | None) -> dict[str, Any]:
        """Return the answer as plain data, with the whole proof."""
        return {
            "role": self.role,
            "name": self.name,
            "state": self.state.value,
            "played": list(self.played),
            "text": self.texts(length_unit)[0],
            "proof": self.proof.to_json(),
        }
