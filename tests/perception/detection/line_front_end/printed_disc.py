"""A disc of texture that fades into grey: a plane without any straight edge, its truth known."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import cv2
import numpy as np

from facetlog.perception.detection.edge_maps import EdgeMap, edge_map
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.points_3d.texture_points import (
    TexturePoints,
    texture_points,
)
from facetlog.perception.detection.view_graph import ViewGraph, view_graph
from facetlog.perception.types import Camera, FloatArray, Image, Pose, View
from facetlog.robot.tour import make_ring_poses

CAMERA = Camera(480, 360, 450.0, 450.0, 239.5, 179.5)
RADIUS, HEIGHT = 5.0, 2.0
SIZE, BLOB = 512, 4.0  # of the drawing, texels, and of what is drawn on it


@dataclass(frozen=True, eq=False)
class PrintedRig:
    """Views of one printed disc, of radius RADIUS, level at HEIGHT."""

    views: tuple[View, ...]

    @cached_property
    def maps(self) -> tuple[EdgeMap, ...]:
        return tuple(edge_map(v.image) for v in self.views)

    @cached_property
    def graph(self) -> ViewGraph:
        return view_graph(self.views)

    @cached_property
    def pixel(self) -> float:
        return self.graph.distance / CAMERA.fx

    @cached_property
    def texture(self) -> TexturePoints:
        return texture_points(self.views, self.maps, self.graph, self.pixel)

    @cached_property
    def photos(self) -> PhotometricViews:
        return PhotometricViews(self.views, GreyLevels(self.views, self.maps), self.graph.weight)


def drawing(seed: int) -> Image:
    """Blobs of all greys in a disc that fades into an even grey."""
    rng = np.random.default_rng(seed)
    noise = cv2.GaussianBlur(rng.normal(size=(SIZE, SIZE)), (0, 0), BLOB)
    y, x = (np.mgrid[:SIZE, :SIZE] + 0.5) * 2 / SIZE - 1
    fade = 1 / (1 + np.exp((np.hypot(x, y) - 0.85) / 0.03))
    return np.clip(120 + 55 * fade * noise / noise.std(), 0, 255).astype(np.uint8)


def picture(pose: Pose, texture: Image, seed: int) -> Image:
    """Render what a camera sees of the disc, with noise of one grey level."""
    u, v = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    rays = np.stack(
        [(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)], axis=-1
    )
    rays = rays @ pose.rotation.T
    share = (HEIGHT - pose.centre[2]) / np.where(rays[..., 2] < 0, rays[..., 2], -1e-9)
    at = ((pose.centre + share[..., None] * rays)[..., :2] / RADIUS + 1) * SIZE / 2 - 0.5
    read = cv2.remap(
        texture, *at.astype(np.float32).transpose(2, 0, 1), cv2.INTER_LINEAR, borderValue=120
    )
    noise = np.random.default_rng(seed).normal(size=read.shape)
    return np.clip(np.rint(read + noise), 0, 255).astype(np.uint8)


def rig_of(poses: Sequence[Pose], seeds: Sequence[int]) -> PrintedRig:
    """Views from these poses, each of a disc with the texture of its own seed."""
    pictures = [
        picture(p, drawing(s), k) for k, (p, s) in enumerate(zip(poses, seeds, strict=True))
    ]
    return PrintedRig(
        tuple(
            View(f"{k}", im, CAMERA, p)
            for k, (im, p) in enumerate(zip(pictures, poses, strict=True))
        )
    )


def ring(views: int, arc_deg: float) -> list[Pose]:
    """Poses on an arc round the disc, looking down at it."""
    around = round(views * 360.0 / arc_deg)
    return list(make_ring_poses([0.0, 0.0, HEIGHT], 16.0, (10.0, 12.0), around)[:views])


@cache
def printed_rig(views: int = 8, arc_deg: float = 90.0) -> PrintedRig:
    """One disc, seen from an arc."""
    return rig_of(ring(views, arc_deg), [0] * views)


def true_height(points: FloatArray) -> FloatArray:
    """How far points (n, 3) are from the disc's plane."""
    return np.abs(points[:, 2] - HEIGHT)
