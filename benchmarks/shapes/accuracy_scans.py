"""How often is a thing that is seen from one side taken for a box, and how often is a box found?

The upright meshes under FACETLOG_DATA (shapes/labels.csv) stand on a floor, and a depth sensor with
the noise of a Kinect looks at each from one place (single_view.py), once with the place
known and once without. What counts is the verdict on the largest thing that is found. Nothing here
was used to choose a limit. A shelf from behind looks like a box to anybody: things whose view shows
that they are none are counted apart as well. What may be a plain cuboid, and boxes that stand open,
are not counted. Intervals are Wilson's, 95 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, find_data_set, hash_tree
from benchmarks.processes import spread
from benchmarks.shapes.accuracy_shapes import list_file_tasks
from benchmarks.shapes.shape_judging import LISTED_APART, PERHAPS_BOXES, Task, is_held_out
from benchmarks.shapes.single_view import LONGEST_M, measure_beyond_box, single_view
from facetlog.batch.confusion import Proportion
from facetlog.kb.batch_judge import BatchJudge
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh, read_mesh
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.shapes.shape_options import UP_AXES
from facetlog.perception.types import FloatArray

NAME = "accuracy_scans"
BOX = "box"
NOT_COUNTED = (*LISTED_APART, *PERHAPS_BOXES)
STATES = ("holds", "unknown", "fails")
OTHERS, SHOWN = "other things", "other things that show it"
# A view shows that a thing is no box where more than this share of it lies behind a box's sides: it
# is as much as a box's own rounded edges may have.
LEAST_SHOWN = 0.05


@dataclass(frozen=True, slots=True)
class _Seen:
    # A view of a mesh: whether its place is known, and the seed that it follows from.
    task: Task
    place: bool
    seed: int


@dataclass(frozen=True, slots=True)
class _Said:
    # What `box` says of the largest thing in a view, `fails` if nothing is found, or the error; and
    # which share of what the view shows is no side or top of a box.
    state: str
    beyond: float


_judges: list[BatchJudge] = []


def _said(seen: _Seen) -> _Said:
    task = seen.task
    up = np.array(UP_AXES[task.up or "z"], dtype=np.float64)
    try:
        mesh = read_mesh(Path(task.file or ""))
        return _Said(_state(seen, mesh, up), measure_beyond_box(mesh, up, seen.seed))
    except Exception as exc:  # whatever it is, it costs no other shape
        return _Said(f"{type(exc).__name__}: {exc}", 1.0)


def _state(seen: _Seen, mesh: Mesh, up: FloatArray) -> str:
    task = seen.task
    if not _judges:
        _judges.append(BatchJudge())
    cloud = single_view(mesh, up, seen.seed, name=task.name, place=seen.place)
    facts = fact_rows(make_cloud_scene(cloud, up=up, metric=True))
    main = max(facts["thing_size"], key=_extent, default=("",))[0]
    verdicts = _judges[0].judge(facts)
    said = [str(v.state) for v in verdicts if v.model == BOX and v.thing == main]
    return said[0] if said else STATES[-1]


def _extent(thing_size: Sequence[str | int | float]) -> float:
    """Return the longest side of a thing: what is seen of a leg apart from its table is a lesser
    one.
    """
    return max(float(side) for side in thing_size[1:4])


def _row(found: Sequence[tuple[_Seen, _Said]], what: str, place: bool) -> Row:
    states = [
        said.state for seen, said in found if seen.place == place and what in _kinds(seen, said)
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


def _kinds(seen: _Seen, said: _Said) -> tuple[str, ...]:
    if seen.task.label == BOX:
        return (BOX,)
    return (OTHERS, SHOWN) if said.beyond > LEAST_SHOWN else (OTHERS,)


def measure(settings: Settings) -> Report:
    """Measure all tables; without the third-party data the benchmark is skipped."""
    folder = find_data_set("shapes")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    tasks = [task for task in list_file_tasks(folder)["meshes"] if task.label not in NOT_COUNTED]
    views = [
        _Seen(task, place, settings.first + nth)
        for nth, task in enumerate(tasks)
        for place in (True, False)
    ][: settings.number(2 * len(tasks))]
    found = list(zip(views, spread(_said, views, at_once=4), strict=True))
    kinds = (BOX, OTHERS, SHOWN)
    rows = [_row(found, what, place) for what in kinds for place in (True, False)]
    wrong: tuple[Row, ...] = tuple(
        {
            "shape": seen.task.name,
            "half": "held out" if is_held_out(seen.task.name) else "development",
            "label": seen.task.label,
            "place": "known" if seen.place else "not known",
            "box": said.state,
            "beyond a box": round(said.beyond, 3),
        }
        for seen, said in found
        if (seen.task.label == BOX) != (said.state == "holds")
        and said.state != "unknown"
        and (seen.task.label == BOX or said.state != "fails")
    )
    return Report(
        NAME,
        (Table("What box says", tuple(rows)), *([Table("Wrong", wrong)] if wrong else [])),
        {"shapes": hash_tree(folder), "views": len(views), "longest side, m": LONGEST_M},
        (
            "Wanted: at most .03 of other things held as boxes.",
            f"That show it: more than {LEAST_SHOWN:.0%} of what is seen lies behind the sides and "
            "the top of the least upright box round it (beyond a box), by the exact mesh.",
        ),
    )
