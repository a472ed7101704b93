"""Sights of each view: how much of every face it saw, hidden by which, and how far it looked.

A line of sight ends where a picture agrees with the others on a face that nothing hides
(seen_faces.py), on the ground (seen_ground.py), and on the edges that a view shows, of whatever
they are. What was seen from somewhere has nothing before it; a later step decides from that which
space is free.

The ground beside a loose edge shows whether it is one, and a bar's. Lines of a floor that agree by
chance make edges in the air. Of a true one some solid hides the ground along it, though it shows to
either side: the ground shows through the others. Nobody sees an edge beneath ground that shows all
round. Of a bar that stands on the ground, as a leg, some view shows it to both sides at once. Of a
solid's own edge, of which a side was not found, none does, for that side hides it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from facetlog.perception.detection.coarse_pictures import gradient
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.tracked_faces import Landmarks
from facetlog.perception.ragged import Bools
from facetlog.perception.scene import Scene, SeenLattice, SightLines
from facetlog.perception.surfaces.scene_from_tracks import drop_unused
from facetlog.perception.surfaces.seeing.seen_faces import (
    Eye,
    Look,
    choose_points_without_ends,
    make_surfaces,
)
from facetlog.perception.surfaces.seeing.seen_ground import seen_ground
from facetlog.perception.types import FloatArray, View

# Samples along an edge, but for its ends, which are the least certain.
SAMPLES = np.linspace(0.05, 0.95, 40)[:, None]
# So many points of a lattice to either side: beyond a leg and the windows that reach over it.
BESIDE = 5.0
# The ground shows more than this many times as often along an edge as beside it, if none is there:
# along true ones up to .4 times, along others .9 times and more.
AS_OFTEN = 0.7
# Points that show beside an edge: with fewer it stays.
FEWEST = 20
# Where views show the ground to one side of a bar, this share of them at least show it to the other
# side, too: of legs in own worlds and pictures 3 % and more, of the sides of boxes mostly none.
BOTH_SIDES = 0.01
# An edge lies beneath the ground where it does by so many standard deviations.
BENEATH_SDS = 3.0
# Edges on the ground stand if they rise by more than this share of their length: sin 30°.
RISING = 0.5


def drop_false_edges(scene: Scene) -> Scene:
    """Return the scene without loose edges that the ground refutes, and those of solids."""
    sides = {
        frozenset((a, b))
        for face in scene.faces
        for ring in (face.outline, *face.holes)
        for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)
    }
    loose = [n for n, e in enumerate(scene.edges) if frozenset((e.start, e.end)) not in sides]
    ends = np.array([(scene.edges[n].start, scene.edges[n].end) for n in loose], dtype=np.intp)
    segments = scene.points[ends.reshape(-1, 2)]
    beside = GroundBeside.of(segments, scene.seen_ground)
    gone = beside.through | beside.of_solids
    if len(loose):
        covs = np.array([vertex.cov for vertex in scene.vertices])[ends]
        for lattice in scene.seen_ground:
            gone |= _is_beneath_ground(segments, covs, lattice)
    if not gone.any():
        return scene
    wrong = {loose[n] for n in np.flatnonzero(gone).tolist()}
    edges = tuple(edge for n, edge in enumerate(scene.edges) if n not in wrong)
    return drop_unused(scene, edges)


def _is_beneath_ground(segments: FloatArray, covs: FloatArray, lattice: SeenLattice) -> Bools:
    """Return which segments (n, 2, 3), ends known to `covs` (n, 2, 3, 3), lie beneath ground all
    round.

    That is, below the hull of what shows of it, from where it shows. It is as exact as its pitch.
    """
    pitch = float(np.linalg.norm(lattice.steps[0]))
    normal = np.cross(*lattice.steps) / pitch**2
    if float(np.mean((lattice.origins - lattice.corner) @ normal)) < 0.0:
        normal = -normal
    off = segments - lattice.corner
    sds = np.sqrt(np.maximum(np.einsum("i,neij,j->ne", normal, covs, normal), 0.0))
    low = (off @ normal < -np.maximum(BENEATH_SDS * sds, pitch)).all(axis=1)
    round_it = shapely.MultiPoint(np.argwhere(lattice.shown.any(axis=0))).convex_hull
    places = shapely.points(off @ lattice.steps.T / pitch**2)
    return np.asarray(low & shapely.intersects(round_it, places).all(axis=1))


@dataclass(frozen=True, eq=False, slots=True)
class GroundBeside:
    """How often all views together show the ground `along` segments (n,) above it, to either side
    (`left`, `right`), and to `both` at once; and which of them `stand` on it.
    """

    along: FloatArray
    left: FloatArray
    right: FloatArray
    both: FloatArray
    stand: Bools

    @classmethod
    def of(cls, segments: FloatArray, lattices: Sequence[SeenLattice]) -> "GroundBeside":
        """Count how the views show the ground beside segments (n, 2, 3)."""
        span = segments[:, 1] - segments[:, 0]
        samples = segments[:, None, 0] + SAMPLES * span[:, None]
        along, left, right, both = np.zeros((4, len(segments)))
        stand = np.zeros(len(segments), dtype=np.bool_)
        for lattice in lattices:
            pitch = float(np.linalg.norm(lattice.steps[0]))
            normal = np.cross(*lattice.steps) / pitch**2
            rises = np.abs(span @ normal) > RISING * np.linalg.norm(span, axis=1)
            away = np.abs((segments - lattice.corner) @ normal).min(axis=1)
            stand |= rises & (away < BESIDE * pitch)
            for origin, shown in zip(lattice.origins, lattice.shown, strict=True):
                top = float((origin - lattice.corner) @ normal)
                up = normal if top > 0.0 else -normal
                top = abs(top)
                high = (samples - lattice.corner) @ up
                over = (high > BESIDE * pitch) & (high < top)
                below = np.where(over, top - high, 1.0)
                met = origin + (samples - origin) * (top / below)[..., None]
                at = (met - lattice.corner) @ lattice.steps.T / pitch**2
                run = at[:, -1] - at[:, 0]
                size = np.linalg.norm(run, axis=1)
                over &= size[:, None] > 0.0
                across = run[:, ::-1] * [-1.0, 1.0] / np.where(size > 0.0, size, 1.0)[:, None]
                along += _shown(shown, at, over)
                one, other = (
                    _shown(shown, at + side * across[:, None], over) for side in (-BESIDE, BESIDE)
                )
                left += one
                right += other
                both += np.minimum(one, other)
        return cls(along, left, right, both, stand)

    @property
    def through(self) -> Bools:
        """Which are seen through to the ground (n,)."""
        either = self.left + self.right
        return np.asarray((either >= FEWEST) & (2.0 * self.along > AS_OFTEN * either))

    @property
    def of_solids(self) -> Bools:
        """Which stand on the ground, and no view shows it to both of their sides at once (n,)."""
        one = self.left + self.right - 2.0 * self.both
        return np.asarray(self.stand & (one >= FEWEST) & (self.both < BOTH_SIDES * one))


def _shown(shown: Bools, at: FloatArray, over: Bools) -> FloatArray:
    """Return how many (n,) of the points nearest to places (n, k, 2), of those `over` it, are
    shown.
    """
    row, column = np.rint(at).astype(np.intp).transpose(2, 0, 1)
    rows, columns = shown.shape
    inside = over & (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    found = inside & shown[np.where(inside, row, 0), np.where(inside, column, 0)]
    counts: FloatArray = found.sum(axis=1).astype(np.float64)
    return counts


def add_sights(
    scene: Scene,
    views: Sequence[View],
    weight: Sequence[float],
    ground: tuple[FloatArray, float] | None,
    landmarks: Landmarks | None = None,
) -> Scene:
    """Return the scene with what each of its views saw of the faces, and with its lines of sight;
    without loose edges that are none, or are no bar's (drop_false_edges).

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
