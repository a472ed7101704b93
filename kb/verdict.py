"""What the models say of a scene: verdicts, each with parts, sizes, angles and proof."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from facetlog.kb.amounts import amount
from facetlog.kb.proof import MARKS, Comparison, Proof, State
from facetlog.kb.wording import listed, with_article

__all__ = ["Condition", "Part", "Recognition", "Size", "Verdict"]

SCHEMA = "facetlog-verdicts/1"


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
    """A length of the thing with its standard deviation, metres or units of the scene."""

    name: str
    value: float
    sd: float


@dataclass(frozen=True, slots=True)
class Condition:
    """One line of a model: its label, the author's reason, and the proof of it.

    `text` is the line as the author wrote it and `place` where it stands ('table.model:9'); both
    are empty where the file does not say.
    """

    label: str
    reason: str
    proof: Proof
    place: str = ""
    text: str = ""

    @property
    def said(self) -> str:
        """What the condition asks, in words: the reason, or the line itself where there is none."""
        return self.reason or self.text or self.label

    @property
    def origin(self) -> str:
        """The place and the line, in brackets with a blank before; empty if neither is known."""
        line = "" if self.said == self.text else self.text
        known = ": ".join(filter(None, (self.place, line)))
        return f" [{known}]" if known else ""

    def to_json(self) -> dict[str, Any]:
        """The condition and its proof as plain data."""
        written = {"place": self.place, "text": self.text}
        return {
            "label": self.label,
            "reason": self.reason,
            **{key: value for key, value in written.items() if value},
            "because": self.proof.to_json(),
        }


@dataclass(frozen=True, slots=True)
class Verdict:
    """What one model says of one thing.

    `state` is what the measured values say. `degree` and `degree_at_most` bound the probability
    that the true values lie within the model's tolerances; they are equal where all was measured.
    `also` counts the other ways to choose the parts that hold as well. `length_unit` is 'm', or
    None where the scale is not known. `specialises` names the models of which this one is a special
    case, the nearest first. `probability` is how often the model was right on rendered things where
    it gave this degree; None where its text was never calibrated, and of scenes that are known from
    their surface: the rendered things were found in pictures.
    """

    model: str
    thing: str
    state: State
    degree: float
    degree_at_most: float
    parts: tuple[Part, ...]
    sizes: tuple[Size, ...]
    conditions: tuple[Condition, ...]
    also: int = 0
    length_unit: str | None = None
    specialises: tuple[str, ...] = ()
    probability: float | None = field(default=None, compare=False)

    @property
    def angles(self) -> tuple[Comparison, ...]:
        """The angles that the proof rests on, degrees, each once."""
        found = (c for line in self.conditions for c in line.proof.comparisons())
        return tuple(dict.fromkeys(c for c in found if c.kind == "deg"))

    def conditions_that(self, state: State) -> tuple[Condition, ...]:
        """The conditions of this state, in the order of the file."""
        return tuple(c for c in self.conditions if c.proof.state is state)

    @property
    def summary(self) -> str:
        """One line: what it is, or why it is not, or what is missing."""
        one = with_article(self.model)
        if not self.thing:
            return f"nothing was found that could be {one}"
        match self.state:
            case State.HOLDS:
                which = listed(tuple(map(with_article, self.specialises)))
                general = f", which is {which}" if self.specialises else ""
                return f"{self.thing} is {one}{general} ({self.degree:.0%})"
            case State.FAILS:
                holding = len(self.conditions_that(State.HOLDS))
                return (
                    f"{self.thing} is no {self.model}: {self._first_reason()} "
                    f"({holding} of {len(self.conditions)} conditions hold)"
                )
            case State.UNKNOWN:
                return f"{self.thing}: {self.model} is unknown: {self._first_reason()}"

    def _first_reason(self) -> str:
        parts = [part for part in self.parts if not part.is_group]
        unseen = [part.role for part in parts if not part.faces]
        if not parts:
            return "no face of it was measured"
        if self.state is State.UNKNOWN and len(unseen) == len(parts):
            return f"no face was measured that could be its {' or '.join(unseen)}"
        if self.state is State.UNKNOWN and unseen:
            seen = len(parts) - len(unseen)
            return f"only {seen} of the {len(parts)} faces that it needs were measured"
        line = next(c for c in self.conditions if c.proof.state is self.state)
        leaf = line.proof.because(self.length_unit)
        open_or_not = "it is open whether" if self.state is State.UNKNOWN else "it is not so that"
        return f"{open_or_not} {line.said}: {leaf}"

    def lines(self) -> Iterator[str]:
        """The verdict and its proof as text."""
        yield self.summary
        if self.parts:
            yield f"  parts: {'; '.join(map(str, self.parts))}"
        if self.sizes:
            unit = f" {self.length_unit}" if self.length_unit else ""
            sizes = (f"{s.name} {amount(s.value)} ± {s.sd:.2g}{unit}" for s in self.sizes)
            scale = "" if self.length_unit else " (units of the scene)"
            yield f"  sizes: {', '.join(sizes)}{scale}"
        for line in self.conditions:
            said = f"{line.label}: {line.said} ({line.proof.low:.0%}){line.origin}"
            yield f"  {MARKS[line.proof.state]} {said}"
            for step in line.proof.lines(self.length_unit):
                yield f"      {step}"

    def miss_lines(self) -> Iterator[str]:
        """What keeps this assignment from holding: one head line, then only what fails or is open.

        For example 't1 is no table with top = f3: 1 of 8 conditions fails'.
        """
        counts = {state: len(self.conditions_that(state)) for state in State}
        fails, unknown = counts[State.FAILS], counts[State.UNKNOWN]
        said = []
        if fails:
            said.append(f"{fails} of {len(self.conditions)} conditions fail{'s' * (fails == 1)}")
        if unknown:
            said.append(f"{unknown} cannot be told")
        known = "is no" if fails else "may be a" if unknown else "is a"
        parts = ", ".join(map(str, self.parts)) or "no part"
        yield f"{self.thing} {known} {self.model} with {parts}: {', '.join(said) or 'all hold'}"
        for state in (State.FAILS, State.UNKNOWN):
            for line in self.conditions_that(state):
                yield f"  {MARKS[state]} {line.label}: {line.said}{line.origin}"
                for step in line.proof.lines(self.length_unit):
                    yield f"      {step}"
        if counts[State.HOLDS]:
            labels = (c.label for c in self.conditions_that(State.HOLDS))
            yield f"  {MARKS[State.HOLDS]} holds: {', '.join(labels)}"

    def to_json(self) -> dict[str, Any]:
        """The verdict as plain data."""
        return {
            "model": self.model,
            "thing": self.thing,
            "state": self.state.value,
            "degree": self.degree,
            "degree_at_most": self.degree_at_most,
            "specialises": list(self.specialises),
            "probability": self.probability,
            "summary": self.summary,
            "parts": {part.role: list(part.faces) for part in self.parts},
            "sizes": {s.name: {"value": s.value, "sd": s.sd} for s in self.sizes},
            "length_unit": self.length_unit,
            "angles": [{"of": a.measure, "deg": a.value, "sd": a.sd} for a in self.angles],
            "also": self.also,
            "shortfalls": [
                {"label": c.label, "of": miss.measure, "kind": miss.kind, **short.to_json()}
                for c in self.conditions
                for miss in c.proof.shortfalls()
                if (short := miss.shortfall) is not None
            ],
            "proof": [c.to_json() for c in self.conditions],
        }


@dataclass(frozen=True, slots=True)
class Recognition:
    """All verdicts on a scene: one for each thing and model."""

    scene: str
    verdicts: tuple[Verdict, ...]

    @property
    def best(self) -> tuple[Verdict, ...]:
        """What holds, the most probable first; of one thing what is special before what it is.

        By the probabilities if all have one, else by the degrees.
        """
        holding = [v for v in self.verdicts if v.state is State.HOLDS]
        counted = all(v.probability is not None for v in holding)

        def sure(verdict: Verdict) -> float:
            return (verdict.probability or 0.0) if counted else verdict.degree

        degrees = {(v.thing, v.model): sure(v) for v in holding}

        def standing(verdict: Verdict) -> tuple[float, int, float]:
            # As probable as what it is a special case of, and before that.
            general = [(verdict.thing, model) for model in verdict.specialises]
            held = [degrees[key] for key in general if key in degrees]
            return -max((sure(verdict), *held)), -len(held), -verdict.degree

        return tuple(sorted(holding, key=standing))

    @property
    def models(self) -> frozenset[str]:
        """Names of the models that hold somewhere in the scene."""
        return frozenset(v.model for v in self.best)

    def __bool__(self) -> bool:
        return bool(self.best)

    def lines(self) -> Iterator[str]:
        """What holds with its proof, then a line for all that does not."""
        for verdict in self.best:
            yield from verdict.lines()
        for verdict in self.verdicts:
            if verdict.state is not State.HOLDS:
                yield verdict.summary
        if not self.verdicts:
            yield "nothing was found that a model could be asked about"

    def to_json(self) -> dict[str, Any]:
        """The recognition as plain data, with the schema's name."""
        return {
            "schema": SCHEMA,
            "scene": self.scene,
            "recognised": [{"thing": v.thing, "model": v.model} for v in self.best],
            "verdicts": [v.to_json() for v in self.verdicts],
        }
