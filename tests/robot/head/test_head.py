import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.errors import InputError
from facetlog.robot.head.canon import (
    COUNTS_PER_DEGREE,
    REACH,
    angles_to_counts,
    counts_to_angles,
)
from facetlog.robot.head.canon_vcc4 import CanonVcC4
from facetlog.robot.head.open_head import HEAD_KINDS, open_head
from facetlog.robot.head.sony_evi_d30 import SonyEviD30
from facetlog.robot.head.sony_models import EVI_D30, EVI_D70, EVI_D100, SONY_MODELS, SonyModel
from tests.robot.head.simulated import Silence, SimulatedLine

sony_models = st.sampled_from(list(SONY_MODELS.values()))
shares = st.floats(0, 1)


@pytest.mark.parametrize(
    ("model", "pan_counts", "tilt_counts", "pan_deg", "tilt_deg"),
    [
        # Right and up are positive counts; left is a positive pan of ours.
        (EVI_D30, 0x370, 0x12C, -100, 25),
        (EVI_D30, 88, -120, -10, -10),
        (EVI_D100, -0x5A0, 0x168, 100, 25),
        (EVI_D70, 0x4B0, 0x4B0, -90, 90),
        (EVI_D70, 0x85, -0x85, -10, -10),
    ],
)
def test_sony_counts_are_degrees_as_the_maker_says(
    model: SonyModel, pan_counts: int, tilt_counts: int, pan_deg: float, tilt_deg: float
) -> None:
    pan, tilt = model.angles(pan_counts, tilt_counts)
    # To half a count: the maker rounds, too.
    assert math.degrees(pan) == pytest.approx(pan_deg, abs=0.5 / model.pan_per_degree)
    assert math.degrees(tilt) == pytest.approx(tilt_deg, abs=0.5 / model.tilt_per_degree)
    assert model.counts(math.radians(pan_deg), math.radians(tilt_deg)) == (pan_counts, tilt_counts)


@given(sony_models, shares, shares)
def test_angles_are_sent_to_a_sony_head_to_half_a_count(
    model: SonyModel, pan_share: float, tilt_share: float
) -> None:
    limits = model.limits
    pan = limits.pan_min + pan_share * (limits.pan_max - limits.pan_min)
    tilt = limits.tilt_min + tilt_share * (limits.tilt_max - limits.tilt_min)
    counts = model.counts(pan, tilt)
    again = model.angles(*counts)
    assert abs(again[0] - pan) <= limits.pan_step / 2 * (1 + 1e-9)
    assert abs(again[1] - tilt) <= limits.tilt_step / 2 * (1 + 1e-9)
    assert abs(counts[0]) <= model.pan_limit
    assert model.tilt_lowest <= counts[1] <= model.tilt_highest
    assert model.counts(*again) == counts


@pytest.mark.parametrize(
    ("pan_deg", "tilt_deg"),
    [(101, 0), (-100.2, 0), (0, 26), (0, -25.1), (math.nan, 0)],
)
def test_what_a_head_cannot_reach_is_refused(pan_deg: float, tilt_deg: float) -> None:
    with pytest.raises(InputError, match=r"camera head"):
        EVI_D30.limits.check(math.radians(pan_deg), math.radians(tilt_deg))


def test_heads_are_known_by_name() -> None:
    line = SimulatedLine(Silence())
    assert isinstance(open_head("sony-evi-d30", line), SonyEviD30)
    assert isinstance(open_head("canon-vc-c4", line), CanonVcC4)
    assert isinstance(open_head("canon-vc-c4", line, unheard=True), CanonVcC4)
    with pytest.raises(InputError, match="not moved unheard"):
        open_head("sony-evi-d30", line, unheard=True)
    assert HEAD_KINDS == ("sony-evi-d30", "canon-vc-c4")
    with pytest.raises(InputError, match=r"sony-evi-d30, canon-vc-c4"):
        open_head("sony", line)


def test_canon_counts_are_degrees_as_the_maker_says() -> None:
    assert angles_to_counts(math.radians(-90), math.radians(-30)) == (800, -267)
    assert counts_to_angles(800, 0)[0] == pytest.approx(math.radians(-90))


def test_limits_are_in_our_signs() -> None:
    limits = EVI_D70.limits
    assert math.degrees(limits.tilt_min) == pytest.approx(-30)
    assert math.degrees(limits.tilt_max) == pytest.approx(90)
    assert math.degrees(limits.pan_max) == pytest.approx(170, abs=0.1)
    assert math.degrees(REACH.limits.pan_step) == pytest.approx(1 / COUNTS_PER_DEGREE)
