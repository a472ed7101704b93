"""Calibrations fitted to verdicts whose truth is known, and how far a forecast is off.

Verdicts of each state have a logistic regression: on features of the evidence, whose weights are
not below 0, with an effect for each kind of input, each model, and each model on a kind. All have a
normal prior round 0, so that few cases lean on all others. Standard deviations are of the normal
approximation round the most probable values (MacKay, "The evidence framework applied to
classification networks", 1992). What a stranger's scenes will show is checked on sources that none
of it was fitted to.
"""

import csv
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.calibration import Calibration, Counted, Evidence, InputKind, Scale
from facetlog.kb.confidence import Confidence
from facetlog.kb.explaining.proof import State

__all__ = [
    "Bin",
    "Sample",
    "build_reliability_table",
    "compute_calibration_error",
    "compute_error_by_model",
    "fit",
    "held_out",
    "read_samples",
    "write_samples",
]

FloatArray: TypeAlias = NDArray[np.float64]

PRIOR_SD = 2.5
"""Prior sd of weights and of effects of kinds of input, in log odds: from even odds it reaches
92 %, and twice that 99.3 % (Gelman and others, "A weakly informative default prior distribution",
2008)."""
MODEL_SD = 1.5
"""Prior sd of the effects of models. Of 1, 1.5, 2.5 and 4 the smaller make sources that were left
out the more probable, and the larger make the error by model the smaller; this is the least that
keeps it below 0.05."""
PAIR_SD = 0.7
"""Prior sd of the effects of models on one kind of input: of 0, 0.7 and 1.5 the one by which
sources that were left out are most probable."""

# Decimals that are kept: far below what so many samples can tell apart.
DIGITS = 4
CONVERGED = 1e-9
STEPS = 200
# Longest step of Newton's method, in log odds: a longer one may overshoot.
LONGEST_STEP = 2.0

KINDS = tuple(InputKind)


@dataclass(frozen=True, slots=True, order=True)
class Sample:
    """A verdict on a thing of which the truth is known; `low` and `high` bound its degree.

    `source` is where the thing comes from: what comes from one place is alike. A collection of
    several places is named before a colon ('tours: table'). `content` is the judging key of the
    model's text.
    """

    model: str
    content: str
    kind: InputKind
    source: str
    state: State
    low: float
    high: float
    truth: bool
    views: int = 0
    seen: float = 1.0

    @property
    def score(self) -> float:
        """The middle of the degree's bounds."""
        return (self.low + self.high) / 2

    @property
    def evidence(self) -> Evidence:
        """How the thing was measured."""
        return Evidence(self.kind, self.views, self.seen)

    @property
    def collection(self) -> str:
        """The name of the collection that the source is of."""
        return self.source.split(":")[0]


def fit(samples: Iterable[Sample]) -> Calibration:
    """Return the scales of all states that have samples, for all models that have samples of any
    state; the same whatever the order of the samples.

    Raise ValueError where samples of one model are of several texts.
    """
    every = sorted(samples)
    contents: dict[str, str] = {}
    for sample in every:
        if contents.setdefault(sample.model, sample.content) != sample.content:
            raise ValueError(f"samples of {sample.model} are of different texts")
    states = {state: [s for s in every if s.state is state] for state in State}
    return Calibration(
        MappingProxyType(
            {state: _fit_scale(some, contents) for state, some in states.items() if some}
        )
    )


def _fit_scale(samples: Sequence[Sample], contents: Mapping[str, str]) -> Scale:
    models = tuple(contents)
    features = np.array([s.evidence.list_features(s.high) for s in samples])
    count = features.shape[1]
    design = np.hstack([_mark_effects(s.kind, s.model, models) for s in samples])
    design = np.hstack([features, design.reshape(len(samples), -1)])
    right = np.array([s.truth for s in samples], dtype=np.float64)
    sds = np.full(design.shape[1], PRIOR_SD)
    sds[count + 1 + len(KINDS) :] = PAIR_SD
    sds[count + 1 + len(KINDS) :][: len(models)] = MODEL_SD
    found, covariance = _fit_logistic(design, right, sds, count)
    weights = np.round(found[:count], DIGITS)
    typical = features.mean(axis=0)
    counted: defaultdict[tuple[str, InputKind], list[Sample]] = defaultdict(list)
    for sample in samples:
        counted[sample.model, sample.kind].append(sample)

    def count_cases(model: str, kind: InputKind) -> Counted:
        effects = _mark_effects(kind, model, models)
        at = np.concatenate([typical, effects])
        cases = counted[model, kind]
        return Counted(
            round(float(effects @ found[count:]), DIGITS),
            round(float(np.sqrt(at @ covariance @ at)), DIGITS),
            len(cases),
            sum(s.truth for s in cases),
            tuple(sorted({s.collection for s in cases})),
        )

    return Scale(
        tuple(weights.tolist()),
        MappingProxyType(
            {
                model: (content, MappingProxyType({k: count_cases(model, k) for k in KINDS}))
                for model, content in contents.items()
            }
        ),
    )


