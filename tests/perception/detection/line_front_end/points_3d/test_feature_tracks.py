"""Features matched between pairs of views and linked to chains."""

import numpy as np

from facetlog.perception.detection.line_front_end.points_3d.feature_tracks import (
    MIN_TRACK,
    feature_tracks,
    matched_features,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_features import (
    TextureFeatures,
    common_direction,
    texture_features,
)
from facetlog.perception.types import FloatArray, View
from tests.perception.detection.line_front_end.printed_disc import (
    HEIGHT,
    PrintedRig,
    printed_rig,
    rig_of,
    ring,
)


def features(rig: PrintedRig) -> dict[int, TextureFeatures]:
    direction = common_direction(rig.views)
    return {
        k: texture_features(view, edges, direction, rig.graph.focus, rig.pixel)
        for k, (view, edges) in enumerate(zip(rig.views, rig.maps, strict=True))
    }


def on_disc(view: View, uv: FloatArray) -> FloatArray:
    """Where rays through pixels (n, 2) meet the disc's plane."""
    rays = np.column_stack([uv, np.ones(len(uv))]) @ np.linalg.inv(view.projection[:, :3]).T
    share = (HEIGHT - view.pose.centre[2]) / rays[:, 2]
    return view.pose.centre + share[:, None] * rays


def test_most_matches_show_the_same_point() -> None:
    rig = printed_rig()
    found = features(rig)
    one, other = rig.views[0], rig.views[1]
    pairs = matched_features(found[0], found[1], one, other)
    assert len(pairs) > 50
    apart = on_disc(one, found[0].uv[pairs[:, 0]]) - on_disc(other, found[1].uv[pairs[:, 1]])
    assert (np.linalg.norm(apart, axis=1) < 3 * rig.pixel).mean() > 0.9


def test_a_feature_is_matched_once() -> None:
    rig = printed_rig()
    found = features(rig)
    pairs = matched_features(found[0], found[1], rig.views[0], rig.views[1])
    for column in pairs.T:
        assert len(np.unique(column)) == len(column)


def test_chains_have_one_feature_of_three_views_and_more() -> None:
    rig = printed_rig()
    uv, seen = feature_tracks(features(rig), rig.views, rig.graph.pairs)
    assert len(uv) > 50
    assert (seen.sum(axis=1) >= MIN_TRACK).all()
    assert uv.shape == (*seen.shape, 2)


def test_pictures_of_different_textures_have_hardly_any_feature_track() -> None:
    rig = rig_of(ring(6, 60.0), range(6))
    uv, _ = feature_tracks(features(rig), rig.views, rig.graph.pairs)
    same, _ = feature_tracks(features(printed_rig()), printed_rig().views, rig.graph.pairs)
    assert len(uv) < 0.1 * len(same)


def test_no_features_make_no_chains() -> None:
    rig = printed_rig()
    none = TextureFeatures(np.zeros((0, 2)), np.zeros((0, 64), np.float32))
    uv, seen = feature_tracks(
        dict.fromkeys(range(len(rig.views)), none), rig.views, rig.graph.pairs
    )
    assert uv.shape == (0, len(rig.views), 2)
    assert seen.shape == (0, len(rig.views))
