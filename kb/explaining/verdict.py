"""Verdicts on a scene: verdicts, each with parts, sizes, angles and proof."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from facetlog.kb.confidence import Confidence
from facetlog.kb.explaining.best_first import best_first
from facetlog.kb.explaining.near import AskedMember, NearMember, list_nearest
from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, State
from facetlog.kb.explaining.reasons import reason
from facetlog.kb.explaining.sight import OtherThing
from facetlog.kb.explaining.unseen import Unseen
from facetlog.kb.explaining.verdict_text import (
    format_holding,
    format_summary_line,
    iter_miss_lines,
    iter_verdict_lines,
    summary,
)
from facetlog.kb.explaining.wording import CAUSES, LOOKING_SETTLES_NOT

__all__ = ["Condition", "Part", "Recognition", "Size", "Verdict"]

SCHEMA = "facetlog-verdicts/2"
_NAMES = re.compile(r"[^\s(),]+")


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a model and the faces that play it: one, several, or none if it was not seen.

    A group is whatever belongs to a set, which may be nothing.
    """

    role: str
    faces: tuple[str, ...]
    is_group: bool = False

    def __str__(self) -> str:
        return f"{self.role} = {', '.join(self.faces) or ('none' if self.is_group else 'unseen')}"


@dataclass(frozen=True, slots=True)
class Size:
    """A length of the thing with its standard deviation, metres or units of the scene.

    `measure` is what was measured, as 'elevation(f1)'.
    """

    name: str
    value: float
    sd: float
    measure: str = ""


@dataclass(frozen=True, slots=True)
class Condition:
    """One line of a model: its label, the author's reason, and the proof of it.

    `text` is the line as the author wrote it and `place` where it stands ('table.model:9'); both
    are empty where the file does not say. `near` is what comes nearest to its sets, the nearest
    first, where somebody asked why it does not hold.
    """

    label: str
    reason: str
    proof: Proof
    place: str = ""
    text: str = ""
    near: tuple[NearMember, ...] = field(default=(), compare=False)

    @property
    def said(self) -> str:
        """The condition in words: the reason, or the line itself where there is none."""
        return self.reason or self.text or self.label

    @property
    def origin(self) -> str:
        """The place and the line, in brackets with a blank before; empty if neither is known."""
        line = "" if self.said == self.text else self.text
        known = ": ".join(filter(None, (self.place, line)))
        return f" [{known}]" if known else ""

    @property
    def may_be_settled(self) -> bool:
        """Whether it is open, and another look might settle it."""
        if self.proof.state is not State.UNKNOWN:
            return False
        found = reason(self.proof)
        step = None if found is None else found.step.detail
        return not (isinstance(step, Note) and step.cause in LOOKING_SETTLES_NOT)

    @property
    def misses_part(self) -> bool:
        """Whether it fails because too few were found of what it counts."""
        found = reason(self.proof)
        step = None if found is None else found.step
        if step is None or self.proof.state is not State.FAILS:
            return False
        counted = step.detail.counted if isinstance(step.detail, Note) else None
        is_empty = step.name == "any" and not step.children
        return is_empty or (counted is not None and counted[0] < counted[1])

    @property
    def nearest(self) -> tuple[NearMember, ...]:
        """Near misses of its sets, if it is one of these that decides."""
        found = reason(self.proof)
        return self.near if found is not None and found.step.name in ("counted", "any") else ()

    def to_json(
        self, length_unit: str | None, *, full: bool = False, measured: bool = True
    ) -> dict[str, Any]:
        """Return the condition and the reason for its state as plain data, with the numbers it
        rests on if `measured`; `full` the whole proof too."""
        written = {"place": self.place, "text": self.text if full else ""}
        found = reason(self.proof)
        return {
            "label": self.label,
            "reason": self.reason,
            **{key: value for key, value in written.items() if value},
            "state": self.proof.state.value,
            "degree": [self.proof.low, self.proof.high],
            "because": None if found is None else found.to_json(length_unit, measured=measured),
            **({"nearest": nearest} if (nearest := self._nearest_to_json(length_unit)) else {}),
            **({"proof": self.proof.to_json()} if full else {}),
        }

    def _nearest_to_json(self, length_unit: str | None) -> list[dict[str, Any]]:
        return [near.to_json(length_unit) for near in list_nearest(self.nearest)]


