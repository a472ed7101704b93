"""How often a model is right when it says so: from a verdict's degree to a probability.

A degree follows from the facts' standard deviations alone. It knows nothing of what pictures do not
show, or of how well the model's author chose the tolerances. So each model has one monotone map
from the middle of its degree's bounds to the share of things for which it was right, fitted to
scenes whose truth is known (benchmarks/calibration.py).
"""

import hashlib
import json
import re
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files
from itertools import groupby
from types import MappingProxyType
from typing import Any

from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict

__all__ = [
    "Bin",
    "Calibration",
    "ModelCalibration",
    "Sample",
    "content_key",
    "expected_calibration_error",
    "fit",
    "reliability_table",
    "shipped_calibration",
]

SCHEMA = "facetlog-calibration/1"
SHIPPED = "calibration.json"

PRIOR_RIGHT, PRIOR_WRONG = 0.5, 0.5
"""Added to what was counted of each step of a map: Jeffreys' prior of a proportion, so that few
samples never say 0 or 1."""

KEY_DIGITS = 16
# Of a kept knot: far below what so many samples can tell apart.
DIGITS = 6


@dataclass(frozen=True, slots=True)
class Sample:
    """A verdict on a thing of which the truth is known; `low` and `high` bound its degree."""

    model: str
    state: State
    low: float
    high: float
    truth: bool

    @property
    def score(self) -> float:
        """The middle of the degree's bounds."""
        return (self.low + self.high) / 2


@dataclass(frozen=True, slots=True)
class ModelCalibration:
    """One model's map: knots (score, probability), both never falling; straight between them.

    `content` is the `content_key` of the model's text. ValueError for knots that are no such map.
    """

    content: str
    samples: int
    knots: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        if not self.knots:
            raise ValueError("a calibration needs at least one knot")
        for axis in zip(*self.knots, strict=True):
            if not all(0.0 <= value <= 1.0 for value in axis):
                raise ValueError("scores and probabilities of a calibration are from 0 to 1")
            if list(axis) != sorted(axis):
                raise ValueError("a calibration's probability may not fall as the score grows")

    def probability(self, score: float) -> float:
        """The probability at a score; beyond the first and last knot, theirs."""
        scores = [at for at, _ in self.knots]
        after = bisect_left(scores, score)
        if after == 0:
            return self.knots[0][1]
        if after == len(self.knots):
            return self.knots[-1][1]
        (left, low), (right, high) = self.knots[after - 1], self.knots[after]
        # Rounding may not lift it above the knot that it comes to.
        return min(high, low + (high - low) * (score - left) / (right - left))


