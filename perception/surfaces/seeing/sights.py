"""Sights of each view: how much of every face it saw, hidden by which, and how far it looked.

A line of sight ends where a picture agrees with the others on a face that nothing hides
(seen_faces.py), on the ground (seen_ground.py), and on the edges that a view shows, of whatever
they are. What was seen from somewhere has nothing before it; a later step decides from that which
space is free.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from facetlog.perception.detection.coarse_pictures import gradient
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.tracked_faces import Landmarks
from facetlog.perception.scene import Scene, SightLines
from facetlog.perception.surfaces.seeing.false_edges import drop_false_edges
from facetlog.perception.surfaces.seeing.seen_faces import (
    Eye,
    Look,
    choose_points_without_ends,
    make_surfaces,
)
from facetlog.perception.surfaces.seeing.seen_ground import seen_ground
from facetlog.perception.types import FloatArray, View

__all__ = ["add_sights"]


def add_sights(
    scene: Scene,
    views: Sequence[View],
    weight: Sequence[float],
    ground: tuple[FloatArray, float] | None,
    landmarks: Landmarks | None = None,
) -> Scene:
    """Return the scene with what each of its views saw of the faces, and with its lines of sight;
    without loose edges that are none, or are no bar's (false_edges.py).

    `views` are those of the scene, at the poses at which it was found, each with its `weight`
    beside views almost like it. `ground` and `landmarks` as in `TrackedFaces`.
    """
    surfaces = make_surfaces(scene)
    levels = GreyLevels(views, [gradient(view.image) for view in views])
    photos = PhotometricViews(views, levels, np.array(weight))
    observed: list[list[FloatArray]] = [[] for _ in views]
    for vertex in scene.vertices:
        for observation in vertex.observations:
            observed[observation.view].append(vertex.point)
    looks = [Look.at(surface, len(views)) for surface in surfaces]
    corners, beside = [], []
    for k, view in enumerate(views):
        # An eye holds a picture of each face: one at a time.
        eye = Eye(view, surfaces)
        for number, look in enumerate(looks):
            look.through(k, eye, number)
        own = np.reshape(observed[k], (-1, 3))
        corners.append(own[eye.in_sight(own)])
        others = np.zeros((0, 3)) if landmarks is None else landmarks.points[landmarks.seen[:, k]]
        beside.append(others[eye.in_sight(others)])
    shown = [look.shown(photos) for look in looks]
    faces = tuple(look.face(own) for look, own in zip(looks, shown, strict=True))
    of_faces = [s.seen(photos.centres, own) for s, own in zip(surfaces, shown, strict=True)]
    lattices = tuple(seen for seen in of_faces if seen is not None)
    if ground is not None:
        rings = [surface.rings for surface in surfaces]
        lattices += seen_ground(views, levels, photos.weight, rings, ground, scene.up)
    on_lattices = [lines for seen in lattices for lines in seen.lines]
    sights = []
    for k, view in enumerate(views):
        met = (lines.ends for lines in on_lattices if lines.view == k)
        known = np.concatenate([corners[k], *met])
        ends = np.concatenate([corners[k], choose_points_without_ends(view, known, beside[k])])
        if len(ends):
            sights.append(SightLines(view.pose.centre, ends, k))
    found = replace(scene, faces=faces, sights=tuple(sights), lattices=lattices)
    return drop_false_edges(found)
