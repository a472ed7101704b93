"""How sure poses are beside the first of them: what was driven before moves all of them alike."""

import math

import numpy as np
import pytest

from facetlog.mapping.visit import compute_relative_covariances
from facetlog.perception.types import FloatArray, Pose

TURN_SD, WAY_SD = 0.01, 0.02


def _way(count: int) -> tuple[list[Pose], FloatArray]:
    """Poses round a place with the covariance of a robot that counts its steps: each is off by its
    own, and by all before it.
    """
    angles = 0.4 * np.arange(count)
    centres = [np.array([3 + math.cos(a), 4 + math.sin(a), 0.7]) for a in angles.tolist()]
    cov, covs = np.zeros((3, 3)), []
    for k, centre in enumerate(centres):
        step = centre - centres[max(k - 1, 0)]
        move = np.array([[1.0, 0.0, -step[1]], [0.0, 1.0, step[0]], [0.0, 0.0, 1.0]])
        cov = move @ cov @ move.T + np.diag([WAY_SD**2, WAY_SD**2, TURN_SD**2])
        whole = np.zeros((6, 6))
        rows = [0, 1, 5]
        whole[np.ix_(rows, rows)] = cov
        covs.append(whole)
    return [Pose(np.eye(3), centre) for centre in centres], np.array(covs)


def test_the_later_half_of_a_way_is_as_sure_as_if_it_had_begun_there() -> None:
    poses, covs = _way(9)
    later = compute_relative_covariances(poses[4:], covs[4:])
    again = compute_relative_covariances(poses[:5], covs[:5])
    assert np.trace(covs[8, :3, :3]) > 1.5 * np.trace(later[4, :3, :3])
    assert np.trace(later[4]) == pytest.approx(np.trace(again[4]), rel=0.05)


def test_the_first_pose_is_off_by_its_head_alone() -> None:
    poses, covs = _way(5)
    first = compute_relative_covariances(poses[3:], covs[3:])[0]
    assert math.degrees(math.sqrt(first[5, 5])) == pytest.approx(0.25, rel=1e-6)
    assert math.sqrt(first[0, 0]) < 0.01


def test_after_odometry_began_anew_both_errors_count() -> None:
    poses, covs = _way(4)
    restarted = covs.copy()
    restarted[2:] = covs[:2]
    found = compute_relative_covariances(poses, restarted)
    assert np.trace(found[2]) > np.trace(found[0]) + np.trace(restarted[2])
