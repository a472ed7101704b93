"""Features matched between pairs of views and linked to chains."""

from facetlog.perception.detection.line_front_end.points_3d.texture_features import (
    TextureFeatures,
    common_direction,
    texture_features,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import (
    MIN_TRACK,
    feature_tracks,
)
from tests.perception.detection.line_front_end.printed_disc import (
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