@dataclass(frozen=True, slots=True, repr=False)
class Verdict:
    """Verdict of one model on one thing.

    `degree` and `degree_at_most` bound the probability that the true values lie within the model's
    tolerances; they are equal where all was measured.
    """

    model: str
    """The model's name."""
    thing: str
    """The thing's name, as t1; empty of no thing."""
    state: State
    """State by the measured values: holds, fails or unknown."""
    degree: float
    """The probability that it holds, from this scene alone; at least that."""
    degree_at_most: float
    """Upper bound of that probability, whatever was not seen."""
    parts: tuple[Part, ...]
    """The parts of the model and the faces that play them."""
    sizes: tuple[Size, ...]
    """Lengths of the thing with their standard deviations."""
    conditions: tuple[Condition, ...]
    """The lines of the model, each with its proof."""
    also: int = 0
    """How many other ways to choose the parts hold as well."""
    specialises: tuple[str, ...] = ()
    """The models of which this one is a special case, the nearest first."""
    length_unit: str | None = None
    """'m', or None where the scale is not known."""
    rather_than: tuple[str, ...] = field(default=(), compare=False)
    """The models whose names stand after this one's where both hold (best_first.py)."""
    own: bool = field(default=False, compare=False)
    """Whether the model is from a user's file, not a built-in one."""
    confidence: Confidence = field(default=Confidence(), compare=False)
    """How often the model was right of labelled things that were measured likewise, where it gave
    such a verdict (calibration.py); without a value of a verdict on no thing, of parts that were
    given, and where no cases were counted."""
    assumed: float = field(default=0.0, compare=False)
    """Share of the thing's space that was not seen and counts as full, 0..1, if asked for."""
    unseen: tuple[Unseen, ...] = field(default=(), compare=False)
    """Why parts may have been missed and from where they could be seen, if someone asked why it
    does not hold."""
    others: tuple[OtherThing, ...] = field(default=(), compare=False)
    """Other things near it, if someone asked why it does not hold and it lacks a part."""
    asked: tuple[AskedMember, ...] = field(default=(), compare=False)
    """What was asked of the members of sets."""

    def __repr__(self) -> str:
        # With its proof it would fill pages.
        return f"<Verdict: {self.summary}>"

    @property
    def sure(self) -> float:
        """How sure it is that it holds: the confidence, or the degree where there is none."""
        value = self.confidence.value
        return self.degree if value is None else value

    @property
    def angles(self) -> tuple[Comparison, ...]:
        """The angles that the proof rests on, degrees, each once whatever it is compared with."""
        found = (c for line in self.conditions for c in line.proof.comparisons())
        first: dict[tuple[str, ...], Comparison] = {}
        for angle in (c for c in found if c.kind == "deg"):
            # of two faces it is the same in either order
            first.setdefault(tuple(sorted(_NAMES.findall(angle.measure))), angle)
        return tuple(first.values())

    @property
    def is_unseen(self) -> bool:
        """Whether it does not hold while a condition is open that another look might settle."""
        if self.state is State.HOLDS:
            return False
        of_none = self.state is State.UNKNOWN and not self.conditions
        return of_none or any(c.may_be_settled for c in self.conditions)

    @property
    def lacking(self) -> frozenset[str]:
        """Statements about the scene, "up" and "scale", that would settle open conditions."""
        found = (reason(c.proof) for c in self.list_conditions_in_state(State.UNKNOWN))
        notes = (step.step.detail for step in found if step is not None)
        causes = {note.cause for note in notes if isinstance(note, Note)}
        return frozenset(what for what in ("up", "scale") if CAUSES[what] in causes)

    @property
    def lacks_pieces(self) -> bool:
        """Whether it does not hold and too few of its pieces were found."""
        has_pieces = any(re.match(r"p\d", face) for part in self.parts for face in part.faces)
        return has_pieces and any(
            line.misses_part for line in self.list_conditions_in_state(State.FAILS)
        )

    @property
    def unseen_roles(self) -> tuple[str, ...]:
        """The parts that were not seen; a group of nothing is none."""
        return tuple(part.role for part in self.parts if not part.faces and not part.is_group)

    def list_conditions_in_state(self, state: State) -> tuple[Condition, ...]:
        """Return the conditions of this state, in the order of the file."""
        return tuple(c for c in self.conditions if c.proof.state is state)

    @property
    def summary(self) -> str:
        """One line: what it is, or why it is not, or what is missing."""
        return summary(self)

    def lines(self, *, full: bool = False) -> Iterator[str]:
        """Return the verdict and why, a line for each condition; `full` with the whole proof of
        each."""
        return iter_verdict_lines(self, full=full)

    def iter_miss_lines(self) -> Iterator[str]:
        """Return why this assignment does not hold, first what the least change would mend."""
        return iter_miss_lines(self)

    def to_json(self, *, full: bool = False) -> dict[str, Any]:
        """Return the verdict as plain data, with `full` the whole proof of each condition.

        Else a verdict that fails has numbers only where it does: no sizes or angles of what is no
        such thing, and of conditions that hold the reason in words.
        """
        brief = self.state is State.FAILS and not full
        sizes, angles = ((), ()) if brief else (self.sizes, self.angles)
        return {
            "model": self.model,
            "thing": self.thing,
            "state": self.state.value,
            "degree": self.degree,
            "degree_at_most": self.degree_at_most,
            "specialises": list(self.specialises),
            **self.confidence.to_json(),
            "summary": self.summary,
            "parts": {part.role: list(part.faces) for part in self.parts},
            "sizes": {s.name: {"value": s.value, "sd": s.sd, "measure": s.measure} for s in sizes},
            "length_unit": self.length_unit,
            "angles": [{"of": a.measure, "deg": a.value, "sd": a.sd} for a in angles],
            "also": self.also,
            "shortfalls": list(self._iter_least_shortfalls()),
            "conditions": [
                c.to_json(
                    self.length_unit,
                    full=full,
                    measured=not brief or c.proof.state is not State.HOLDS,
                )
                for c in self.conditions
            ],
            **({"asked": asked} if (asked := self._asked_to_json()) else {}),
            **({"assumed": self.assumed} if self.assumed else {}),
            **({"unseen": [found.to_json() for found in self.unseen]} if self.unseen else {}),
        }

    def _asked_to_json(self) -> list[dict[str, Any]]:
        return [member.to_json(self.length_unit) for member in self.asked]

    def _iter_least_shortfalls(self) -> Iterator[dict[str, Any]]:
        """Yield the shortfalls of each condition: the least of each measure, and each once."""
        given: set[tuple[str, str, float]] = set()
        for condition in self.conditions:
            least: dict[tuple[str, str], tuple[Comparison, Shortfall]] = {}
            for miss in condition.proof.shortfalls():
                short = miss.shortfall
                if short is None:
                    continue
                key = miss.measure, short.side
                if key not in least or short.amount < least[key][1].amount:
                    least[key] = miss, short
            for (of, side), (miss, short) in least.items():
                if (of, side, short.amount) not in given:
                    given.add((of, side, short.amount))
                    yield {
                        "label": condition.label,
                        "of": of,
                        "kind": miss.kind,
                        **short.to_json(),
                    }


