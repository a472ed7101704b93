"""Texture features of one picture."""

from dataclasses import replace

import numpy as np

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.points_3d.texture_features import (
    MAX_CORNERS,
    TextureFeatures,
    common_direction,
    texture_features,
)
from facetlog.perception.types import View
from tests.perception.detection.line_front_end.printed_disc import PrintedRig, printed_rig


def features(rig: PrintedRig, view: View) -> TextureFeatures:
    direction = common_direction(rig.views)
    return texture_features(view, edge_map(view.image), direction, rig.graph.focus, rig.pixel)


def test_texture_has_corners_with_patches_of_mean_zero_and_length_one() -> None:
    rig = printed_rig()
    found = features(rig, rig.views[0])
    assert 100 < len(found.uv) <= MAX_CORNERS
    np.testing.assert_allclose(found.patches.mean(axis=1), 0, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(found.patches, axis=1), 1, atol=1e-4)


def test_neither_an_even_picture_nor_its_noise_has_corners() -> None:
    rig = printed_rig()
    view = rig.views[0]
    noise = np.random.default_rng(0).normal(0, 5, view.image.shape)
    for image in (np.full_like(view.image, 90), np.rint(90 + noise).astype(np.uint8)):
        assert not len(features(rig, replace(view, image=image)).uv)
