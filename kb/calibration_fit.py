"""Calibrations fitted to verdicts whose truth is known, and how far a forecast is off.

Verdicts of each state have three levels of maps: one of all, one for each kind of input, one for
each model on this kind. Each is the share of what was true, by isotonic regression (scipy's) on the
middles of degrees' bounds or, where degrees tell nothing, flat. Each level is shrunk to the one
above, the more the fewer sources it was seen in: a level of n sources counts n / (n + strength).
Shape and strength are those whose maps say best what is true of each source when fitted to all
others. What a stranger's scenes will show is checked on sources that none of it was fitted to.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from facetlog.kb.calibration import Calibration, Curve, InputKind, Maps
from facetlog.kb.explaining.proof import State

__all__ = [
    "FORMS",
    "Bin",
    "Form",
    "Sample",
    "build_reliability_table",
    "choose_form",
    "compute_calibration_error",
    "fit",
    "held_out",
]

FloatArray: TypeAlias = NDArray[np.float64]

PRIOR_RIGHT, PRIOR_WRONG = 0.5, 0.5
"""Added to what was counted of each step of a map: Jeffreys' prior of a proportion, so that few
samples never say 0 or 1."""

# Of a kept knot: far below what so many samples can tell apart.
DIGITS = 6


@dataclass(frozen=True, slots=True)
class Form:
    """How maps are fitted: whether they rise with the degree or are flat, and of how many sources a
    level must be seen in to count as much as the one above."""

    rising: bool
    strength: float


FORMS = tuple(
    Form(rising, strength)
    for rising in (False, True)
    for strength in (32.0, 16.0, 8.0, 4.0, 2.0, 1.0, 0.5)
)
"""To choose from; the first says the same of all verdicts of a state, or nearly so."""


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
    """Return the maps of all kinds of input and states that have samples; `contents` holds the
    content key of each model.

    A kind has maps of each state that any kind has. Raise KeyError for a model whose content is
    not given.
    """
    every = tuple(samples)
    kinds = sorted({s.kind for s in every})
    models = sorted({(s.kind, s.model) for s in every})
    found = {}
    for state in sorted({s.state for s in every}):
        some = [s for s in every if s.state is state]
        form = choose_form(some)
        levels = _levels(some, form.rising)
        for kind in kinds:
            own = {
                model: (contents[model], _shrink_level(levels, (kind, model), form.strength))
                for its_kind, model in models
                if its_kind is kind
            }
            pooled = _shrink_level(levels, (kind,), form.strength)
            found[kind, state] = Maps(pooled, MappingProxyType(own))
    return Calibration(MappingProxyType(found))


def held_out(samples: Sequence[Sample], contents: Mapping[str, str]) -> tuple[float, ...]:
    """Return the confidence of each sample by maps fitted to all other sources than its own.

    Its score as it stands where no other source has its kind of input or its state.
    """
    said = [sample.score for sample in samples]
    for source in dict.fromkeys(sample.source for sample in samples):
        calibration = fit((s for s in samples if s.source != source), contents)
        for i, one in enumerate(samples):
            if one.source == source:
                found = calibration.confidence(
                    one.model, contents[one.model], one.kind, one.state, one.low, one.high
                )
                said[i] = one.score if found is None else found
    return tuple(said)


def choose_form(samples: Sequence[Sample]) -> Form:
    """Return the one of `FORMS` whose maps, fitted to all other sources, give the samples of each
    source the highest likelihood; the first of those that do so equally well.

    Maps that rise are taken only if they do so by more than a standard error over the sources
    (Breiman and others 1984): the order of names hangs on it, and few verdicts hold.
    """
    sources = sorted({s.source for s in samples})
    losses = {form: np.zeros(len(sources)) for form in FORMS}
    for nth, source in enumerate(sources):
        inside = [s for s in samples if s.source == source]
        outside = [s for s in samples if s.source != source]
        for rising in (False, True) if outside else ():
            levels = _levels(outside, rising)
            for sample in inside:
                shares = _list_shares(
                    _list_levels(levels, (sample.kind, sample.model)), sample.score
                )
                for form in FORMS:
                    if form.rising == rising:
                        said = _shrink_shares(shares, form.strength)
                        losses[form][nth] -= math.log(said if sample.truth else 1.0 - said)
    flat, rises = (
        min((form for form in FORMS if form.rising == rising), key=lambda form: losses[form].sum())
        for rising in (False, True)
    )
    gain = losses[flat] - losses[rises]
    by_chance = math.sqrt(len(sources)) * float(gain.std())
    return rises if float(gain.sum()) > by_chance else flat


Key: TypeAlias = tuple[str, ...]
"""Key of a level: () for all samples, (kind of input,), or (kind of input, model)."""

Levels: TypeAlias = Mapping[Key, tuple[Curve, int]]
"""The map of each level, not shrunk yet, and how many sources it was seen in."""


def _levels(samples: Iterable[Sample], rising: bool) -> Levels:
    found: defaultdict[Key, list[Sample]] = defaultdict(list)
    for sample in samples:
        for key in ((), (sample.kind,), (sample.kind, sample.model)):
            found[key].append(sample)
    return {
        key: (_fit_curve(some, rising), len({s.source for s in some}))
        for key, some in found.items()
    }


def _list_levels(levels: Levels, key: Key) -> tuple[tuple[Curve, int], ...]:
    """Return a level and those above it, from the top; without those that no sample is of."""
    every = (key[:length] for length in range(len(key) + 1))
    return tuple(levels[one] for one in every if one in levels)


def _list_shares(chain: Iterable[tuple[Curve, int]], score: float) -> tuple[tuple[float, int], ...]:
    return tuple((curve.at(score), sources) for curve, sources in chain)


def _shrink_shares(shares: Sequence[tuple[float, int]], strength: float) -> float:
    """Return the shrunk share of levels (share, number of sources) from the top."""
    (said, _), *below = shares
    for share, sources in below:
        said += (share - said) * sources / (sources + strength)
    return said


def _shrink_level(levels: Levels, key: Key, strength: float) -> Curve:
    """Return the map of a level, shrunk: straight between the knots of all levels that it consists
    of."""
    chain = _list_levels(levels, key)
    counted = levels[key][0].samples if key in levels else 0
    scores = sorted({at for curve, _ in chain for at, _ in curve.knots})
    said = [round(_shrink_shares(_list_shares(chain, at), strength), DIGITS) for at in scores]
    return Curve(counted, tuple(_drop_level_knots(list(zip(scores, said, strict=True)))))


def _drop_level_knots(knots: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    """Return the knots without those in the middle of a level stretch."""
    for i, (at, share) in enumerate(knots):
        if {one for _, one in knots[max(0, i - 1) : i + 2]} != {share} or i in (0, len(knots) - 1):
            yield at, share


def _fit_curve(samples: Sequence[Sample], rising: bool) -> Curve:
    """Return the map of samples: isotonic regression, or one step if it is not to rise; the prior
    added to each step, and regression once more: near 1/2 it moves a short step more than a long
    one, past which it might so come."""
    at, index = np.unique([round(s.score, DIGITS) for s in samples], return_inverse=True)
    totals = np.bincount(index).astype(np.float64)
    rights = np.bincount(index, weights=[float(s.truth) for s in samples])
    step = _steps(rights / totals, totals) if rising else np.zeros_like(index, shape=at.shape)
    right, total = np.bincount(step, weights=rights), np.bincount(step, weights=totals)
    shares = (right + PRIOR_RIGHT) / (total + PRIOR_RIGHT + PRIOR_WRONG)
    shares = isotonic_regression(shares, weights=total).x
    knots = []
    for number, share in enumerate(shares.tolist()):
        inside = at[step == number]
        ends = dict.fromkeys((float(inside[0]), float(inside[-1])))
        knots += [(end, share) for end in ends]
    return Curve(len(samples), tuple(knots))


def _steps(shares: FloatArray, weights: FloatArray) -> NDArray[np.int64]:
    """Return the number of the step that each share is put into."""
    found = isotonic_regression(shares, weights=weights)
    return np.repeat(np.arange(len(found.weights)), np.diff(found.blocks))


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
