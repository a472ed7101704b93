"""Whether the pictures show one surface at a point, and by how much one is brighter."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.evidence.beside_segments import exposures
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import (
    BLOCK,
    GreyLevels,
    Levels,
    agreement,
)
from facetlog.perception.types import FloatArray, View
from tests.perception.detection.drawings import flat, project, view, with_noise
from tests.perception.detection.line_front_end.block_rig import block_rig


def levels(grey: FloatArray, *, sd: float = 3.0, chance: float = 1 / 256) -> Levels:
    """Levels (V, n) of one sd, all equally likely by chance."""
    return Levels(
        grey.astype(np.float32),
        np.full(grey.shape, sd, np.float32),
        np.full(grey.shape, chance, np.float32),
    )


def test_views_that_agree_speak_for_a_surface_and_views_that_do_not_against_it() -> None:
    rng = np.random.default_rng(0)
    same = 120.0 + rng.normal(0, 3.0, (12, 50))
    apart = rng.uniform(0, 255, (12, 50))
    weight = np.ones(12)
    assert agreement(levels(same), weight).ratio.min() > 10
    assert agreement(levels(apart), weight).ratio.max() < 0


@pytest.mark.parametrize("count", [1, BLOCK + 1])
def test_many_points_say_what_each_says_alone(count: int) -> None:
    rng = np.random.default_rng(2)
    grey = rng.choice([100.0, 110.0, 180.0], (6, count)) + rng.normal(0, 2.0, (6, count))
    found = agreement(levels(grey), np.ones(6))
    for k in (0, count - 1):
        alone = agreement(levels(grey[:, k : k + 1]), np.ones(6))
        np.testing.assert_allclose(found.ratio[k], alone.ratio[0], rtol=1e-5)
        np.testing.assert_array_equal(found.agrees[:, k], alone.agrees[:, 0])


def test_views_almost_alike_count_as_one() -> None:
    grey = np.full((6, 1), 100.0)
    once = agreement(levels(grey[:2]), np.ones(2)).ratio
    again = agreement(levels(grey), np.full(6, 1 / 3)).ratio
    np.testing.assert_allclose(once, again, rtol=1e-5)


def test_levels_are_freed_of_the_exposure_and_as_likely() -> None:
    bright, dark = view(flat(120.0)), view(flat(60.0))
    reader = GreyLevels(
        [bright, dark], [edge_map(v.image) for v in (bright, dark)], np.array([1.5, 0.75])
    )
    read = reader.read(np.array([0, 1]), np.full((2, 2, 1), 5.0), np.ones((2, 1), np.bool_))
    np.testing.assert_allclose(read.level, 80.0)
    plain = GreyLevels([bright], [edge_map(bright.image)])
    alone = plain.read(np.array([0]), np.full((2, 1, 1), 5.0), np.ones((1, 1), np.bool_))
    np.testing.assert_allclose(
        read.chance[0] * read.sd[0], alone.chance[0] * alone.sd[0], rtol=1e-5
    )


def test_points_of_a_face_agree_and_points_before_it_do_not() -> None:
    rig = block_rig()
    reader = GreyLevels(rig.views, rig.maps)
    rng = np.random.default_rng(0)
    top = max(rig.solid.faces, key=lambda f: float(rig.points[list(f), 2].mean()))
    a, b, _, d = rig.points[list(top)]
    on_it = a + rng.uniform(0.1, 0.9, (40, 2)) @ np.stack([b - a, d - a])
    everyone = np.arange(len(rig.views))
    seen = np.ones((len(everyone), 40), np.bool_)

    def ratio(points: FloatArray) -> FloatArray:
        uv = np.stack([project(v, points).T for v in rig.views], axis=1)
        return agreement(reader.read(everyone, uv, seen), np.ones(len(everyone))).ratio

    assert np.median(ratio(on_it)) > 10
    assert np.median(ratio(on_it + np.array([0.0, 0.0, 5.0]))) < 3


def test_noise_that_would_hide_what_is_alike_is_averaged_away() -> None:
    uv = np.stack(np.meshgrid(np.arange(10.0, 70.0), np.arange(10.0, 50.0)))[:, None]
    seen = np.ones(uv.shape[1:], np.bool_)
    for noise, left in ((4.0, 4.0), (15.0, 5.1), (30.0, 8.5)):
        pictures = [view(with_noise(flat(), noise))]
        found = GreyLevels(pictures, [edge_map(pictures[0].image)])
        read = found.read(np.array([0]), uv, seen)
        assert read.level.std() == pytest.approx(left, rel=0.15)
        assert np.median(read.sd) == pytest.approx(read.level.std(), rel=0.4)


def dimmed(view: View, by: float) -> View:
    return replace(view, image=np.rint(by * view.image).astype(np.uint8))


def test_a_picture_that_was_exposed_for_less_time_is_darker_by_as_much() -> None:
    rig = block_rig()
    views = [dimmed(rig.views[0], 0.6), *rig.views[1:4], dimmed(rig.views[4], 0.8), *rig.views[5:]]
    found = exposures(rig.edges, rig.shown_edges.astype(np.bool_), views)
    assert found[0] == pytest.approx(0.6, rel=0.03)
    assert found[4] == pytest.approx(0.8, rel=0.03)
    np.testing.assert_allclose(np.delete(found, [0, 4]), 1.0, rtol=0.03)
