"""Incidence constraints: one estimator for lines of points, lines of lines, and planes of lines.

Each of the paper's constructions (figures 4 to 6, after Ayache) says that a measured x lies on the
estimated a, by equations that are linear in either: f(x, a) = M(x) a - y(x) = 0. `fit_most_likely`
fits all measurements at once; `updated` takes one more for many states side by side, `update_one`
for a single one. M contains the noise of x, which biases a filter that is linearised at the
measured x; so x is first projected to its most likely place on a, x* = x - Λ Gᵀ W⁻¹ f, as equation
(1) requires (x* there). The paper's printed recursions do not: `measure_as_printed`.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.special import chdtri

from facetlog.perception.estimation.ekf import (
    Linearised,
    Measurement,
    State,
    innovation_chi2,
    linearise,
    step,
    step_all,
)
from facetlog.perception.types import FloatArray

T = TypeVar("T")

# The passes end when none moves a state by more than this (unit: its own standard deviation).
CONVERGED_SD = 1e-7
MAX_PASSES = 50
# A pass that makes the fit worse is halved at most so often.
HALVINGS = 12
# Iterations of an update, each linearised at the result of the one before: the second moves it by
# the square of what the first one did, relative to where the equations stop being linear.
RELINEARISED = 3
# Slopes (and places, as a share of the distance) with a larger standard deviation are too vague to
# linearise further measurements at: the neglected terms grow with the square, 1/400 of a
# measurement.
SURE_SD = 0.05
# A state leaves its chart for the best one at a slope beyond this: at 1 it could alternate.
MAX_SLOPE = 1.25
# Measurements that are held for a start at most, which bounds what an update takes.
MAX_HELD = 8
# Gate: an innovation of two equations this large by chance once in so many is an outlier.
GATE = float(chdtri(2, 1e-5))


@dataclass(frozen=True, slots=True)
class Incidence:
    """That x (..., m) lies on a (..., n), by p equations f = M(x) a - y(x).

    `equations` takes x to M (..., p, n) and y (..., p); `by_measured` takes a to G = ∂f/∂x
    (..., p, m), which x does not change.
    """

    equations: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    by_measured: Callable[[FloatArray], FloatArray]


def solved(on: Incidence, x: FloatArray) -> FloatArray:
    """Return the unweighted least-squares a (..., n) of measurements x (..., V, m)."""
    M, y = on.equations(x)
    rows = M.reshape(*M.shape[:-3], -1, M.shape[-1])
    values = y.reshape(*y.shape[:-2], -1)
    solution: FloatArray = (np.linalg.pinv(rows) @ values[..., None])[..., 0]
    return solution


def fit_most_likely(
    on: Incidence,
    x: FloatArray,
    noise: FloatArray,
    start: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the most likely a (N, n), covariance (N, n, n), chi-square (N,) of x (N, V, m).

    `noise` (N, V, m, m) may be singular where the equations do not ask. Gauss-Newton from `start`
    (N, n), every measurement made linear at one shared a: no order matters.
    """
    a = np.array(start)
    information, pull, cost = _build_normal_equations(on, x, noise, a)
    for _ in range(MAX_PASSES):
        move = np.linalg.solve(information, pull[..., None])[..., 0]
        if not (np.einsum("ni,nij,nj->n", move, information, move) > CONVERGED_SD**2).any():
            break
        for _ in range(HALVINGS):
            worse = _build_normal_equations(on, x, noise, a + move)[2] > cost
            if not worse.any():
                break
            move[worse] /= 2
        a = a + move
        information, pull, cost = _build_normal_equations(on, x, noise, a)
    cov = np.linalg.inv(information)
    return a, (cov + cov.swapaxes(-1, -2)) / 2, cost


