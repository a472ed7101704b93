"""Ground is cut off an outline, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.holes_and_spurs import remove_spurs
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

UP = np.array([0.0, 0.0, 1.0])
# How far the block reaches along the side that is looked at, and how high it is, inches.
LENGTH, HEIGHT = 10.0, 6.0


def long_side(rig: Rig) -> tuple[FloatArray, FloatArray]:
    """Corners and normal of an upright side that is 10 inches long."""
    sides = [rig.outward(loop) for loop in rig.solid.faces]
    corners, normal = next(
        (c, n) for c, n in sides if abs(n @ UP) < 0.1 and np.ptp(c @ np.cross(UP, n)) > 9.0
    )
    return corners, normal


def ring_on(rig: Rig, flat: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A ring (k, 3) on the long side's plane from inches along it and up, its axes, its normal."""
    corners, normal = long_side(rig)
    axes = make_plane_axes(normal, np.cross(UP, normal))
    start = corners[np.lexsort((corners @ axes[0], np.rint(corners @ UP)))[0]]
    return start + flat @ axes, axes, normal


def cut(rig: Rig, flat: FloatArray) -> FloatArray:
    """Return what is left of the ring, again in inches along and up."""
    ring, axes, normal = ring_on(rig, flat)
    weight, centres = np.ones(len(rig.views)), np.array([v.pose.centre for v in rig.views])
    photos = PhotometricViews(rig.views, GreyLevels(rig.views, rig.maps), weight)
    ground = Ground(UP, 0.0, 4 * rig.pixel, centres, 30.0)
    shown = np.zeros(len(rig.views), np.bool_)
    shown[photos.facing(ring.mean(axis=0), normal)] = True
    left = remove_spurs(ring, normal, shown, rig.untaken, photos, ground, rig.pixel)
    start = ring[0] - flat[0] @ axes
    return np.asarray((left - start) @ axes.T)


def in_shadow(rig: Rig) -> Rig:
    """Return the views with dark ground where the long side would go on."""
    _, axes, normal = ring_on(rig, np.zeros((1, 2)))
    views = []
    for view in rig.views:
        height, width = view.image.shape
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(view.projection[:, :3]).T
        far = -view.pose.centre[2] / np.minimum(rays[..., 2], -1e-6)
        at = view.pose.centre + far[..., None] * rays
        start, _, _ = ring_on(rig, np.zeros((1, 2)))
        along, across = (at - start[0]) @ axes[0], (at - start[0]) @ normal
        ground = view.image == np.bincount(view.image.ravel()).argmax()
        dark = ground & (along > LENGTH) & (along < LENGTH + 6.0) & (np.abs(across) < 6.0)
        views.append(replace(view, image=np.where(dark, 12, view.image).astype(np.uint8)))
    return Rig(rig.solid, tuple(views))


BLOCK = np.array([[0.0, 0.0], [LENGTH, 0.0], [LENGTH, HEIGHT], [0.0, HEIGHT]])
SPUR = np.array(
    [[0.0, 0.0], [LENGTH + 4.0, 0.0], [LENGTH + 4.0, 1.5], [LENGTH, 1.5], [LENGTH, 6.0], [0.0, 6.0]]
)


def test_a_spur_along_a_shadow_on_the_ground_is_cut_off_where_the_side_goes_on_to_the_foot() -> (
    None
):
    left = shapely.Polygon(cut(in_shadow(block_rig()), SPUR))
    assert left.symmetric_difference(shapely.Polygon(BLOCK)).area < 0.01 * left.area


def test_a_part_of_the_face_that_stands_out_is_kept() -> None:
    # The face itself, with a notch: it has two reflex corners, and all of it is there.
    notched = np.array([[0, 0], [10, 0], [10, 6], [6, 6], [6, 3], [4, 3], [4, 6], [0, 6.0]])
    np.testing.assert_allclose(cut(in_shadow(block_rig()), notched), notched, atol=1e-9)


@pytest.mark.parametrize("first", [1, 4])
def test_the_cut_is_the_same_wherever_the_outline_begins(first: int) -> None:
    rig = in_shadow(block_rig())
    one, other = (shapely.Polygon(cut(rig, ring)) for ring in (SPUR, np.roll(SPUR, first, axis=0)))
    assert one.symmetric_difference(other).area < 1e-6 * one.area


def test_an_outline_that_crosses_itself_is_left_as_it_is() -> None:
    crossed = np.array([[0, 0], [10, 6], [10, 0], [0, 6], [5, 4.0]])
    np.testing.assert_allclose(cut(in_shadow(block_rig()), crossed), crossed, atol=1e-9)