@dataclass(frozen=True, slots=True, repr=False)
class Recognition:
    """All verdicts on a scene: one for each thing and model."""

    scene: str
    verdicts: tuple[Verdict, ...]

    @property
    def best(self) -> tuple[Verdict, ...]:
        """Verdicts that hold, the answer first (best_first.py)."""
        return tuple(best_first(self.verdicts))

    @property
    def models(self) -> frozenset[str]:
        """Names of the models that hold somewhere in the scene."""
        return frozenset(v.model for v in self.best)

    def __bool__(self) -> bool:
        return bool(self.best)

    def __repr__(self) -> str:
        found = format_holding(verdict.summary for verdict in self.best)
        return f"<Recognition of {self.scene}: {found}>"

    def lines(self, *, full: bool = False) -> Iterator[str]:
        """Return what holds and why, then a line for each verdict that does not hold, those of
        users' own models first; `full` with the whole proofs."""
        for verdict in self.best:
            yield from verdict.lines(full=full)
        for verdict in sorted(self.verdicts, key=lambda verdict: not verdict.own):
            if verdict.state is not State.HOLDS:
                yield verdict.summary if full else format_summary_line(verdict)
        if not self.verdicts:
            yield "nothing was found that a model could be asked about"

    def to_json(self, *, full: bool = False) -> dict[str, Any]:
        """Return the recognition as plain data, with the schema's name; `full` with the whole
        proofs."""
        return {
            "schema": SCHEMA,
            "scene": self.scene,
            "recognised": [{"thing": v.thing, "model": v.model} for v in self.best],
            "verdicts": [v.to_json(full=full) for v in self.verdicts],
        }
