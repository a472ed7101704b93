"""The paper's recursion: an extended Kalman filter for implicit measurements f(x, a) = 0.

Equations (1) to (5) of section 2. Names are the paper's: a is what is estimated, S its covariance,
x a measurement with covariance Λ, M = ∂f/∂a, W the noise of f, K the gain. The state is static, so
the filter has no prediction step.

One state is filtered by filterpy's ExtendedKalmanFilter (`step`), thousands at once by the same
equations in numpy (`step_all`).
"""

import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.types import FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """Estimate a (n,) and its covariance S (n, n)."""

    mean: FloatArray
    cov: FloatArray

    def __post_init__(self) -> None:
        mean = np.array(self.mean, dtype=np.float64)
        cov = np.array(self.cov, dtype=np.float64)
        if mean.ndim != 1 or cov.shape != (mean.size, mean.size):
            raise ValueError(f"a mean {mean.shape} and a covariance {cov.shape} do not go together")
        for array, name in ((mean, "mean"), (cov, "cov")):
            array.setflags(write=False)
            object.__setattr__(self, name, array)


@dataclass(frozen=True, eq=False, slots=True)
class Linearised:
    """A measurement made linear, y = M a + noise: y (p,), M (p, n), W (p, p) the noise."""

    y: FloatArray
    M: FloatArray
    W: FloatArray


# A measurement as a function of the estimate at which it is linearised.
Measurement = Callable[[FloatArray], Linearised]


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """The final state of a run, after how many views, and whether the limit was met."""

    state: State
    used: int
    reached: bool


def linearise(
    f: ArrayLike, df_da: ArrayLike, df_dx: ArrayLike, noise: ArrayLike, a: FloatArray
) -> Linearised:
    """Return y, M and W of equations (1) and (2), from f (p,) and its derivatives at (x, a).

    `df_da` is (p, n), `df_dx` (p, m), `noise` is Λ (m, m). Section 2 of the paper prints y with
    (a - a*); the constant part, which is what the filter is given, is -f + M a*.
    """
    # (1)  M = ∂f/∂a
    M = np.asarray(df_da, dtype=np.float64)
    # y = -f(x, a*) + M a*
    y = -np.asarray(f, dtype=np.float64) + M @ a
    # (2)  W = ∂f/∂x Λ ∂f/∂xᵀ
    G = np.asarray(df_dx, dtype=np.float64)
    W = G @ np.asarray(noise, dtype=np.float64) @ G.T
    return Linearised(y, M, W)


def step(state: State, measured: Linearised) -> State:
    """Return the state after one measurement, equations (3) to (5).

    filterpy takes S in Joseph's form, which is (5) for the gain of (3) and, unlike (5) as printed,
    stays symmetric and positive when rounding spoils the gain.

    >>> prior = State(np.zeros(1), np.eye(1))
    >>> after = step(prior, Linearised(np.array([2.0]), np.eye(1), np.eye(1)))
    >>> after.mean.tolist(), after.cov.tolist()
    ([1.0], [[0.5]])
    """
    # Not at the top: it loads parts of scipy that take longer than a small set of views.
    from filterpy.kalman import ExtendedKalmanFilter
    from scipy.linalg import LinAlgWarning

    M = measured.M
    ekf = ExtendedKalmanFilter(dim_x=state.mean.size, dim_z=measured.y.size)
    ekf.x, ekf.P = state.mean.copy(), state.cov.copy()
    # The implicit f(x, a) = 0 in filterpy's explicit form: z = y, h(a) = M a, R = W.
    with warnings.catch_warnings():
        # Joseph's form is right for whatever gain rounding leaves.
        warnings.simplefilter("ignore", LinAlgWarning)
        ekf.update(measured.y, HJacobian=lambda _: M, Hx=lambda a: M @ a, R=measured.W)
    return State(ekf.x, (ekf.P + ekf.P.T) / 2)


def step_all(
    a: FloatArray, S: FloatArray, y: FloatArray, M: FloatArray, W: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return `step` for N states at once: estimates (N, n) and covariances (N, n, n) after a
    measurement of each: y (N, p), M (N, p, n), W (N, p, p).
    """
    Mt = M.swapaxes(-1, -2)
    # (3)  K = S Mᵀ (W + M S Mᵀ)⁻¹
    K = np.linalg.solve(W + M @ S @ Mt, M @ S).swapaxes(-1, -2)
    # (4)  a = a + K (y - M a)
    innovation = y - (M @ a[..., None])[..., 0]
    a_next = a + (K @ innovation[..., None])[..., 0]
    # (5)  S = (I - K M) S, as (I - K M) S (I - K M)ᵀ + K W Kᵀ
    keep = np.eye(a.shape[-1]) - K @ M
    S_next = keep @ S @ keep.swapaxes(-1, -2) + K @ W @ K.swapaxes(-1, -2)
    return a_next, (S_next + S_next.swapaxes(-1, -2)) / 2


def innovation_chi2(state: State, measured: Linearised) -> float:
    """Return squared Mahalanobis length of y - M a under W + M S Mᵀ: chi-square with p degrees."""
    innovation = measured.y - measured.M @ state.mean
    spread = measured.W + measured.M @ state.cov @ measured.M.T
    return float(innovation @ np.linalg.solve(spread, innovation))


def largest_sd(cov: ArrayLike) -> float:
    """Return the standard deviation in the least certain direction; the same in every frame."""
    return float(np.sqrt(max(np.linalg.eigvalsh(np.asarray(cov, dtype=np.float64))[-1], 0.0)))


def recursion(start: State, measurements: Iterable[Measurement]) -> Iterator[State]:
    """Return the states after each measurement, each linearised at the state before it."""
    state = start
    for measurement in measurements:
        state = step(state, measurement(state.mean))
        yield state


def run(start: State, measurements: Iterable[Measurement], sd_limit: float | None = None) -> Run:
    """Return the end of the recursion: the first state within `sd_limit`, or the last measurement.

    The paper stops when S is "below a predefined threshold"; here that is the largest standard
    deviation (in the unit of a), which no turn of the frame changes. Measurements after the stop
    are not drawn from the iterable, so it may be a robot that still has to take them.
    """
    if sd_limit is not None and not sd_limit > 0:
        raise ValueError(f"the limit of the standard deviation must be positive, not {sd_limit}")
    state, used = start, 0
    for state in recursion(start, measurements):
        used += 1
        if sd_limit is not None and largest_sd(state.cov) <= sd_limit:
            return Run(state, used, reached=True)
    return Run(state, used, reached=False)