def _mark_effects(kind: InputKind, model: str, models: Sequence[str]) -> FloatArray:
    """Return 1 for the effects that a verdict has: of all, of its kind, of its model, of both."""
    of_kind = np.array([kind is one for one in KINDS], dtype=np.float64)
    of_model = np.array([model == one for one in models], dtype=np.float64)
    return np.concatenate([[1.0], of_kind, of_model, np.outer(of_model, of_kind).ravel()])


def _fit_logistic(
    design: FloatArray, right: FloatArray, sds: FloatArray, not_negative: int
) -> tuple[FloatArray, FloatArray]:
    """Return the most probable coefficients (n,), the first so many not below 0, and their
    covariance (n, n) with 0 for those at that bound; `sds` (n,) are of the prior."""
    n = design.shape[1]
    free, found = np.ones(n, dtype=bool), np.zeros(n)
    while True:
        found[free], covariance = _climb(design[:, free], right, sds[free])
        below = free & (found < 0.0) & (np.arange(n) < not_negative)
        if not below.any():
            whole = np.zeros((n, n))
            whole[np.ix_(free, free)] = covariance
            return found, whole
        free &= ~below
        found[~free] = 0.0


def _climb(design: FloatArray, right: FloatArray, sds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the most probable coefficients and their covariance, by Newton's method."""
    precision = np.diag(1.0 / sds**2)
    found = np.zeros(design.shape[1])
    for _ in range(STEPS):
        share = 1.0 / (1.0 + np.exp(-design @ found))
        curvature = (design.T * (share * (1.0 - share))) @ design + precision
        step = np.linalg.solve(curvature, design.T @ (right - share) - precision @ found)
        longest = float(np.abs(step).max())
        found = found + step * min(1.0, LONGEST_STEP / max(longest, CONVERGED))
        if longest < CONVERGED:
            break
    return found, np.linalg.inv(curvature).astype(np.float64)


def held_out(samples: Sequence[Sample]) -> tuple[Confidence, ...]:
    """Return the confidence of each sample by what is fitted to all other sources than its own.

    The score as it stands where no other source has its state.
    """
    said = [Confidence(sample.score) for sample in samples]
    for source in dict.fromkeys(sample.source for sample in samples):
        calibration = fit(s for s in samples if s.source != source)
        for i, one in enumerate(samples):
            if one.source == source:
                found = calibration.compute(
                    one.model, one.content, one.state, one.high, one.evidence
                )
                said[i] = said[i] if found.value is None else found
    return tuple(said)


def write_samples(path: Path, samples: Iterable[Sample]) -> None:
    """Write the samples as CSV, a line each."""
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, [field.name for field in fields(Sample)])
        table.writeheader()
        table.writerows(asdict(sample) for sample in samples)


def read_samples(path: Path) -> tuple[Sample, ...]:
    """Return the samples that `write_samples` wrote. Raise ValueError for anything else."""
    with path.open(encoding="utf-8", newline="") as file:
        try:
            return tuple(
                Sample(
                    row["model"],
                    row["content"],
                    InputKind(row["kind"]),
                    row["source"],
                    State(row["state"]),
                    float(row["low"]),
                    float(row["high"]),
                    row["truth"] == "True",
                    int(row["views"]),
                    float(row["seen"]),
                )
                for row in csv.DictReader(file)
            )
        except (KeyError, TypeError) as exc:
            raise ValueError(f"{path}: this is no table of samples: {exc!r}") from exc


@dataclass(frozen=True, slots=True)
class Bin:
    """Forecasts that were given a probability from `low` to `high`: how many, the mean of what was
    said, and the share that was true."""

    low: float
    high: float
    count: int
    said: float
    true: float


def build_reliability_table(
    probabilities: Sequence[float], truths: Sequence[bool], bins: int = 10
) -> tuple[Bin, ...]:
    """Return the bins of equal width that hold anything, from the lowest.

    Raise ValueError for a probability outside [0, 1], or if there is not one truth for each.

    >>> table = build_reliability_table([0.25, 0.2, 0.9], [True, False, True], bins=2)
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


def compute_calibration_error(
    probabilities: Sequence[float], truths: Sequence[bool], bins: int = 10
) -> float:
    """Return the mean over all samples of |what was said - what was true| in their bin; 0 without
    any.

    Naeini, Cooper and Hauskrecht, "Obtaining well calibrated probabilities", 2015, equation 1.
    """
    table = build_reliability_table(probabilities, truths, bins)
    total = sum(row.count for row in table)
    return sum(row.count * abs(row.said - row.true) for row in table) / total if total else 0.0


def compute_error_by_model(samples: Sequence[Sample], said: Sequence[Confidence]) -> float:
    """Return the mean over all samples of how far, for their model, the share that was true lies
    from what was said in the mean: from the figure, or outside the bounds where these were said.

    0 without any.
    """
    low: defaultdict[str, float] = defaultdict(float)
    high: defaultdict[str, float] = defaultdict(float)
    for sample, confidence in zip(samples, said, strict=True):
        value = confidence.value or 0.0
        wide = confidence.is_wide
        low[sample.model] += ((confidence.low or 0.0) if wide else value) - sample.truth
        high[sample.model] += ((confidence.high or 0.0) if wide else value) - sample.truth
    off = sum(max(0.0, low[model], -high[model]) for model in low)
    return off / len(samples) if samples else 0.0
