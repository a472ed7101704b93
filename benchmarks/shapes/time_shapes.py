"""How much CPU time does a mesh of the set, or a depth camera's frame, take from file to verdicts?

155 third-party meshes under FACETLOG_DATA, evenly over the list, are read, made into scenes and
into the facts that the built-in models ask for, and judged: once without solid parts, which no such
model asks for, and the scene once more with them. Then a Kinect's frame of 640 x 480, simulated, of
the table of time_mesh on a floor. CPU time. The peers, in the same run: trimesh loads the mesh and
finds its facets; Open3D, where it is installed, finds the planar patches of 20,000 points on the
mesh, and those of the frame.
"""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from benchmarks.common import Cell, Report, Row, Settings, Table, find_data_set
from benchmarks.pictures.accuracy_planes import PEERS
from benchmarks.pictures.accuracy_planes import Cloud as Points
from benchmarks.shapes.shape_judging import SAMPLES, Task
from benchmarks.shapes.single_view import single_view
from benchmarks.shapes.time_mesh import make_table_mesh
from facetlog.batch.labels import read_labels
from facetlog.kb.batch_judge import BatchJudge
from facetlog.perception.facts.all_facts import fact_columns
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape
from facetlog.perception.shapes.shape_options import UP_AXES
from facetlog.perception.types import FloatArray

NAME = "time_shapes"
SHAPES = 155
SEEDS = 3  # views of the table
UP = np.array([0.0, 0.0, 1.0])
FINE = 2  # times 320 x 240


def _run(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the CPU time of some work, ms, and its result."""
    start = time.process_time()
    result = work()
    return 1e3 * (time.process_time() - start), result


def _find_patches(points: FloatArray) -> Callable[[], Any]:
    """Return what finds the planar patches of points (n, 3); ImportError without Open3D."""
    none = np.zeros(0, dtype=np.intp)
    return PEERS["Open3D"]()(Points(np.array(points), none, np.zeros((0, 3)), 0.0))


def _time_mesh(task: Task, judge: BatchJudge, with_peer: bool) -> dict[str, float]:
    """Return milliseconds of each step of a mesh, and of the peers."""
    path = Path(task.file or "")
    up = None if task.up is None else UP_AXES[task.up]
    options = ShapeOptions(up=up, unit=task.unit, solid_parts=False)
    scene_ms, scene = _run(lambda: read_shape(path, options))
    facts_ms, facts = _run(lambda: fact_columns(scene, {name for name, _ in judge.needed}))
    judge_ms, _ = _run(lambda: judge.judge_columns(facts))
    whole = ShapeOptions(up=up, unit=task.unit)
    found = {
        "file to verdicts": scene_ms + facts_ms + judge_ms,
        "file to facts": scene_ms + facts_ms,
        "file to scene": scene_ms,
        "facts": facts_ms,
        "judge": judge_ms,
        "file to scene with solid parts": _run(lambda: read_shape(path, whole))[0],
        "trimesh: load, facets": _run(lambda: len(trimesh.load_mesh(path).facets))[0],
    }
    if with_peer:
        points = np.asarray(trimesh.load_mesh(path).sample(SAMPLES, seed=0))
        found["Open3D: planar patches"] = _run(_find_patches(points))[0]
    return found


def _sum_up(what: str, times: list[float], digits: int = 0) -> Row:
    mean, median, worst = np.mean(times), np.median(times), np.max(times)
    cells: dict[str, Cell] = {"what": what}
    for name, value in (("mean", mean), ("median", median), ("worst", worst)):
        cells[name] = round(float(value), digits)
    return cells


def _time_frame(seed: int, with_peer: bool) -> dict[str, float]:
    table = make_table_mesh(0)
    mesh = Mesh.of(table.vertices, table.faces, name="table")
    cloud = single_view(mesh, UP, seed, name="frame", place=True, fine=FINE)
    found = {"scene": _run(lambda: make_cloud_scene(cloud, up=UP, metric=True))[0]}
    if with_peer:
        found["Open3D: planar patches"] = _run(_find_patches(cloud.points))[0]
    return {"points": float(len(cloud.points)), **{k: v / 1e3 for k, v in found.items()}}


def _make_rows(each: list[dict[str, float]], digits: int = 0) -> tuple[Row, ...]:
    return tuple(_sum_up(what, [one[what] for one in each], digits) for what in each[0])


def measure(settings: Settings) -> Report:
    """Measure the meshes and the frames; the number of seeds is that of the frames."""
    folder = find_data_set("shapes")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    labels = [
        label for label in read_labels(folder / "labels.csv").values() if label.kind == "mesh"
    ]
    chosen = np.linspace(0, len(labels) - 1, SHAPES).astype(int).tolist()
    notes: tuple[str, ...] = ()
    try:
        PEERS["Open3D"]()
    except ImportError as exc:
        notes = (f"Open3D was not measured: {exc}",)
    with_peer = not notes
    with BatchJudge() as judge:
        tasks = [Task.of_file(labels[i], labels[i].file) for i in chosen]
        _time_mesh(tasks[0], judge, with_peer)  # not counted: the first run fills caches
        meshes = [_time_mesh(task, judge, with_peer) for task in tasks]
    frames = [_time_frame(seed, with_peer) for seed in settings.seeds(SEEDS)]
    return Report(
        NAME,
        (
            Table("A mesh, CPU ms", _make_rows(meshes)),
            Table("A depth camera's frame, CPU s", _make_rows(frames, 2)),
        ),
        {"meshes": len(meshes), "frames": len(frames)},
        (*notes, "Wanted: file to verdicts 150 ms in the mean, 1,500 at most; a frame 10 s."),
    )
