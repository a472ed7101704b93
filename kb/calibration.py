"""How often a model is right when it says so: from a verdict's degree to its confidence.

A degree follows from what was measured of this scene alone. It knows nothing of what was not seen,
or of how well the model describes what people call so. Both are counted on scenes whose truth is
known, and fitted by calibration_fit.py: for each state of a verdict (holds, fails, unknown) the
odds of being right follow from the degree's bounds, the views and the share that was seen (the more
the better), from how the thing was measured, and from the model. What few cases say is an interval,
and of a model without cases nothing is said. Confidences change neither what holds nor the degrees.
"""

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

from facetlog.kb.confidence import Confidence
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict

__all__ = [
    "FEATURES",
    "SHIPPED",
    "Calibration",
    "Counted",
    "Evidence",
    "InputKind",
    "Scale",
    "compute_judging_key",
    "content_key",
    "load_shipped_calibration",
    "make_evidence",
]

SCHEMA = "facetlog-calibration/4"
SHIPPED = "calibration.json"
KEY_DIGITS = 16

FEATURES = ("degree_at_most", "log10 views", "seen share")
"""Names of the features that `Evidence.list_features` returns."""

SDS = 1.645
"""Half the width of an interval in standard deviations: it holds nine tenths of a normal
distribution."""


class InputKind(StrEnum):
    """How a thing was measured: found in pictures, known from all sides, or scanned from some."""

    PICTURES = "pictures"
    WHOLE = "whole"
    SCANNED = "scanned"


@dataclass(frozen=True, slots=True)
class Evidence:
    """How a thing was measured, from how many views (0 unless from pictures), and the share of its
    faces' area that was seen."""

    kind: InputKind
    views: int = 0
    seen: float = 1.0

    def list_features(self, degree_at_most: float) -> tuple[float, ...]:
        """Return the numbers that `Scale.weights` are of.

        Each doubling of the number of views counts alike. The lower bound of a degree has no part:
        what was not seen lowers it, and things that were seen in part are as often right.
        """
        return degree_at_most, math.log10(max(1, self.views)), self.seen


def make_evidence(surface: InputKind | None, views: int, seen: float) -> Evidence:
    """Return how a thing was measured: from its surface, if it is known from that, else in so many
    views."""
    if surface is None:
        return Evidence(InputKind.PICTURES, views, min(1.0, seen))
    return Evidence(surface, 0, min(1.0, seen))


@dataclass(frozen=True, slots=True)
class Counted:
    """The cases of a model on one kind of input, with a verdict of one state.

    `offset` are the log odds of being right where all features are 0, `sd` their standard
    deviation. Of `cases` labelled things `true` were what the model describes; `sources` are the
    collections that they are from.
    """

    offset: float
    sd: float
    cases: int
    true: int
    sources: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Scale:
    """From verdicts of one state to confidences. ValueError for weights below 0: a confidence may
    not fall as the degree, the views or the seen share grow.

    `models` has by name the `compute_judging_key` of the text that was counted, and its cases.
    """

    weights: tuple[float, ...]
    models: Mapping[str, tuple[str, Mapping[InputKind, Counted]]]

    def __post_init__(self) -> None:
        if len(self.weights) != len(FEATURES):
            raise ValueError(f"a calibration has a weight for each of {', '.join(FEATURES)}")
        if not all(weight >= 0.0 for weight in self.weights):
            raise ValueError("a calibration may not fall as the degree grows")


NO_CASES = (
    "no labelled scenes of it were counted (docs/model-reference.md: Calibrate your own models)"
)
CHANGED = "its text is not the one that was counted"
NOTHING_COUNTED = "degrees are not calibrated here"


@dataclass(frozen=True, slots=True)
class Calibration:
    """The scales by state of the verdict; where there are none, nothing is calibrated."""

    scales: Mapping[State, Scale] = field(default_factory=lambda: MappingProxyType({}))

    def compute(
        self, model: str, content: str, state: State, degree_at_most: float, evidence: Evidence
    ) -> Confidence:
        """Return how often a thing is what the model describes where its verdict on such evidence
        has this state, and its degree this upper bound; or why that is not known."""
        scale = self.scales.get(state)
        if scale is None:
            return Confidence(reason=NOTHING_COUNTED)
        known, kinds = scale.models.get(model, ("", {}))
        counted = kinds.get(evidence.kind)
        if counted is None:
            return Confidence(reason=NO_CASES)
        if known != content:
            return Confidence(reason=CHANGED)
        features = evidence.list_features(degree_at_most)
        odds = counted.offset + sum(w * x for w, x in zip(scale.weights, features, strict=True))
        return Confidence(
            _share(odds),
            _share(odds - SDS * counted.sd),
            _share(odds + SDS * counted.sd),
            counted.cases,
            counted.true,
            counted.sources,
        )

    def apply(self, verdict: Verdict, content: str, evidence: Evidence) -> Verdict:
        """Return the verdict with its confidence; one on no thing at all has none."""
        if not verdict.thing:
            return verdict
        most = verdict.degree_at_most
        found = self.compute(verdict.model, content, verdict.state, most, evidence)
        return replace(verdict, confidence=found)

    def to_json(self) -> dict[str, Any]:
        """Return the scales as plain data, with the schema's name."""
        every = (
            counted
            for scale in self.scales.values()
            for _, kinds in scale.models.values()
            for counted in kinds.values()
        )
        sources = sorted({source for counted in every for source in counted.sources})
        numbers = {source: i for i, source in enumerate(sources)}
        return {
            "schema": SCHEMA,
            "sources": sources,
            "states": {
                state.value: {
                    "weights": list(scale.weights),
                    "models": {
                        model: {
                            "content": content,
                            **{k.value: _to_row(c, numbers) for k, c in sorted(kinds.items())},
                        }
                        for model, (content, kinds) in sorted(scale.models.items())
                    },
                }
                for state, scale in sorted(self.scales.items())
            },
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Calibration":
        """Return the scales that `to_json` wrote. Raise ValueError for anything else."""
        try:
            if data["schema"] != SCHEMA:
                raise ValueError(f"a calibration has the schema {SCHEMA}, not {data['schema']}")
            sources = tuple(map(str, data["sources"]))
            scales = {State(s): _read_scale(one, sources) for s, one in data["states"].items()}
        except (KeyError, TypeError, AttributeError, IndexError) as exc:
            raise ValueError(f"this is no calibration: {exc!r}") from exc
        return cls(MappingProxyType(scales))


def _share(odds: float) -> float:
    """Return the probability of log odds."""
    return 0.5 + 0.5 * math.tanh(odds / 2)


def _to_row(counted: Counted, numbers: Mapping[str, int]) -> list[Any]:
    from_sources = [numbers[source] for source in counted.sources]
    return [counted.offset, counted.sd, counted.cases, counted.true, from_sources]


def _read_scale(data: Mapping[str, Any], sources: tuple[str, ...]) -> Scale:
    models = {
        str(model): (
            str(one["content"]),
            MappingProxyType(
                {
                    InputKind(kind): Counted(
                        float(row[0]),
                        float(row[1]),
                        int(row[2]),
                        int(row[3]),
                        tuple(sources[i] for i in row[4]),
                    )
                    for kind, row in one.items()
                    if kind != "content"
                }
            ),
        )
        for model, one in data["models"].items()
    }
    return Scale(tuple(map(float, data["weights"])), MappingProxyType(models))


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
