"""How much of what the own worlds' things show becomes faces, how much of that is true, and what
is said of it?

The demo's tour of 24 views round a block and round furniture, whose faces are known exactly.
Recall: share of the visible flat area (of faces that cover more than 100 square pixels in three
views or more; what two views see of them) that a found face covers within 3 degrees and 1 % of the
thing's diagonal. Precision: share of the found area, the ground left out, that lies on true
surface. Wanted: a recall of .90 and a precision of .98. accuracy_faces asks the same of third-party
pictures.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import Cell, Report, Row, Settings, Table
from benchmarks.knowledge.calibration_scenes import KINDS, get_world_truth
from benchmarks.pictures.polygons import Polygon
from benchmarks.pictures.recognition import Run, counted, in_metres, recognised, tour_views
from facetlog.perception.types import FloatArray, View
from facetlog.pipeline import FrontEnd
from facetlog.robot.rendering.render import find_first_hits, seen_by
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import INCH, make_world

NAME = "accuracy_worlds"
SEEDS = 20
WORLDS = ("block", "table", "chair", "desk", "stool", "bench", "shelf", "cabinet")
# A face counts if so many views show so many square pixels of it, and of it what two views see.
LEAST_PX, LEAST_VIEWS, SEEN_VIEWS = 100.0, 3, 2
# Lengths are shares of the thing's diagonal. A found face may reach this far out of its plane, and
# a point that far out of its outline; what lies on true surface may be turned a little more.
OFFSET, MARGIN, TURN = 0.01, 0.005, float(np.radians(3.0))
TRUE_MARGIN, TRUE_TURN = 0.02, float(np.radians(5.0))
# A face on the floor that is also within the offset of true surface is ground up to this height.
ON_GROUND = 0.002


@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """The faces of a world in its own unit, and samples of those of their parts that count.

    `points` (n, 3) stand for `areas` (n,) each, `owners` (n,) are the faces they lie on.
    """

    faces: tuple[Polygon, ...]
    diagonal: float
    points: FloatArray
    areas: FloatArray
    owners: NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Areas:
    """Shares of the visible flat area: `covered` by found faces; of the found faces' own area what
    is `true`, `wrong`, and `ground`."""

    covered: float
    true: float
    wrong: float
    ground: float

    @property
    def precision(self) -> float:
        """Share of what was found, the ground left out; NaN where nothing was."""
        return self.true / (self.true + self.wrong) if self.true + self.wrong else float("nan")


@dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """One tour: its world, what it came to and took, and the areas found."""

    world: str
    run: Run
    areas: Areas
    seconds: float

    @property
    def faces(self) -> int:
        """How many were found."""
        return 0 if self.run.scene is None else len(self.run.scene.faces)

    @property
    def is_right(self) -> bool:
        """Whether something is said, and nothing that the thing is not."""
        said = [get_world_truth(self.world, model) for model in self.run.models]
        return True in said and False not in said

    @property
    def is_named(self) -> bool:
        """Whether the name that stands first is one of the thing's, or, where that is open, a kind
        of it: a high shelf is a bookcase."""
        first = self.run.first
        if first is None or get_world_truth(self.world, first) is False:
            return False
        return any(get_world_truth(self.world, name) for name in (first, *self.run.kinds))


def measure(settings: Settings) -> Report:
    """Measure all worlds over the seeds."""
    seeds = settings.seeds(SEEDS)
    trials = [_trial(name, seed) for name in WORLDS for seed in seeds]
    of_world = {name: [t for t in trials if t.world == name] for name in WORLDS}
    return Report(
        NAME,
        (
            Table("All worlds", (_row(trials),)),
            Table(
                "Each world",
                tuple(
                    {
                        "world": name,
                        "is": ", ".join(sorted(KINDS[name])),
                        **_row(found),
                        "verdicts": counted(t.run.outcome for t in found),
                    }
                    for name, found in of_world.items()
                ),
            ),
        ),
        {"seeds": len(seeds), "first seed": seeds.start, "views": 24},
        (
            "Recall and ground: means over the tours; precision: of all their faces' area. "
            "ground: area on the floor over the thing's visible area.",
        ),
    )


def _trial(name: str, seed: int) -> Trial:
    world = make_world(name, seed)
    views = tour_views(world, seed)
    before = time.process_time()
    view_set = in_metres(f"{name}-{seed}", views, world.model_scale)
    run = recognised(view_set, FrontEnd.LINES)
    seconds = time.process_time() - before
    found: list[FloatArray] = []
    if run.scene is not None:
        points = run.scene.points / (INCH * world.model_scale)
        found = [points[list(face.outline)] for face in run.scene.faces]
    return Trial(name, run, areas(sample_true_surface(world, views), found), seconds)


def sample_true_surface(world: World, views: Sequence[View]) -> Surface:
    """Return what the views, in the world's unit, show of its things."""
    faces = tuple(Polygon(facet.corners) for facet in world.facets)
    of_face = [face.samples() for face in faces]
    counts = [len(points) for points in of_face]
    points, owners = np.concatenate(of_face), np.repeat(np.arange(len(faces)), counts)
    areas_ = np.repeat([f.area / n for f, n in zip(faces, counts, strict=True)], counts)
    normals = np.array([face.normal for face in faces])[owners]
    seen = np.zeros((len(points), len(views)), np.bool_)
    pixels = np.zeros((len(faces), len(views)))
    for k, view in enumerate(views):
        h = np.column_stack([points, np.ones(len(points))]) @ view.projection.T
        depth = h[:, 2]
        uv = h[:, :2] / np.where(depth > 0, depth, np.nan)[:, None]
        size = np.array([view.camera.width, view.camera.height]) - 1
        inside = np.flatnonzero(((uv > 0) & (uv < size)).all(axis=1))
        screen = seen_by(world, view.camera, view.pose)
        hits = find_first_hits(world, view.camera, view.pose, screen, uv[inside].T)
        here = inside[hits.facet == owners[inside]]
        seen[here, k] = True
        # An area A whose normal is n covers fx fy A |n·(c - x)| / z³ of the picture.
        slant = np.abs(((view.pose.centre - points[here]) * normals[here]).sum(axis=1))
        covered = view.camera.fx * view.camera.fy * areas_[here] * slant / depth[here] ** 3
        np.add.at(pixels[:, k], owners[here], covered)
    counted_faces = (pixels > LEAST_PX).sum(axis=1) >= LEAST_VIEWS
    kept = (seen.sum(axis=1) >= SEEN_VIEWS) & counted_faces[owners]
    diagonal = float(np.linalg.norm(world.solids[0].size))
    return Surface(faces, diagonal, points[kept], areas_[kept], owners[kept])