@dataclass(frozen=True, slots=True)
class Calibration:
    """The maps of all models that were fitted, by name; without any, nothing is calibrated."""

    models: Mapping[str, ModelCalibration] = field(default_factory=lambda: MappingProxyType({}))

    def probability(
        self, model: str, low: float, high: float, *, content: str | None = None
    ) -> float | None:
        """How often the model is right where its degree has these bounds.

        None for a model without samples, and for one whose `content`, if it is given, is not what
        the map was fitted to.
        """
        fitted = self.models.get(model)
        if fitted is None or (content is not None and content != fitted.content):
            return None
        return fitted.probability((low + high) / 2)

    def applied(self, verdict: Verdict, content: str) -> Verdict:
        """The verdict with its probability, of a model with this content key.

        A verdict on no thing at all has none.
        """
        low, high = verdict.degree, verdict.degree_at_most
        said = self.probability(verdict.model, low, high, content=content)
        return replace(verdict, probability=said if verdict.thing else None)

    def to_json(self) -> dict[str, Any]:
        """The maps as plain data, with the schema's name."""
        return {
            "schema": SCHEMA,
            "models": {
                name: {
                    "content": fitted.content,
                    "samples": fitted.samples,
                    "knots": [list(knot) for knot in fitted.knots],
                }
                for name, fitted in sorted(self.models.items())
            },
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Calibration":
        """The maps that `to_json` wrote. Raises ValueError for anything else."""
        try:
            if data["schema"] != SCHEMA:
                raise ValueError(f"a calibration has the schema {SCHEMA}, not {data['schema']}")
            models = {
                str(name): ModelCalibration(
                    str(fitted["content"]),
                    int(fitted["samples"]),
                    tuple((float(score), float(right)) for score, right in fitted["knots"]),
                )
                for name, fitted in data["models"].items()
            }
        except (KeyError, TypeError, AttributeError) as exc:
            raise ValueError(f"this is no calibration: {exc!r}") from exc
        return cls(MappingProxyType(models))


_COMMENT = re.compile(r"^%.*\n", re.MULTILINE)
_PLACE = re.compile(r"'[^'\n]*:\d+'")


def content_key(text: str) -> str:
    """A short digest of a model's clauses: what another text says has another one.

    Comments, and the lines that a compiled clause names, do not count.
    """
    clauses = _PLACE.sub("", _COMMENT.sub("", text))
    return hashlib.sha256(clauses.encode()).hexdigest()[:KEY_DIGITS]


def fit(samples: Iterable[Sample], contents: Mapping[str, str]) -> Calibration:
    """The maps of all models that have samples; `contents` holds the content key of each.

    Isotonic regression by pooling adjacent violators, the prior added to each step, and pooled
    again. Raises KeyError for a model whose content is not given.
    """
    by_model: defaultdict[str, list[Sample]] = defaultdict(list)
    for sample in samples:
        by_model[sample.model].append(sample)
    return Calibration(
        MappingProxyType(
            {
                model: ModelCalibration(contents[model], len(found), _knots(found))
                for model, found in sorted(by_model.items())
            }
        )
    )


@dataclass(frozen=True, slots=True)
class _Step:
    """Scores from `first` to `last` with `right` of `total` things of the model's kind."""

    first: float
    last: float
    right: float
    total: float

    @property
    def share(self) -> float:
        return self.right / self.total

    def __add__(self, other: "_Step") -> "_Step":
        return _Step(self.first, other.last, self.right + other.right, self.total + other.total)


def _knots(samples: Sequence[Sample]) -> tuple[tuple[float, float], ...]:
    ordered = sorted((round(s.score, DIGITS), s.truth) for s in samples)
    # What has one score has one probability.
    steps = []
    for score, group in groupby(ordered, key=lambda pair: pair[0]):
        truths = [truth for _, truth in group]
        steps.append(_Step(score, score, sum(truths), len(truths)))
    weighed = (
        _Step(s.first, s.last, s.right + PRIOR_RIGHT, s.total + PRIOR_RIGHT + PRIOR_WRONG)
        for s in _pooled(steps)
    )
    # Near 1/2 the prior moves a short step more than a long one, and may so push it past another.
    knots = []
    for step in _pooled(weighed):
        share = round(step.share, DIGITS)
        knots += [(step.first, share)] + [(step.last, share)] * (step.last > step.first)
    return tuple(knots)


def _pooled(steps: Iterable[_Step]) -> list[_Step]:
    """The steps, those that would fall below an earlier one joined with it."""
    pooled: list[_Step] = []
    for step in steps:
        while pooled and pooled[-1].share >= step.share:
            step = pooled.pop() + step
        pooled.append(step)
    return pooled


@dataclass(frozen=True, slots=True)
class Bin:
    """Of all that was given a probability from `low` to `high`: how many, the mean of what was
    said, and the share that was true."""

    low: float
    high: float
    count: int
    said: float
    true: float


def reliability_table(
    probabilities: Sequence[float], truths: Sequence[bool], bins: int = 10
) -> tuple[Bin, ...]:
    """The bins of equal width that hold anything, from the lowest.

    Raises ValueError for a probability outside [0, 1], or if there is not one truth for each.

    >>> table = reliability_table([0.25, 0.2, 0.9], [True, False, True], bins=2)
    >>> [(b.count, b.said, b.true) for b in table]
    [(2, 0.225, 0.5), (1, 0.9, 1.0)]
    """
    found: defaultdict[int, list[tuple[float, bool]]] = defaultdict(list)
    for said, true in zip(probabilities, truths, strict=True):
        if not 0.0 <= said <= 1.0:
            raise ValueError(f"{said} is no probability")
        found[min(int(said * bins), bins - 1)].append((said, true))
    return tuple(
        Bin(
            index / bins,
            (index + 1) / bins,
            len(pairs),
            sum(said for said, _ in pairs) / len(pairs),
            sum(true for _, true in pairs) / len(pairs),
        )
        for index, pairs in sorted(found.items())
    )


def expected_calibration_error(
    probabilities: Sequence[float], truths: Sequence[bool], bins: int = 10
) -> float:
    """The mean over all samples of |what was said - what was true| in their bin; 0 without any.

    Naeini, Cooper and Hauskrecht, "Obtaining well calibrated probabilities", 2015, equation 1.
    """
    table = reliability_table(probabilities, truths, bins)
    total = sum(row.count for row in table)
    return sum(row.count * abs(row.said - row.true) for row in table) / total if total else 0.0


@cache
def shipped_calibration() -> Calibration:
    """The calibration of the built-in models that comes with the program."""
    text = files("facetlog.kb").joinpath(SHIPPED).read_text(encoding="utf-8")
    return Calibration.from_json(json.loads(text))
