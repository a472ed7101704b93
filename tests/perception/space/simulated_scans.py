"""Scans of an exact scene that stands on a floor, from one place."""

from dataclasses import replace

import numpy as np
import shapely

from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.scene import Body, Scene, SightLines
from facetlog.perception.surfaces.exact_solids.polyhedra import seen_from
from facetlog.perception.types import FloatArray

__all__ = ["eye_at", "one_body", "scanned"]

# Rays across the thing seen, and how far beyond it they go, in its own size.
ACROSS = 90
BEYOND = 1.5


def one_body(scene: Scene, *, whole: bool) -> Scene:
    """The scene as one body, whose surface is known from all sides or not."""
    faces, edges = tuple(range(len(scene.faces))), tuple(range(len(scene.edges)))
    return replace(scene, bodies=(Body(faces, edges, (), whole=whole),))


def eye_at(scene: Scene, azimuth_deg: float, height_deg: float, away: float = 2.0) -> FloatArray:
    """A place (3,) so many sizes of the scene from its middle, in this direction."""
    around, over = np.deg2rad([azimuth_deg, height_deg])
    way = np.array([np.cos(over) * np.cos(around), np.cos(over) * np.sin(around), np.sin(over)])
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    eye: FloatArray = scene.points.mean(axis=0) + away * size * way
    return eye


def scanned(scene: Scene, eye: FloatArray) -> Scene:
    """Return what `eye` (3,) sees of the scene as one body, with lines of sight to it and floor."""
    seen = one_body(seen_from(scene, eye), whole=False)
    rays = _rays(scene, eye)
    away = np.full(len(rays), np.inf)
    for face in SceneMemo.of(scene).table.faces:
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (face.middle - eye) @ face.normal / (rays @ face.normal)
        met = np.flatnonzero((reach > 0.0) & (reach < away))
        flat = face.flatten(eye + reach[met, None] * rays[met])
        met = met[shapely.contains_xy(face.polygon, *flat.T)]
        away[met] = reach[met]
    with np.errstate(divide="ignore"):
        floor = (scene.points[:, 2].min() - eye[2]) / rays[:, 2]
    away = np.minimum(away, np.where(floor > 0.0, floor, np.inf))
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    ends = np.isfinite(away) & (away < 10.0 * size)
    return replace(seen, sights=(SightLines(eye, eye + away[ends, None] * rays[ends]),))


def _rays(scene: Scene, eye: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) from `eye` all over the scene and around it."""
    middle = scene.points.mean(axis=0)
    forward = (middle - eye) / np.linalg.norm(middle - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    size = BEYOND * float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    step = np.linspace(-size / 2.0, size / 2.0, round(ACROSS * BEYOND))
    across, down = (each.ravel()[:, None] for each in np.meshgrid(step, step))
    rays = middle + across * right + down * np.cross(right, forward) - eye
    unit: FloatArray = rays / np.linalg.norm(rays, axis=1)[:, None]
    return unit
