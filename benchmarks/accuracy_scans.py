"""How often is a thing that is seen from one side taken for a box, and how often is a box found?

The upright meshes under FACETLOG_DATA (shapes/labels.csv) stand on a floor, and a depth sensor with
the noise of a Kinect looks at each from one place (benchmarks/single_view.py), once with the place
known and once without. What counts is the verdict on the largest thing that is found. Nothing here
was used to choose a limit. What may be a plain cuboid, and boxes that stand open, are not counted.
Intervals are Wilson's, 95 %.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks.accuracy_shapes import file_tasks
from benchmarks.common import Report, Row, Settings, Table, command, data_set, tree_hash
from benchmarks.shape_judging import LISTED_APART, PERHAPS_BOXES, WORKERS, Task, is_held_out
from benchmarks.single_view import LONGEST_M, single_view
from facetlog.batch.confusion import Proportion
from facetlog.kb.batch_judge import BatchJudge
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.reading.shape_files.mesh_files import read_mesh
from facetlog.perception.shapes.clouds.cloud_scene import scene_of_cloud
from facetlog.perception.shapes.shape_options import UP_AXES

__all__ = ["NAME", "main", "measure"]

NAME = "accuracy_scans"
BOX = "box"
NOT_COUNTED = (*LISTED_APART, *PERHAPS_BOXES)
STATES = ("holds", "unknown", "fails")


@dataclass(frozen=True, slots=True)
class _Seen:
    # A view of a mesh: whether its place is known, and the seed that it follows from.
    task: Task
    place: bool
    seed: int


_judges: list[BatchJudge] = []


def _state(seen: _Seen) -> str:
    """What `box` says of the largest thing in a view, `fails` if nothing is found, or the error."""
    task = seen.task
    if not _judges:
        _judges.append(BatchJudge())
    up = np.array(UP_AXES[task.up or "z"], dtype=np.float64)
    try:
        mesh = read_mesh(Path(task.file or ""))
        cloud = single_view(mesh, up, seen.seed, name=task.name, place=seen.place)
        scene = scene_of_cloud(cloud, up=up, metric=True)
        facts = fact_rows(scene)
        main = max(facts["thing_size"], key=_extent, default=("",))[0]
        verdicts = _judges[0].judge(facts)
    except Exception as exc:  # whatever it is, it costs no other shape
        return f"{type(exc).__name__}: {exc}"
    said = [str(v.state) for v in verdicts if v.model == BOX and v.thing == main]
    return said[0] if said else STATES[-1]


def _extent(thing_size: Sequence[str | int | float]) -> float:
    """The longest side of a thing: what is seen of a leg apart from its table is a lesser one."""
    return max(float(side) for side in thing_size[1:4])


def _rows(found: Sequence[tuple[_Seen, str]], what: str, place: bool) -> Row:
    states = [
        state
        for seen, state in found
        if seen.place == place and (seen.task.label == BOX) == (what == BOX)
    ]
    held = Proportion(states.count("holds"), len(states))
    low, high = held.interval or (None, None)
    return {
        "of": what,
        "place": "known" if place else "not known",
        "scans": len(states),
        **{state: states.count(state) for state in STATES},
        "errors": sum(state not in STATES for state in states),
        "held": held.value,
        "95 % from": low,
        "to": high,
    }


def measure(settings: Settings) -> Report:
    """All tables; without the third-party data the benchmark is skipped."""
    folder = data_set("shapes")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    tasks = [task for task in file_tasks(folder)["meshes"] if task.label not in NOT_COUNTED]
    views = [
        _Seen(task, place, settings.first + nth)
        for nth, task in enumerate(tasks)
        for place in (True, False)
    ][: settings.number(2 * len(tasks))]
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with ProcessPoolExecutor(WORKERS, get_context("spawn")) as pool:
        found = list(zip(views, pool.map(_state, views, chunksize=4), strict=True))
    rows = [_rows(found, what, place) for what in (BOX, "other things") for place in (True, False)]
    wrong: tuple[Row, ...] = tuple(
        {
            "shape": seen.task.name,
            "half": "held out" if is_held_out(seen.task.name) else "development",
            "label": seen.task.label,
            "place": "known" if seen.place else "not known",
            "box": state,
        }
        for seen, state in found
        if (seen.task.label == BOX) != (state == "holds")
        and state != "unknown"
        and (seen.task.label == BOX or state != "fails")
    )
    return Report(
        NAME,
        (Table("What box says", tuple(rows)), *([Table("Wrong", wrong)] if wrong else [])),
        {"shapes": tree_hash(folder), "views": len(views), "longest side, m": LONGEST_M},
        ("Wanted: at most .03 of other things held as boxes.",),
    )


main = command(NAME, __doc__, measure)

if __name__ == "__main__":
    main(None)
