"""How far lines reach: profiles made by hand, and those of a rendered block."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    MARGIN,
    SAMPLES,
    LineProfiles,
    covered_extents,
    line_profiles,
)
from tests.perception.detection.line_front_end.block_rig import block_rig

LINE = np.array([0])
PLACE = st.floats(-1.5, 2.5)


def profile(covered) -> LineProfiles:
    """One line along x of length 1, its coverage given at the samples from -1 to 2."""
    cumulated = np.concatenate([[0.0], np.cumsum(covered)])[None]
    step = np.array([3.0 / SAMPLES])
    return LineProfiles(np.zeros((1, 3)), np.eye(3)[:1], np.array([-1.0]), step, cumulated)


def mean(profiles: LineProfiles, start: float, end: float) -> float:
    return float(profiles.mean(LINE, np.array([start]), np.array([end]))[0])


@given(st.integers(0, 1000), PLACE, PLACE, PLACE)
def test_parts_add_up_whichever_way_they_run(seed: int, a: float, b: float, c: float) -> None:
    profiles = profile(np.random.default_rng(seed).uniform(size=SAMPLES))
    a, b, c = sorted((a, b, c))
    whole = mean(profiles, c, a) * (c - a)
    assert whole == pytest.approx(
        mean(profiles, a, b) * (b - a) + mean(profiles, b, c) * (c - b), abs=1e-9
    )
    assert 0.0 <= mean(profiles, a, c) <= 1.0


def test_the_edges_of_a_block_are_covered_to_their_ends_and_not_beyond() -> None:
    rig = block_rig()
    profiles = line_profiles(
        rig.edges, rig.views, rig.maps, rig.shown_edges, np.ones(len(rig.views))
    )
    lines = np.arange(len(rig.edges))
    length = np.linalg.norm(rig.edges[:, 1] - rig.edges[:, 0], axis=1)
    zero = np.zeros(len(lines))
    assert profiles.mean(lines, zero, length).min() > 0.9
    margin = 0.1 * length
    for start, end in ((-MARGIN * length, -margin), (length + margin, (1 + MARGIN) * length)):
        assert profiles.mean(lines, start, end).max() < 0.35
    np.testing.assert_allclose(
        profiles.origin + length[:, None] * profiles.direction, rig.edges[:, 1], atol=1e-9
    )


def test_where_half_of_the_views_see_a_line_rounding_does_not_end_it() -> None:
    # Three of six views, all of one weight, cover it half: to the last digit or not.
    segment = np.array([[[0.25, 0.0, 0.0], [0.75, 0.0, 0.0]]])
    half = [covered_extents(segment, profile(np.full(SAMPLES, c))) for c in (0.5, 0.5 - 1e-12)]
    np.testing.assert_allclose(half[0], half[1], atol=1e-9)
    assert np.ptp(half[0][0, :, 0]) > 1.0
