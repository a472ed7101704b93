"""How often a model is right when it says so: from a verdict's degree to its confidence.

A degree follows from what was measured of this scene alone. It knows nothing of what was not seen,
or of how well the model describes what people call so. Both depend on how the scene was measured
and on what came of it: so each model has, for each kind of input and each state of a verdict
(holds, fails, unknown), one monotone map from the middle of its degree's bounds to the share of
things that were what it describes; and each kind and state has one for models that were not
counted. Maps are fitted by calibration_fit.py to scenes whose truth is known. They change neither
what holds nor the degrees.
"""

import hashlib
import json
import re
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache
from importlib.resources import files
from operator import itemgetter
from types import MappingProxyType
from typing import Any

from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict

__all__ = [
    "SHIPPED",
    "Calibration",
    "Curve",
    "InputKind",
    "Maps",
    "compute_judging_key",
    "content_key",
    "load_shipped_calibration",
]

SCHEMA = "facetlog-calibration/3"
SHIPPED = "calibration.json"
KEY_DIGITS = 16


class InputKind(StrEnum):
    """How a thing was measured: found in pictures, known from all sides, or scanned from some."""

    PICTURES = "pictures"
    WHOLE = "whole"
    SCANNED = "scanned"


@dataclass(frozen=True, slots=True)
class Curve:
    """A map: knots (score, share that was right), both never falling; straight between them.

    `samples` is how many verdicts it was fitted to. ValueError for knots that are no such map.
    """

    samples: int
    knots: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        if not self.knots:
            raise ValueError("a calibration needs at least one knot")
        for axis in zip(*self.knots, strict=True):
            if not all(0.0 <= value <= 1.0 for value in axis):
                raise ValueError("scores and shares of a calibration are from 0 to 1")
            if list(axis) != sorted(axis):
                raise ValueError("a calibration may not fall as the score grows")

    def at(self, score: float) -> float:
        """Return the share at a score; beyond the first and last knot, theirs."""
        after = bisect_left(self.knots, score, key=itemgetter(0))
        if after == 0:
            return self.knots[0][1]
        if after == len(self.knots):
            return self.knots[-1][1]
        (left, low), (right, high) = self.knots[after - 1], self.knots[after]
        # Rounding may not lift it above the knot that it comes to.
        return min(high, low + (high - low) * (score - left) / (right - left))


@dataclass(frozen=True, slots=True)
class Maps:
    """The maps of verdicts of one state on one kind of input: of each model that was counted, and
    the one of all others.

    `models` has by name the `compute_judging_key` of the text that was counted, and its map.
    """

    pooled: Curve
    models: Mapping[str, tuple[str, Curve]] = field(default_factory=lambda: MappingProxyType({}))

    def curve(self, model: str, content: str) -> Curve:
        """Return the map of a model of this judging key: its own if counted, else the pooled."""
        counted, own = self.models.get(model, ("", self.pooled))
        return own if content and counted == content else self.pooled


@dataclass(frozen=True, slots=True)
class Calibration:
    """The maps by kind of input and state of the verdict; where there are none, nothing is
    calibrated."""

    maps: Mapping[tuple[InputKind, State], Maps] = field(
        default_factory=lambda: MappingProxyType({})
    )

    def confidence(
        self, model: str, content: str, kind: InputKind, state: State, low: float, high: float
    ) -> float | None:
        """Return how often a thing is what the model describes where its verdict on such input has
        this state, and its degree these bounds; or None."""
        maps = self.maps.get((kind, state))
        return None if maps is None else maps.curve(model, content).at((low + high) / 2)

    def applied(self, verdict: Verdict, content: str, kind: InputKind) -> Verdict:
        """Return the verdict with its confidence; one on no thing at all has none."""
        low, high = verdict.degree, verdict.degree_at_most
        said = self.confidence(verdict.model, content, kind, verdict.state, low, high)
        return replace(verdict, confidence=said if verdict.thing else None)

    def to_json(self) -> dict[str, Any]:
        """Return the maps as plain data, with the schema's name."""
        kinds: dict[str, dict[str, Any]] = {}
        for (kind, state), maps in sorted(self.maps.items()):
            kinds.setdefault(kind.value, {})[state.value] = {
                "all": _write_curve(maps.pooled),
                "models": {
                    name: {"content": content, **_write_curve(curve)}
                    for name, (content, curve) in sorted(maps.models.items())
                },
            }
        return {"schema": SCHEMA, "kinds": kinds}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Calibration":
        """Return the maps that `to_json` wrote. Raise ValueError for anything else."""
        try:
            if data["schema"] != SCHEMA:
                raise ValueError(f"a calibration has the schema {SCHEMA}, not {data['schema']}")
            maps = {
                (InputKind(kind), State(state)): _maps(one)
                for kind, states in data["kinds"].items()
                for state, one in states.items()
            }
        except (KeyError, TypeError, AttributeError) as exc:
            raise ValueError(f"this is no calibration: {exc!r}") from exc
        return cls(MappingProxyType(maps))


def _maps(data: Mapping[str, Any]) -> Maps:
    models = {
        str(name): (str(one["content"]), _read_curve(one)) for name, one in data["models"].items()
    }
    return Maps(_read_curve(data["all"]), MappingProxyType(models))


def _write_curve(curve: Curve) -> dict[str, Any]:
    return {"samples": curve.samples, "knots": [list(knot) for knot in curve.knots]}


def _read_curve(data: Mapping[str, Any]) -> Curve:
    knots = tuple((float(score), float(right)) for score, right in data["knots"])
    return Curve(int(data["samples"]), knots)


_COMMENT = re.compile(r"^%.*\n", re.MULTILINE)
_PLACE = re.compile(r"'[^'\n]*:\d+'")
# From its head to the full stop that ends a line.
_JUDGES_NOTHING = re.compile(
    r"^(?:size|rather_than|written|example)\(.*?\.[ \t]*(?:%[^\n]*)?$\n?", re.MULTILINE | re.DOTALL
)
_EMPTY_LINES = re.compile(r"\n\s*\n")


def content_key(text: str) -> str:
    """Return a short digest of a model's clauses: what another text says has another one.

    Comments, and the lines that a compiled clause names, do not count.
    """
    clauses = _PLACE.sub("", _COMMENT.sub("", text))
    return hashlib.sha256(clauses.encode()).hexdigest()[:KEY_DIGITS]


def compute_judging_key(text: str) -> str:
    """Return the `content_key` of what a model judges by; calibrations go by it.

    Sizes, which a verdict reports, the names that go after it, examples and how the author wrote a
    line judge nothing: a model that says the same in other words is as often right.
    """
    judging = _COMMENT.sub("", _JUDGES_NOTHING.sub("", text))
    return content_key(_EMPTY_LINES.sub("\n", judging).strip())


@cache
def load_shipped_calibration() -> Calibration:
    """Return the calibration that comes with the program."""
    text = files("facetlog.kb").joinpath(SHIPPED).read_text(encoding="utf-8")
    return Calibration.from_json(json.loads(text))
