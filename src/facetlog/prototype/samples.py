"""Varied solids that a model describes, and near misses that fail one of its conditions alone.

Solids that hold are found by random walks from forms that do: all sizes change by random factors,
and what no longer holds is not taken. For a near miss the margin of one condition is pushed below
zero while those of the others stay above (fit.py), then the step is halved towards what holds; the
search for a form leaves others behind, which differ in their parts.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, product

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import moved
from facetlog.prototype.assembly import Form
from facetlog.prototype.fit import Slopes, Try, slopes, stepped
from facetlog.prototype.objective import EXPECTED, PART, Judged, Margins
from facetlog.prototype.search import Search
from facetlog.prototype.workbench import Candidate, Workbench

# Logarithms by which sizes vary: all of them together, and each by itself; around a near miss.
TOGETHER, APART, NEAR = 0.15, 0.15, 0.03
# What is judged beforehand, beside forms that grow: so many sizes far from what holds, and forms
# that are fitted.
FAR_STEPS, FAR_APART, FITTED = 20, 0.5, 3
# Of how many forms there are samples, and of how many near misses are tried to be made.
MOST_FORMS, FORMS = 8, 2
# Of a step that is not taken a shorter one is tried, so often.
SHORTER = 4
# Towards a miss: how far steps reach, how much further what they lead to is tried, since slopes
# change, and how often a step is halved.
REACHES, STRETCHES, HALVED = (0.8, 0.4, 1.6), (1.0, 1.4), 3


@dataclass(frozen=True, slots=True)
class Sample:
    """A solid, the form that it has, and the label of the condition that it fails, if any."""

    form: Form
    judged: Judged
    fails: str = ""


def explored(search: Search, seed: int) -> None:
    """Judge more forms and sizes near those that hold, so that there is a choice of samples."""
    search.most = search.bench.judged + search.most // 2
    for candidate in search.ranked()[:FITTED]:
        if not candidate.judged.holds:
            search.fit(candidate)
    draw = np.random.default_rng([seed, 2])
    for one in search.holding[:FORMS]:
        judge = search.bench.trying(one.form)
        for _ in range(FAR_STEPS):
            logs = FAR_APART * draw.normal(size=len(one.judged.sizes))
            sizes = one.judged.sizes.items()
            judge({n: size * float(np.exp(x)) for (n, size), x in zip(sizes, logs, strict=True)})
    grown = list(search.grown(MOST_FORMS))
    search.look(grown[nth] for nth in draw.permutation(len(grown)))


def iter_holding_samples(search: Search, seed: int) -> Iterator[Sample]:
    """Yield solids that hold, without end, of all forms of the search that do, in turn."""
    draw = np.random.default_rng([seed, 0])
    walks = [_Walk(search.bench, one, draw) for one in search.holding[:MOST_FORMS]]
    for walk in cycle(walks):
        yield Sample(walk.form, walk.step(lambda judged: judged.holds, TOGETHER, APART))


def near_misses(search: Search, seed: int, labels: Sequence[str]) -> dict[str, Iterator[Sample]]:
    """Return, for each label that a solid was found to fail alone, such solids without end."""
    found = {}
    ways = [_Way.of(search.bench, one) for one in search.holding[:FORMS]]
    for nth, label in enumerate(labels):
        start = _first_miss(search, ways, label)
        if start is not None:
            draw = np.random.default_rng([seed, 1, nth])
            found[label] = _misses(_Walk(search.bench, start, draw), label)
    return found


def _misses(walk: "_Walk", label: str) -> Iterator[Sample]:
    while True:
        judged = walk.step(lambda judged: judged.fails_alone == label, NEAR, NEAR)
        yield Sample(walk.form, judged, label)


class _Walk:
    """A random walk over the sizes of a form, and over how it is turned about its upright."""

    def __init__(self, bench: Workbench, start: Candidate, draw: np.random.Generator) -> None:
        self.form = start.form
        self._bench, self._at, self._draw = bench, start.judged, draw

    def step(self, kept: Callable[[Judged], bool], together: float, apart: float) -> Judged:
        """Return where the walk is after a step; where no step is `kept`, where it was."""
        for shorter in range(SHORTER):
            spread = 0.5**shorter
            logs = together * self._draw.normal() + apart * self._draw.normal(size=len(self._sizes))
            turn = self._draw.uniform(0.0, 2.0 * np.pi)
            sizes = {
                name: size * float(np.exp(spread * log))
                for (name, size), log in zip(self._sizes.items(), logs, strict=True)
            }
            try:
                scene = _turned(self.form.scene(sizes), turn)
            except ValueError:
                continue
            judged = self._bench.judge(scene, sizes)
            if kept(judged):
                self._at = judged
                break
        return self._at

    @property
    def _sizes(self) -> Mapping[str, float]:
        return self._at.sizes


def _turned(scene: Scene, angle: float) -> Scene:
    turned = moved(scene, Rotation.from_euler("z", angle).as_matrix())
    return replace(turned, up=scene.up)


@dataclass(frozen=True, slots=True)
class _Way:
    """From where near misses are sought: a form that holds, and how its margins change."""

    start: Candidate
    slope: Slopes
    judge: Try

    @classmethod
    def of(cls, bench: Workbench, start: Candidate) -> "_Way":
        judge = bench.trying(start.form)
        return cls(start, slopes(start.judged, judge), judge)


def _first_miss(search: Search, ways: Sequence[_Way], label: str) -> Candidate | None:
    """Return a solid that fails this alone, near to one that holds if there is such a way."""
    for way in ways:
        pushed = _pushed(way.start.judged, label, way.slope, way.judge)
        if pushed is not None:
            return Candidate(way.start.form, pushed)
    return search.bench.failing_alone(label)


def _pushed(start: Judged, label: str, slope: Slopes, judge: Try) -> Judged | None:
    kept = {k: m for k, m in start.margins.items() if k[0] not in (label, EXPECTED, PART)}
    own = [key for key in start.margins if key[0] == label]
    for key in sorted(own, key=lambda key: start.margins[key]):
        turned = {n: {k: -x if k == key else x for k, x in s.items()} for n, s in slope.items()}
        if any(each.get(key) for each in turned.values()):
            found = _beyond(start, label, {**kept, key: -start.margins[key]}, turned, judge)
            if found is not None:
                return found
    return None


def _beyond(start: Judged, label: str, wanted: Margins, slope: Slopes, judge: Try) -> Judged | None:
    """Return sizes that a first-order step leads to and that fail `label` alone, as near as halving
    goes.

    `wanted` has the margin of what is to fail with its sign turned, as `slope` has.
    """
    for reach, stretch in product(REACHES, STRETCHES):
        step = stepped(start, wanted, slope, reach).items()
        failing = judge({n: x * (x / start.sizes[n]) ** (stretch - 1.0) for n, x in step})
        if failing is None or failing.fails_alone != label:
            continue
        inside, outside = start.sizes, failing
        for _ in range(HALVED):
            middle = {n: math.sqrt(inside[n] * outside.sizes[n]) for n in inside}
            found = judge(middle)
            if found is not None and found.fails_alone == label:
                outside = found
            elif found is not None and found.holds:
                inside = middle
            else:
                break
        return outside
    return None
