"""Many labelled shapes into answers, on two cores: what the benchmarks of accuracy are made of."""

import hashlib
import multiprocessing
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import trimesh

from benchmarks.processes import WORKERS
from benchmarks.shapes.own_shapes import make_own_shape
from facetlog.batch.confusion import Confusion, answer
from facetlog.batch.labels import NONE, Label, Truth
from facetlog.batch.rows import Row
from facetlog.errors import FacetlogError
from facetlog.kb.batch_judge import BatchJudge
from facetlog.perception.facts.all_facts import FactRows, fact_rows
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh, read_mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape
from facetlog.perception.shapes.shape_options import UP_AXES

CLASSES = ("chair", "table", "box")
# What is borderline is listed apart, and what may be a plain cuboid may be answered box.
LISTED_APART = (
    "desk",
    "stool",
    "bench",
    "sofa_or_bench",
    "ottoman",
    "tv_unit",
    "open_box",
    "carton",
    "cuboid_table",
)
PERHAPS_BOXES = ("cabinet", "computer", "cinder_block", "board")
COUNTED_AS: Mapping[str, Truth] = {
    "armchair": Truth("chair"),
    **dict.fromkeys(LISTED_APART, Truth(None)),
    **dict.fromkeys(PERHAPS_BOXES, Truth(NONE, frozenset({"box"}))),
}
SAMPLES = 20_000
NOISE_SHARE = 0.005  # of the diagonal: 1 sd along each axis


@dataclass(frozen=True, slots=True)
class Task:
    """A shape to judge, from a file or, with a `seed`, of our own; `sampled`: as a noisy cloud."""

    name: str
    label: str
    up: str | None = None
    unit: str | None = None
    file: str | None = None
    seed: int | None = None
    sampled: bool = False

    @classmethod
    def of_file(cls, label: Label, name: str, *, sampled: bool = False) -> "Task":
        """Return the task of a line of labels; a word for no axis and for no unit is none."""
        up = label.up if label.up in UP_AXES else None
        unit = label.unit if label.unit in METRES_PER else None
        return cls(name, label.label, up, unit, file=label.file, sampled=sampled)


@dataclass(frozen=True, slots=True)
class Judged:
    """A shape with its answer: `row` has its verdicts or its error; seconds from file to answer."""

    task: Task
    answered: str
    row: Row
    whole: bool
    seconds: float


def is_held_out(name: str) -> bool:
    """Return whether a file is in the half that no rule is developed on: an odd MD5 of its name.

    >>> is_held_out("a.ply"), is_held_out("c.ply")
    (True, False)
    """
    return hashlib.md5(name.encode(), usedforsecurity=False).digest()[-1] % 2 == 1


def sample_noisy_cloud(mesh: Mesh, name: str) -> Cloud:
    """Return 20,000 points at random on a mesh's surface, each off by 0.5 % of the diagonal in any
    way.
    """
    digits = hashlib.md5(name.encode(), usedforsecurity=False).hexdigest()[:8]
    generator = np.random.default_rng(int(digits, 16))
    solid = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    points, _ = trimesh.sample.sample_surface(solid, SAMPLES, seed=generator)
    used = mesh.vertices[np.unique(mesh.triangles)]
    sd = NOISE_SHARE * float(np.linalg.norm(np.ptp(used, axis=0)))
    return Cloud.of(points + generator.normal(scale=sd, size=points.shape), name=name)


def scene_of(task: Task) -> Scene:
    """Return the scene of a shape. Raise FacetlogError if it cannot be read."""
    up = None if task.up is None else UP_AXES[task.up]
    if task.file is not None and not task.sampled:
        return read_shape(Path(task.file), ShapeOptions(up=up, unit=task.unit))
    if task.seed is not None:
        own = make_own_shape(task.seed)
        mesh, up = Mesh.of(own.vertices, own.triangles, name=task.name), own.up
    else:
        mesh = read_mesh(Path(task.file or ""))
    unit = METRES_PER[task.unit] if task.unit else None
    if unit is not None:
        mesh = replace(mesh, vertices=mesh.vertices * unit)
    if task.sampled:
        return make_cloud_scene(sample_noisy_cloud(mesh, task.name), up=up, metric=unit is not None)
    return make_mesh_scene(mesh, up=up, metric=unit is not None)


def judge_task(task: Task, judges: Sequence[BatchJudge]) -> tuple[Judged, ...]:
    """Return a shape judged by the models of each judge; what cannot be read is answered
    `error`.
    """
    start = time.perf_counter()
    error = None
    verdicts: list[list[Row]] = [[] for _ in judges]
    whole = False
    try:
        scene = scene_of(task)
        whole = any(body.whole for body in scene.bodies)
        facts = fact_rows(scene, {functor for judge in judges for functor, _ in judge.needed})
        verdicts = [_verdicts(judge, facts) for judge in judges]
    except FacetlogError as exc:
        error = str(exc)
    except Exception as exc:  # a fault of ours: it counts as wrong, and costs no other shape
        error = f"{type(exc).__name__}: {exc}"
    seconds = time.perf_counter() - start
    rows: list[Row] = [{"path": task.name, "verdicts": own, "error": error} for own in verdicts]
    return tuple(Judged(task, answer(row, CLASSES)[0], row, whole, seconds) for row in rows)


def _verdicts(judge: BatchJudge, facts: FactRows) -> list[Row]:
    # By degree alone, of equals in the order of the classes: the answer that is counted here.
    found = [v for v in judge.judge(facts) if v.model in CLASSES]
    found.sort(key=lambda v: (-v.degree, CLASSES.index(v.model)))
    return [{"model": v.model, "state": str(v.state), "degree": v.degree} for v in found]


_judges: list[BatchJudge] = []


def _open_judges(texts: Sequence[Sequence[Path]]) -> None:
    _judges.extend(BatchJudge(text) for text in texts)


def _judged_here(task: Task) -> tuple[Judged, ...]:
    return judge_task(task, _judges)


def judge_by_each(
    tasks: Sequence[Task], texts: Sequence[Sequence[Path]], workers: int = WORKERS
) -> tuple[tuple[Judged, ...], ...]:
    """Return all shapes judged by each of several texts, files of models that take the built-in
    ones' places; shapes and texts in their order, by so many spawned processes with an engine each.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    spawn = multiprocessing.get_context("spawn")
    with spawn.Pool(workers, _open_judges, (texts,)) as pool:
        return tuple(pool.imap(_judged_here, tasks, chunksize=1))


def judge_all(tasks: Sequence[Task], workers: int = WORKERS) -> tuple[Judged, ...]:
    """Return all shapes judged by the built-in models, in their order."""
    return tuple(found for (found,) in judge_by_each(tasks, ((),), workers))


def confusion(found: Iterable[Judged]) -> Confusion:
    """Return the answers counted as the labels say."""
    every = tuple(found)
    labels = {one.task.name: Label(one.task.name, one.task.label) for one in every}
    counted = Confusion(labels, CLASSES, COUNTED_AS)
    for one in every:
        counted.add(one.row)
    return counted
