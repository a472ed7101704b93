"""Runs of the whole way from views to verdicts, and how what they found is scored.

A scene is compared with the true solid by its corners: each true corner takes the found vertex
nearest to it (one to one), if that lies within a sixth of the shortest true edge.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from scipy.optimize import linear_sum_assignment

from benchmarks.common import Cell
from facetlog.errors import FacetlogError
from facetlog.kb.explaining.proof import State
from facetlog.perception.facts.relations import compute_angle_between
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.scene import Scene
from facetlog.perception.step_clock import StepClock
from facetlog.perception.types import Camera, FloatArray, Pose, View
from facetlog.pipeline import FrontEnd, Method, recognize_views
from facetlog.robot.rendering.views import Similarity, views_of
from facetlog.robot.rendering.world import Floor, Solid, World
from facetlog.robot.rendering.worlds import INCH, make_world
from facetlog.robot.tour import tour_camera, tour_poses

BOX, OPEN, NOTHING = "box", "box is open", "nothing"
# A sixth of the shortest true edge: far above the errors of a corner that is right, and nearer
# to it than the middle of an edge, where print may have corners of its own.
MATCH_SHARE = 1.0 / 6.0
# Planes nearer to parallel than this have no edge between them, rad.
LEAST_TURN = np.radians(10.0)
WHITE = 255.0
SAME_FRAME = Similarity(np.eye(3), np.zeros(3))


@dataclass(frozen=True, eq=False, slots=True)
class Shape:
    """A true solid: `vertices` (n, 3), `edges` as pairs, `faces` as loops ccw from outside."""

    vertices: FloatArray
    edges: tuple[tuple[int, int], ...]
    faces: tuple[tuple[int, ...], ...]

    def seen_faces(self, centres: FloatArray) -> tuple[int, ...]:
        """Return the faces that look to at least one of the cameras, whose centres are (V, 3)."""
        return tuple(
            index
            for index, face in enumerate(self.faces)
            if ((centres - self.vertices[face[0]]) @ self.normal(index) > 0).any()
        )

    def normal(self, face: int) -> FloatArray:
        """Return unit outward normal (3,)."""
        corners = self.vertices[list(self.faces[face])]
        total = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        return np.asarray(total / np.linalg.norm(total))


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """What one run came to: the models that hold, or the name of an error and its message.

    `first` is the name that stands first, `kinds` are those that it is a kind of; `maybe_box` says
    that box was neither confirmed nor denied of some thing.
    """

    models: tuple[str, ...] = ()
    first: str | None = None
    kinds: tuple[str, ...] = ()
    scene: Scene | None = None
    maybe_box: bool = False
    error: str | None = None
    message: str = ""

    @property
    def is_box(self) -> bool:
        """Whether it says box of one thing, and nothing else."""
        return self.models == (BOX,)

    @property
    def outcome(self) -> str:
        """One phrase: the error, what holds, or whether box remains open."""
        return self.error or " + ".join(self.models) or (OPEN if self.maybe_box else NOTHING)


@dataclass(frozen=True, slots=True)
class Score:
    """What a scene has of a solid; lengths in the unit of both, angles in degrees.

    `vertex_errors` and `vertex_nees` (chi-square over 3) are of the matched vertices,
    `edge_errors` are found minus true length of the edges matched at both ends, `edge_lengths`
    their true lengths, `angle_errors` and `angle_nees` of the pairs of matched faces that are not
    parallel. Faces are missing of those that look to a camera; a vertex or face without a partner
    is extra.
    """

    vertex_errors: tuple[float, ...]
    vertex_nees: tuple[float, ...]
    extra_vertices: int
    edge_errors: tuple[float, ...]
    edge_lengths: tuple[float, ...]
    angle_errors: tuple[float, ...]
    angle_nees: tuple[float, ...]
    missing_faces: int
    extra_faces: int

    @property
    def rms(self) -> float:
        """Root mean square error of the matched vertices; NaN if there are none."""
        return float(np.sqrt(np.mean(np.square(self.vertex_errors or (np.nan,)))))


def recognised(view_set: ViewSet, front_end: FrontEnd, clock: StepClock | None = None) -> Run:
    """Return the run on these views; an error that a user would be told of is an outcome, too."""
    try:
        found = recognize_views(view_set, method=Method(front_end), clock=clock or StepClock())
    except FacetlogError as exc:
        return Run(error=type(exc).__name__, message=str(exc))
    verdicts = found.recognition.verdicts
    best = found.recognition.best
    return Run(
        tuple(sorted(verdict.model for verdict in best)),
        best[0].model if best else None,
        best[0].specialises if best else (),
        found.scene,
        any(v.model == BOX and v.state is State.UNKNOWN for v in verdicts),
    )


def counted(outcomes: Iterable[str]) -> str:
    """Return outcomes with how often each came, the most frequent first.

    >>> counted(["box", "nothing", "box"])
    'box 2, nothing 1'
    """
    return ", ".join(f"{name} {count}" for name, count in Counter(outcomes).most_common())


def score(scene: Scene, shape: Shape, centres: FloatArray, unit: float = 1.0) -> Score:
    """Return how the scene compares with the true shape; `centres` (V, 3) are the cameras'.

    All three are in the same unit; lengths of the score are in `unit` of it.
    """
    corner_of = _matches(scene.points, shape)
    errors, nees = [], []
    for vertex, corner in corner_of.items():
        error = scene.vertices[vertex].point - shape.vertices[corner]
        errors.append(float(np.linalg.norm(error)) / unit)
        nees.append(float(error @ np.linalg.solve(scene.vertices[vertex].cov, error)) / 3.0)
    true_edges = {frozenset(edge) for edge in shape.edges}
    edges = {
        ends: _length(scene.points, (e.start, e.end)) - _length(shape.vertices, ends)
        for e in scene.edges
        if (ends := frozenset((corner_of.get(e.start, -1), corner_of.get(e.end, -2)))) in true_edges
    }
    loops = {frozenset(face): index for index, face in enumerate(shape.faces)}
    owners = [
        loops.get(frozenset(corner_of.get(v, -1) for v in face.outline)) for face in scene.faces
    ]
    matched = {
        owner: face for owner, face in zip(owners, scene.faces, strict=True) if owner is not None
    }
    angle_errors, angle_nees = [], []
    for a in matched:
        for b in matched:
            true = float(np.arccos(np.clip(shape.normal(a) @ shape.normal(b), -1.0, 1.0)))
            if a < b and LEAST_TURN < true < np.pi - LEAST_TURN:
                angle, sd = compute_angle_between(matched[a].plane, matched[b].plane)
                angle_errors.append(float(np.degrees(angle - true)))
                angle_nees.append(((angle - true) / sd) ** 2)
    return Score(
        tuple(errors),
        tuple(nees),
        len(scene.vertices) - len(corner_of),
        tuple(error / unit for error in edges.values()),
        tuple(_length(shape.vertices, ends) / unit for ends in edges),
        tuple(angle_errors),
        tuple(angle_nees),
        len(set(shape.seen_faces(centres)) - set(matched)),
        len(scene.faces) - len(matched),
    )


def _length(points: FloatArray, ends: Iterable[int]) -> float:
    start, end = points[list(ends)]
    return float(np.linalg.norm(end - start))


def _matches(points: FloatArray, shape: Shape) -> dict[int, int]:
    """Return the true corner of each matched vertex."""
    reach = MATCH_SHARE * min(
        float(np.linalg.norm(shape.vertices[a] - shape.vertices[b])) for a, b in shape.edges
    )
    distance = np.linalg.norm(points[:, None] - shape.vertices[None], axis=2)
    # Beyond the reach all are equally far: no such pair may push a good one aside.
    rows, columns = linear_sum_assignment(np.minimum(distance, reach))
    return {int(r): int(c) for r, c in zip(rows, columns, strict=True) if distance[r, c] < reach}


def tour_views(
    world: World | str,
    seed: int,
    *,
    poses: Sequence[Pose] | None = None,
    camera: Camera | None = None,
    noise_sd: float = 5.0,
    blur_px: float = 1.0,
) -> tuple[View, ...]:
    """Return views of a world (or of the world of that name and seed), in inches, from the tour's
    poses and by its camera, or from others and by another.
    """
    return views_of(
        make_world(world, seed) if isinstance(world, str) else world,
        tour_poses() if poses is None else poses,
        tour_camera() if camera is None else camera,
        seed=seed,
        noise_sd=noise_sd,
        blur_px=blur_px,
    )


def light_in_steps(world: World, step_grey: float) -> World:
    """Return the world in even light without shadows, on a plain floor without a horizon: each face
    is one grey, brighter than the floor by a number of steps, and by another than those that it
    meets.
    """
    assert world.floor is not None
    unit = WHITE * world.exposure
    floor = round(unit * world.floor.albedo)
    solids = tuple(
        replace(
            solid,
            albedo=tuple((floor + step_grey * n) / unit for n in _steps(solid)),
            prints=(),
        )
        for solid in world.solids
    )
    plain = Floor(floor / unit)
    return replace(world, solids=solids, floor=plain, background=floor, ambient=1.0, sided=0.0)


def _steps(solid: Solid) -> list[int]:
    """Return for each face the least number from 1 that no face before it has at a true
    edge of both.
    """
    edges = [
        {frozenset(pair) for pair in zip(face, (*face[1:], face[0]), strict=True)}
        for face in solid.faces
    ]
    found: list[int] = []
    for index, own in enumerate(edges):
        taken = {
            n
            for other, n in enumerate(found)
            if own & edges[other] and not solid.curved.issuperset((index, other))
        }
        found.append(next(n for n in count(1) if n not in taken))
    return found


def in_metres(name: str, views: Sequence[View], model_scale: float = 1.0) -> ViewSet:
    """Return views in inches as a set in metres, z up, as the demo has them.

    Of a world of models that are `model_scale` times smaller than the things, as if of the things.
    """
    metres = INCH * model_scale
    return ViewSet(
        name,
        tuple(replace(v, pose=Pose(v.pose.rotation, v.pose.centre * metres)) for v in views),
        up=np.array([0.0, 0.0, 1.0]),
        metric=True,
    )


def get_true_block(world: World) -> Shape:
    """Return the first solid of a world, in the world's own unit."""
    solid = world.truth.solids[0]
    return Shape(np.array(solid.vertices), solid.edges, solid.faces)


