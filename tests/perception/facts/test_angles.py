"""Angles between planes and their standard deviation, against Monte Carlo."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.facts.relations import compute_angle_between, compute_pairwise_angles
from facetlog.perception.scene import Plane
from tests.perception.rigs import rotation


def _plane(normal, first, second):
    """A plane whose normal tilts by sd `first` and `second` (rad) about two axes across it."""
    n = np.asarray(normal, dtype=float)
    n = n / np.linalg.norm(n)
    e1, e2 = np.linalg.svd(n[None])[2][1:]
    cov = np.zeros((4, 4))
    cov[:3, :3] = first**2 * np.outer(e1, e1) + second**2 * np.outer(e2, e2)
    return Plane(n, 0.0, cov)


def _turned(angle):
    return [np.sin(angle), 0.0, np.cos(angle)]


def _sampled_angles(rng, p, q, count=40_000):
    sides = []
    for plane in (p, q):
        w, V = np.linalg.eigh(plane.cov[:3, :3])
        tilt = rng.normal(size=(count, 3)) * np.sqrt(np.maximum(w, 0)) @ V.T
        sides.append(plane.normal + tilt)
    n, m = (s / np.linalg.norm(s, axis=1, keepdims=True) for s in sides)
    return np.arctan2(np.linalg.norm(np.cross(n, m), axis=1), (n * m).sum(axis=1))


@pytest.mark.parametrize("angle_deg", [0.0, 0.5, 2.0, 5.0, 20.0, 60.0, 90.0, 140.0, 178.0, 180.0])
@pytest.mark.parametrize(("first", "second"), [(0.02, 0.02), (0.05, 0.005), (0.005, 0.05)])
def test_sd_is_the_rms_error_that_monte_carlo_finds(angle_deg, first, second):
    true = np.radians(angle_deg)
    p, q = _plane([0.0, 0.0, 1.0], first, second), _plane(_turned(true), second, first)
    angle, sd = compute_angle_between(p, q)
    assert angle == pytest.approx(true, abs=1e-9)
    rms = np.sqrt(((_sampled_angles(np.random.default_rng(1), p, q) - true) ** 2).mean())
    # Near 0° and 180° the form may be up to a fifth on the safe side; elsewhere it is exact.
    assert 0.97 * rms <= sd <= (1.22 if min(angle_deg, 180 - angle_deg) < 10 else 1.03) * rms


@given(st.integers(0, 2**32 - 1))
def test_all_pairs_equal_one_by_one_in_every_frame(seed):
    rng = np.random.default_rng(seed)
    planes = [_plane(rng.normal(size=3), *rng.uniform(0.001, 0.1, 2)) for _ in range(4)]
    planes.append(planes[0].flipped())
    R = np.eye(4)
    R[:3, :3] = rotation(rng)
    there = [Plane(R[:3, :3] @ p.normal, p.offset, R @ p.cov @ R.T) for p in planes]
    angle, sd = compute_pairwise_angles(planes)
    np.testing.assert_allclose(angle, angle.T)
    np.testing.assert_allclose(compute_pairwise_angles(there)[0], angle, atol=1e-7)
    np.testing.assert_allclose(compute_pairwise_angles(there)[1], sd, rtol=1e-6)
    for i, j in ((0, 1), (2, 3), (0, 4)):
        np.testing.assert_allclose(
            (angle[i, j], sd[i, j]), compute_angle_between(planes[i], planes[j]), atol=1e-9
        )
    assert (np.diag(angle) == 0).all()
    assert (np.diag(sd) == 0).all()