def areas(surface: Surface, found: Sequence[FloatArray]) -> Areas:
    """Return how the outlines (n, 3) of found faces, in the world's unit, compare with its
    surface.
    """
    size = surface.diagonal
    normals = np.array([face.normal for face in surface.faces])[surface.owners]
    covered = np.zeros(len(surface.points), np.bool_)
    true, wrong, ground = 0.0, 0.0, 0.0
    for outline in found:
        face = Polygon(outline)
        covered |= face.covers(
            surface.points, normals, offset=OFFSET * size, margin=MARGIN * size, turn=TURN
        )
        points = face.samples()
        directions = np.broadcast_to(face.normal, points.shape)
        on_surface = np.zeros(len(points), np.bool_)
        for one in surface.faces:
            on_surface |= one.covers(
                points,
                directions,
                offset=OFFSET * size,
                margin=TRUE_MARGIN * size,
                turn=TRUE_TURN,
            )
        height = points[:, 2]
        low = (np.abs(height) < OFFSET * size) & (abs(face.normal[2]) > np.cos(TRUE_TURN))
        low &= ~(on_surface & (height > ON_GROUND * size))
        ground += face.area * low.mean()
        true += face.area * (on_surface & ~low).mean()
        wrong += face.area * (~on_surface & ~low).mean()
    total = surface.areas.sum()
    return Areas(*(float(x / total) for x in (surface.areas[covered].sum(), true, wrong, ground)))


def _row(trials: Sequence[Trial]) -> Row:
    true, wrong = sum(t.areas.true for t in trials), sum(t.areas.wrong for t in trials)
    recall = [t.areas.covered for t in trials]
    figures: dict[str, Cell] = {
        "recall": round(float(np.mean(recall)), 3),
        "worst recall": round(min(recall), 3),
        "precision": round(true / (true + wrong), 3) if true + wrong else None,
        "worst precision": _worst([t.areas.precision for t in trials]),
        "ground": round(float(np.mean([t.areas.ground for t in trials])), 3),
        "faces": round(float(np.mean([t.faces for t in trials])), 1),
        "first name right": f"{sum(t.is_named for t in trials)} of {len(trials)}",
        "nothing wrong": f"{sum(t.is_right for t in trials)} of {len(trials)}",
        "CPU s": round(float(np.mean([t.seconds for t in trials])), 1),
    }
    return figures


def _worst(values: Sequence[float]) -> float | None:
    known = [v for v in values if not np.isnan(v)]
    return round(min(known), 3) if known else None
