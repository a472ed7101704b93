"""How often is the first name right among all models, on upright meshes of others?

Third-party shapes under FACETLOG_DATA (shapes/labels.csv). The first name is the first verdict that
holds, in the order in which the program lists them; none is right where no model describes the
thing. A wrong name is worse than none. Wanted are .85 right and .05 wrong.
"""

import multiprocessing
import os
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from benchmarks.common import Report, Row, Settings, Table, find_data_set, hash_tree
from benchmarks.processes import WORKERS
from benchmarks.shapes.accuracy_shapes import list_file_tasks
from benchmarks.shapes.shape_judging import Task, scene_of
from facetlog.batch.labels import ERROR, NONE
from facetlog.errors import FacetlogError
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.explaining.best_first import best_first
from facetlog.perception.facts.all_facts import fact_rows

NAME = "accuracy_names"
# Names that are right for a label, where they are not the label alone; of other labels no model.
NAMES: Mapping[str, Collection[str]] = {
    **{name: (name,) for name in ("chair", "box", "cabinet", "door", "sofa", "bench", "bed")},
    "armchair": ("chair", "sofa"),
    "table": ("table", "desk"),
    "desk": ("desk", "table"),
    "shelf": ("shelf", "bookcase"),
    "picture": ("picture_frame",),
    "sofa_or_bench": ("sofa", "bench"),
    **{name: (name, "step_stool") for name in ("stairs", "stool")},
    "open_box": ("crate", NONE),
    "carton": ("box",),
    "cuboid_table": ("box", "table"),
    "ottoman": ("stool", "box"),
    "tv_unit": ("shelf", "cabinet", "bookcase", "table", "bench"),
    **dict.fromkeys(("computer", "cinder_block", "board"), ("box", NONE)),
}


@dataclass(frozen=True, slots=True)
class Named:
    """A shape and its first name, which is right, wrong or none."""

    task: Task
    name: str

    @property
    def is_right(self) -> bool:
        return self.name in NAMES.get(self.task.label, (NONE,))

    @property
    def is_wrong(self) -> bool:
        return not self.is_right and self.name != NONE


_judges: list[BatchJudge] = []


def _open_judge() -> None:
    _judges.append(BatchJudge())


def _name_shape(task: Task) -> Named:
    try:
        facts = fact_rows(scene_of(task), {functor for functor, _ in _judges[0].needed})
        holding = best_first(_judges[0].judge(facts))
    except FacetlogError:
        return Named(task, ERROR)
    return Named(task, holding[0].model if holding else NONE)


def name_shapes(tasks: Sequence[Task], workers: int = WORKERS) -> tuple[Named, ...]:
    """Return the first names of all shapes, in their order."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with multiprocessing.get_context("spawn").Pool(workers, _open_judge) as pool:
        return tuple(pool.imap(_name_shape, tasks, chunksize=1))


def _count(of: str, found: Iterable[Named]) -> Row:
    every = tuple(found)
    right, wrong = sum(one.is_right for one in every), sum(one.is_wrong for one in every)
    names = Counter(one.name for one in every if not one.is_right)
    return {
        "of": of,
        "counted": len(every),
        "right": right,
        "share": right / len(every),
        "wrong": wrong,
        "share wrong": wrong / len(every),
        "not right": ", ".join(f"{name} {count}" for name, count in names.most_common()),
    }


def _count_by(found: Sequence[Named], keys: Sequence[str]) -> tuple[Row, ...]:
    groups: dict[str, list[Named]] = {}
    for one, key in zip(found, keys, strict=True):
        groups.setdefault(key, []).append(one)
    return tuple(_count(key, some) for key, some in groups.items())


def measure(settings: Settings) -> Report:
    """Measure all tables; seeds play no part, and without the data the benchmark is skipped."""
    del settings
    folder = find_data_set("shapes")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    found = name_shapes(list_file_tasks(folder)["meshes"])
    tables = [
        Table("All", (_count("all", found),)),
        Table("By source", _count_by(found, [one.task.name.split("/")[0] for one in found])),
        Table("By label", _count_by(found, [one.task.label for one in found])),
    ]
    if wrong := [one for one in found if one.is_wrong]:
        rows = ({"shape": o.task.name, "label": o.task.label, "name": o.name} for o in wrong)
        tables.append(Table("Wrong names", tuple(rows)))
    return Report(NAME, tuple(tables), {"shapes": hash_tree(folder)})
