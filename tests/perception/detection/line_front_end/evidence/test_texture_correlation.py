"""Whether pictures show the same texture at places of a plane."""

import numpy as np

from facetlog.perception.detection.line_front_end.evidence.texture_correlation import (
    MIN_CORRELATION,
    surface_between,
    texture_correlation,
)
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.printed_disc import (
    HEIGHT,
    RADIUS,
    PrintedRig,
    printed_rig,
    rig_of,
    ring,
)

UP = np.array([0.0, 0.0, 1.0])


def inside(count: int, height: float = HEIGHT) -> FloatArray:
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)) * RADIUS, np.full(count, height)])


def likeness(rig: PrintedRig, points: FloatArray) -> FloatArray:
    return texture_correlation(rig.views, np.arange(len(rig.views)), points, UP, rig.pixel)


def test_texture_correlates_on_its_plane() -> None:
    assert (likeness(printed_rig(), inside(40)) > 0.8).all()


def test_different_textures_do_not_correlate() -> None:
    rig = rig_of(ring(6, 60.0), range(6))
    assert (likeness(rig, inside(40)) < MIN_CORRELATION).all()


def test_texture_is_surface_as_seen_from_above_only() -> None:
    rig = printed_rig()
    front, back = surface_between(rig.photos, rig.views, rig.pixel, UP, inside(40))
    assert front.mean() > 0.9
    assert not back.any()