def in_frame(view_set: ViewSet, frame: Similarity) -> ViewSet:
    """Return the same views in another frame, with the direction up turned along."""
    up = None if view_set.up is None else frame.rotation @ view_set.up
    views = tuple(map(frame.view, view_set.views))
    # Metres times a scale are metres no more.
    return replace(view_set, views=views, up=up, metric=view_set.metric and frame.scale == 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """A run on views of a solid: its name, what it came to, and its score if it has a scene."""

    name: str
    run: Run
    score: Score | None


def tried(
    name: str, views: Sequence[View], world: World, frame: Similarity = SAME_FRAME
) -> dict[FrontEnd, Trial]:
    """Return the same views (in inches) through each front end, scored in inches.

    `frame` is another world frame to reconstruct in.
    """
    view_set = in_frame(in_metres(name, views), frame)
    unit = frame.scale * INCH
    shape = get_true_block(world)
    there = replace(shape, vertices=unit * shape.vertices @ frame.rotation.T + frame.shift)
    centres = np.array([v.pose.centre for v in view_set.views])
    trials = {}
    for front_end in FrontEnd:
        run = recognised(view_set, front_end)
        found = None if run.scene is None else score(run.scene, there, centres, unit=unit)
        trials[front_end] = Trial(name, run, found)
    return trials


def summary(trials: Sequence[Trial]) -> dict[str, Cell]:
    """Return one row: verdicts, vertices' errors (inches), and what is missing or extra,
    over all.
    """
    scores = [t.score for t in trials if t.score is not None]
    rms = [s.rms for s in scores if s.vertex_errors]
    return {
        "box": f"{sum(t.run.is_box for t in trials)} of {len(trials)}",
        "verdicts": counted(t.run.outcome for t in trials),
        "rms median in": round(float(np.median(rms)), 4) if rms else None,
        "rms worst in": round(max(rms), 4) if rms else None,
        "vertices": sum(len(s.vertex_errors) for s in scores),
        "extra vertices": sum(s.extra_vertices for s in scores),
        "missing faces": sum(s.missing_faces for s in scores),
        "extra faces": sum(s.extra_faces for s in scores),
    }
