"""What each view saw: of every face how much, hidden by which, and how far it looked.

A line of sight ends where a picture agrees with the others on the face that it meets first; on the
edges that a view shows, of whatever they are; and on the ground (seen_ground.py). What was seen
from somewhere has nothing before it; a later step decides from that which space is free.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.gradients import gradient
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.tracked_faces import Landmarks
from facetlog.perception.scene import Scene, SeenLattice, SightLines
from facetlog.perception.surfaces.eyes import Eye, Surface
from facetlog.perception.surfaces.face_looks import Look, shown_at
from facetlog.perception.surfaces.false_edges import without_false_edges
from facetlog.perception.surfaces.seen_ground import seen_ground
from facetlog.perception.types import FloatArray, View

__all__ = ["with_sights"]

# Views that are asked whether they agree with one: the time grows with their number.
WITNESSES = 24


def with_sights(
    scene: Scene,
    views: Sequence[View],
    weight: Sequence[float],
    ground: tuple[FloatArray, float] | None,
    landmarks: Landmarks | None = None,
) -> Scene:
    """The scene with what each of its views saw of the faces, and with its lines of sight; without
    loose edges that are none, or are no bar's (false_edges.py).

    `views` are those of the scene, at the poses at which it was found, each with its `weight`
    beside views almost like it. `ground` and `landmarks` as in `TrackedFaces`.
    """
    surfaces = [Surface.of(face, scene.points) for face in scene.faces]
    levels = GreyLevels(views, [gradient(view.image) for view in views])
    photos = PhotometricViews(views, levels, np.array(weight))
    lattices: tuple[SeenLattice, ...] = ()
    if ground is not None:
        rings = [surface.rings for surface in surfaces]
        lattices = seen_ground(views, levels, photos.weight, rings, ground, scene.up)
    on_ground = [lines for seen in lattices for lines in seen.lines]
    looks = [Look.at(surface, len(views)) for surface in surfaces]
    observed: list[list[FloatArray]] = [[] for _ in views]
    for vertex in scene.vertices:
        for seen in vertex.observations:
            observed[seen.view].append(vertex.point)
    sights = []
    for k, view in enumerate(views):
        # An eye holds a picture of each face: one at a time.
        eye = Eye(view, surfaces)
        for number, look in enumerate(looks):
            look.through(k, eye, number)
        met = eye.first_met()
        corners = np.reshape(observed[k], (-1, 3))
        seen_by = shown_at(photos, met, _asked_with(k, len(views)))[0]
        ends = np.concatenate([met[seen_by], corners[eye.in_sight(corners)]])
        if landmarks is not None:
            beside = landmarks.points[landmarks.seen[:, k]]
            known = [ends, *(lines.ends for lines in on_ground if lines.view == k)]
            ends = np.concatenate([ends, eye.where_none_ends(np.concatenate(known), beside)])
        if len(ends):
            sights.append(SightLines(eye.centre, ends, k))
    faces = tuple(look.face(photos) for look in looks)
    found = replace(scene, faces=faces, sights=tuple(sights), lattices=lattices)
    return without_false_edges(found)


def _asked_with(view: int, count: int) -> NDArray[np.intp]:
    # A view, and evenly among the others so many that more would hardly change anything.
    others = np.delete(np.arange(count), view)
    chosen = np.linspace(0, len(others) - 1, min(WITNESSES, len(others))).round().astype(np.intp)
    return np.concatenate([[view], others[chosen]])
