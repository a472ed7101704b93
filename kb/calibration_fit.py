"""Calibrations fitted to verdicts whose truth is known, and how far a forecast is off.

Isotonic regression (scipy's) of what was right on the middles of degrees' bounds. A map that is
checked on sources which it was not fitted to says what a stranger's scenes will show.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from facetlog.kb.calibration import Calibration, Curve, InputKind, KindCalibration
from facetlog.kb.explaining.proof import State

__all__ = [
    "Bin",
    "Sample",
    "expected_calibration_error",
    "fit",
    "held_out",
    "reliability_table",
]

FloatArray: TypeAlias = NDArray[np.float64]

PRIOR_RIGHT, PRIOR_WRONG = 0.5, 0.5
"""Added to what was counted of each step of a map: Jeffreys' prior of a proportion, so that few
samples never say 0 or 1."""

BESIDE = 0.1
"""What a verdict of another model counts beside one of the model itself, and one on another kind
of input beside one of the same: where a model was hardly seen, it is as right as others are."""

# Of a kept knot: far below what so many samples can tell apart.
DIGITS = 6


@dataclass(frozen=True, slots=True)
class Sample:
    """A verdict on a thing of which the truth is known; `low` and `high` bound its degree.

    `source` is where the thing comes from: what comes from one place is alike.
    """

    model: str
    kind: InputKind
    source: str
    state: State
    low: float
    high: float
    truth: bool

    @property
    def score(self) -> float:
        """The middle of the degree's bounds."""
        return (self.low + self.high) / 2


def fit(samples: Iterable[Sample], contents: Mapping[str, str]) -> Calibration:
    """The maps of all kinds that have samples; `contents` holds the content key of each model.

    Raises KeyError for a model whose content is not given.
    """
    every = tuple(samples)
    kinds = sorted({sample.kind for sample in every})
    return Calibration(MappingProxyType({kind: _of_kind(kind, every, contents) for kind in kinds}))


def held_out(samples: Sequence[Sample], contents: Mapping[str, str]) -> tuple[float, ...]:
    """The confidence of each sample by maps fitted to all other sources than its own.

    Its score as it stands where no other source has its kind of input.
    """
    said = [sample.score for sample in samples]
    for source in dict.fromkeys(sample.source for sample in samples):
        calibration = fit((s for s in samples if s.source != source), contents)
        for i, one in enumerate(samples):
            if one.source == source:
                content = contents[one.model]
                found = calibration.confidence(one.model, content, one.kind, one.low, one.high)
                said[i] = one.score if found is None else found
    return tuple(said)


def _of_kind(
    kind: InputKind, samples: Sequence[Sample], contents: Mapping[str, str]
) -> KindCalibration:
    scores = np.array([round(s.score, DIGITS) for s in samples])
    truths = np.array([float(s.truth) for s in samples])
    likewise = np.array([1.0 if s.kind is kind else BESIDE for s in samples])
    names = np.array([s.model for s in samples])
    here = np.array([s.kind is kind for s in samples])
    own = {}
    for model in sorted(set(names[here].tolist())):
        weights = likewise * np.where(names == model, 1.0, BESIDE)
        counted = int((here & (names == model)).sum())
        own[model] = (contents[model], _fitted(scores, truths, weights, counted))
    pooled = _fitted(scores, truths, likewise, int(here.sum()))
    return KindCalibration(pooled, MappingProxyType(own))


def _fitted(scores: FloatArray, truths: FloatArray, weights: FloatArray, counted: int) -> Curve:
    """The map of weighed samples: isotonic regression, the prior added to each of its steps, and
    once more: near 1/2 it moves a short step more than a long one, past which it might so come."""
    at, index = np.unique(scores, return_inverse=True)
    totals = np.bincount(index, weights=weights).astype(np.float64)
    rights = np.bincount(index, weights=weights * truths).astype(np.float64)
    step = _steps(rights / totals, totals)
    right, total = np.bincount(step, weights=rights), np.bincount(step, weights=totals)
    shares = (right + PRIOR_RIGHT) / (total + PRIOR_RIGHT + PRIOR_WRONG)
    shares = isotonic_regression(shares, weights=total).x
    knots = []
    for number, share in enumerate(shares.tolist()):
        inside = at[step == number]
        ends = dict.fromkeys((float(inside[0]), float(inside[-1])))
        knots += [(end, round(share, DIGITS)) for end in ends]
    return Curve(counted, tuple(knots))


def _steps(shares: FloatArray, weights: FloatArray) -> NDArray[np.int64]:
    """The number of the step that each share is put into."""
    found = isotonic_regression(shares, weights=weights)
    return np.repeat(np.arange(len(found.weights)), np.diff(found.blocks))


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
