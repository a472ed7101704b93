"""Sizes that put what a model measures into the middle of its limits.

Margins (objective.py) are nearly smooth in the logarithms of the sizes. Each step takes their
slopes by differences and solves a linear program within a trust region: the least margin that can
be moved, and behind it all others, as large as they get. A step that does not better is halved.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
from scipy.optimize import linprog

from facetlog.perception.types import FloatArray
from facetlog.prototype.objective import FAR, Judged, Margins

Try: TypeAlias = Callable[[Mapping[str, float]], Judged | None]
"""Judges a form of these sizes; None for sizes that nothing can have."""

Slopes: TypeAlias = Mapping[str, Margins]
"""By size how each margin changes with its logarithm."""

# Of the logarithm of a size. Space is measured in 32 cells: less changes it by jumps.
# To both sides: the longer of two equal sides changes one way only.
STEPS = (0.08, -0.08)
FIRST_STEP, LEAST_STEP = 0.5, 0.06
MOST_STEPS = 8
# What holds is done once a step adds less to its least margin.
GAIN = 0.02
# Moving a size by a factor e costs so much of a margin: what nothing hangs on stays.
STILL = 0.01


def fitted(start: Judged, judge: Try, *, enough: Callable[[], bool] = lambda: False) -> Judged:
    """Return the best that is found from a start, which comes back if nothing is better.

    It ends early where `enough` says so.
    """
    best, reach, steps = start, FIRST_STEP, 0
    slope = None
    while steps < MOST_STEPS and reach >= LEAST_STEP and not enough():
        if slope is None:
            slope = slopes(best, judge)
            missed = [key for key, margin in best.margins.items() if margin <= 0.0]
            if missed and not any(of.get(key) for of in slope.values() for key in missed):
                break  # what is lacking is no size
        there = stepped(best, best.margins, slope, reach)
        found = judge(there)
        steps += 1
        if found is not None and found.rank > best.rank:
            gained = found.rank[:4] != best.rank[:4] or found.rank[4] > best.rank[4] + GAIN
            best, slope = found, None
            if not gained and best.holds:
                break
        else:
            reach /= 2.5
    return best


def slopes(at: Judged, judge: Try) -> Slopes:
    """Return how each margin changes with the logarithm of each size, the mean of both
    directions.
    """
    found: dict[str, Margins] = {}
    for name, size in at.sizes.items():
        tries = {step: judge({**at.sizes, name: size * float(np.exp(step))}) for step in STEPS}
        sides = [(step, there.margins) for step, there in tries.items() if there is not None]
        found[name] = {
            key: sum((there[key] - margin) / step for step, there in sides if key in there)
            / max(1, sum(key in there for _, there in sides))
            for key, margin in at.margins.items()
        }
    return found


def stepped(
    at: Judged,
    wanted: Margins,
    slope: Slopes,
    reach: float,
) -> dict[str, float]:
    """Return sizes at which, to first order, the margins of the `wanted` are largest."""
    names, keys = list(at.sizes), list(wanted)
    table = np.array([[slope.get(n, {}).get(key, 0.0) for n in names] for key in keys])
    values = np.array([wanted[key] for key in keys])
    move = _move(table.reshape(len(keys), len(names)), values, reach)
    return {n: at.sizes[n] * float(np.exp(change)) for n, change in zip(names, move, strict=True)}


def _move(table: FloatArray, values: FloatArray, reach: float) -> Sequence[float]:
    """Return the change of each size's logarithm (n,), from slopes (k, n) and margins (k,)."""
    count, sizes = table.shape
    movable = np.abs(table).max(axis=1, initial=0.0) > 0.0
    # unknowns: moves up (n), moves down (n), the margins (k), the least of them
    cost = np.concatenate([np.full(2 * sizes, STILL), np.full(count, -1.0 / max(1, count)), [-1.0]])
    own = np.hstack([-table, table, np.eye(count), np.zeros((count, 1))])
    least = np.hstack([-table, table, np.zeros((count, count)), np.ones((count, 1))])[movable]
    upper = np.concatenate([values, values[movable]])
    bounds = [(0.0, reach)] * (2 * sizes) + [(None, FAR)] * (count + 1)
    solved = linprog(cost, A_ub=np.vstack([own, least]), b_ub=upper, bounds=bounds)
    if solved.x is None:
        return [0.0] * sizes
    return [float(x) for x in solved.x[:sizes] - solved.x[sizes : 2 * sizes]]
