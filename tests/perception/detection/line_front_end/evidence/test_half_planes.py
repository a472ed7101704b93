"""On which side of a 3-D segment is a plane a surface, and seen from where?"""

import numpy as np

from facetlog.perception.detection.line_front_end.evidence.half_planes import surface_beside
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

UP = np.array([0.0, 0.0, 1.0])


def photos(rig: Rig) -> PhotometricViews:
    return PhotometricViews(rig.views, GreyLevels(rig.views, rig.maps), np.ones(len(rig.views)))


def sides_of(ring: FloatArray) -> FloatArray:
    return np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)


def test_the_plane_of_a_face_is_surface_beside_its_sides_as_views_before_it_see_it() -> None:
    rig = block_rig()
    top, normal = rig.top
    before, behind = surface_beside(photos(rig), normal, sides_of(top), rig.pixel)
    assert before.all()
    assert not behind.any()
    turned = surface_beside(photos(rig), -normal, sides_of(top), rig.pixel)
    np.testing.assert_array_equal(turned, [behind, before])


def test_a_plane_in_the_air_is_no_surface() -> None:
    rig = block_rig()
    top, normal = rig.top
    in_the_air = sides_of(top + 3.0 * UP)
    assert not surface_beside(photos(rig), normal, in_the_air, rig.pixel).any()