def updated(
    on: Incidence, a: FloatArray, S: FloatArray, x: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a (N, n) and S (N, n, n) after one more measurement x (N, m), `noise` (N, m, m), of
    each.

    The third value (N,) is the squared Mahalanobis length of the innovation, chi-square with p
    degrees of freedom, by which a caller may refuse the update.
    """
    after, cov = a, S
    for again in range(RELINEARISED):
        y, M, W, _ = _linearise_incidence(on, x, noise, after)
        if not again:
            innovation = y - (M @ a[..., None])[..., 0]
            spread = W + M @ S @ M.swapaxes(-1, -2)
            chi2 = np.einsum(
                "np,np->n", innovation, np.linalg.solve(spread, innovation[..., None])[..., 0]
            )
        after, cov = step_all(a, S, y, M, W)
    return after, cov, chi2


def update_one(
    on: Incidence, state: State, x: FloatArray, noise: FloatArray
) -> tuple[State, float]:
    """Update a single state with a measurement x (m,), `noise` (m, m), of it, as `updated`."""
    after = state
    for again in range(RELINEARISED):
        y, M, W, _ = _linearise_incidence(on, x, noise, after.mean)
        measured = Linearised(y, M, W)
        if not again:
            chi2 = innovation_chi2(state, measured)
        after = step(state, measured)
    return after, chi2


def measure_as_printed(on: Incidence, x: FloatArray, noise: FloatArray) -> Measurement:
    """Return a measurement x (m,), `noise` (m, m), for the paper's recursion as printed: M at the
    measured x, the weight at the previous estimate.
    """
    M, y = on.equations(x)
    return lambda a: linearise(M @ a - y, M, on.by_measured(a), noise, a)


def run_from_fit(
    fit: Callable[[int], T], count: int, is_sure: Callable[[T], bool], update: Callable[[T, int], T]
) -> Iterator[T]:
    """Yield an estimate after each further of `count` measurements, each used once.

    The start is `fit` of the first ones: as many as make it sure, at most MAX_HELD; none if `fit`
    raises ValueError for all. `update` takes measurement k.
    """
    found: tuple[T, int] | None = None
    for held in range(2, min(count, MAX_HELD) + 1):
        with suppress(ValueError):
            found = fit(held), held
            if is_sure(found[0]):
                break
    if found is None:
        return
    estimate, held = found
    yield estimate
    for k in range(held, count):
        estimate = update(estimate, k)
        yield estimate


def converted(
    S: FloatArray, a: FloatArray, to: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return another description to(a) (k,) of an estimate a (n,), with its covariance (k, k) by
    first order; the derivative is taken by complex steps, exact to rounding (Squire and Trapp
    1998).
    """
    tiny = 1e-100
    J = np.stack([to(a + 1j * tiny * e).imag / tiny for e in np.eye(len(a))], axis=-1)
    return to(a), J @ S @ J.T


def _linearise_incidence(
    on: Incidence, x: FloatArray, noise: FloatArray, a: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    # y, M and W of the filter at a, with x moved onto a; and f at x as measured.
    G = on.by_measured(a)
    along = noise @ G.swapaxes(-1, -2)
    W = G @ along
    M, y = on.equations(x)
    f = (M @ a[..., None])[..., 0] - y
    moved = x - (along @ np.linalg.solve(W, f[..., None]))[..., 0]
    M, _ = on.equations(moved)
    return (M @ a[..., None])[..., 0] - f, M, W, f


def _build_normal_equations(
    on: Incidence, x: FloatArray, noise: FloatArray, a: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    # Σ Mᵀ W⁻¹ M, -Σ Mᵀ W⁻¹ f, and the chi-square.
    each = np.broadcast_to(a[:, None], (*x.shape[:2], a.shape[-1]))
    _, M, W, f = _linearise_incidence(on, x, noise, each)
    weighted = np.linalg.solve(W, M)
    information = np.einsum("nvpi,nvpj->nij", M, weighted)
    cost = np.einsum("nvp,nvp->n", f, np.linalg.solve(W, f[..., None])[..., 0])
    return information, -np.einsum("nvpi,nvp->ni", weighted, f), cost
