"""Views and the 3-D segments that they show, found and fitted together at intermediate poses."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.coarse_pictures import coarse_pictures
from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import shown_lines
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    explained_share,
)
from facetlog.perception.detection.picture_noise import Noise, working_noise
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.estimation.pose_refinement.line_alignment import DriftingViews, align
from facetlog.perception.estimation.pose_refinement.pose_chain import PoseChain, SinglePoses
from facetlog.perception.types import FloatArray, View

__all__ = ["Lines", "drifting_views", "fitted", "lines_of", "smaller"]


class Lines(NamedTuple):
    """3-D segments (n, 2, 3), which view shows which (n, V), and the share that they explain."""

    segments: FloatArray
    use: NDArray[np.bool_]
    explained: float


def drifting_views(
    views: Sequence[View],
    chain: PoseChain | SinglePoses,
    reach_px: float | None = None,
    noises: Sequence[Noise] | None = None,
) -> DriftingViews:
    """The views with their edges and segments; `reach_px`, `noises` as of `edge_map`."""
    maps, segments = [], []
    for view, noise in zip(views, noises or (working_noise(v.image) for v in views), strict=True):
        coarser = coarse_pictures(view.image, noise)
        maps.append(edge_map(view.image, reach_px, noise, coarser))
        segments.append(detect_segments(view.image, noise, coarser))
    return DriftingViews(tuple(views), tuple(maps), tuple(segments), chain)


def smaller(drifting: DriftingViews, share: float, reach_px: float | None = None) -> DriftingViews:
    """The same in pictures shrunk to this share of their sides."""
    views = [_shrunk(view, share) for view in drifting.views]
    return drifting_views(views, drifting.chain, reach_px)


def fitted(
    drifting: DriftingViews, twists: FloatArray, searches_px: Sequence[float]
) -> tuple[FloatArray, FloatArray]:
    """Twists and segments after a joint fit of all views that have a twist."""
    here = drifting.first(len(twists))
    lines = lines_of(here, twists)
    segments = lines.segments
    for search_px in searches_px:
        twists, segments = align(here, twists, segments, lines.use, search_px)
    return twists, segments


def lines_of(drifting: DriftingViews, twists: FloatArray) -> Lines:
    """The 3-D segments of the views at these twists (V, 6)."""
    views = drifting.at(range(len(drifting.views)), twists)
    cloud, use = shown_lines(views, drifting.maps, drifting.segments)
    share = explained_share(cloud.segments, use, views, drifting.segments)
    return Lines(cloud.segments, use, share)


def _shrunk(view: View, share: float) -> View:
    height, width = (round(share * side) for side in view.image.shape)
    image = cv2.resize(view.image, (width, height), interpolation=cv2.INTER_AREA)
    camera = view.camera.resized(width, height)
    return View(view.name, np.asarray(image, dtype=np.uint8), camera, view.pose)
