"""What is recognised in pictures of furniture that someone else made, and of the boxes beside it?

Third-party sets of path-traced pictures under FACETLOG_DATA (pictures), each with what stands at
the origin and where plain cuboids stand beside it; without them the benchmark is skipped. Of each
set there is the answer of four, chair, table, box or none of these, for the thing at the origin,
and how many of the cuboids are held to be boxes. What is borderline, and what may be a plain
cuboid, is not counted (see accuracy_shapes). Sets with even and odd numbers are counted apart:
what is chosen by looking at one half is measured on the other.
"""

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, find_data_set, hash_tree
from benchmarks.shapes.shape_judging import CLASSES, COUNTED_AS, PERHAPS_BOXES
from facetlog.batch.labels import NONE, Truth
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.explaining.best_first import best_first
from facetlog.kb.explaining.proof import State
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import FloatArray

NAME = "accuracy_furniture"
# A thing is a cuboid if its bounds and the cuboid's have this much of both in common.
SAME = 0.5


@dataclass(frozen=True, slots=True)
class Answered:
    """What was answered for a set: `truth` is None where it is not counted; `boxes` of so many
    cuboids `beside` it were held to be boxes.
    """

    name: str
    label: str
    truth: str | None
    answer: str
    boxes: int
    beside: int

    @property
    def half(self) -> str:
        """Whether its number is even or odd."""
        return "odd" if int(self.name) % 2 else "even"

    @property
    def right(self) -> bool:
        """Whether it is counted and answered right."""
        return self.answer == self.truth

    @property
    def wrong(self) -> bool:
        """Whether it is counted and answered a class that it is not."""
        return self.truth is not None and self.answer not in (self.truth, NONE)

    def row(self) -> Row:
        """Return what is shown of it."""
        return {
            "set": self.name,
            "label": self.label,
            "answer": self.answer,
            "right": None if self.truth is None else self.right,
            "boxes": self.boxes if self.beside else None,
            "of": self.beside if self.beside else None,
        }


def measure(settings: Settings) -> Report:
    """Measure all sets, or the first so many of them."""
    folder = find_data_set("pictures")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    sets = sorted(path for path in folder.iterdir() if (path / "ground_truth.json").exists())
    judge = BatchJudge()
    found = [_answered(path, judge) for path in sets[: settings.number(len(sets))]]
    halves = [(half, [one for one in found if one.half == half]) for half in ("even", "odd")]
    kinds = [(kind, [one for one in found if one.truth == kind]) for kind in (*CLASSES, NONE)]
    return Report(
        NAME,
        (
            Table("Four answers", tuple(_counts([("all", found), *halves, *kinds]))),
            Table("Each set", tuple(one.row() for one in found)),
        ),
        {"sets": len(found), "data": hash_tree(folder)},
        (
            "wrong: answered a class that it is not; else what is not right was answered none.",
            "The even half was looked at when things were joined and measured from the ground, "
            "both when lines were scored by the views that should show them and boxes told apart, "
            "01 and 05 of the odd half when bars were found that rise from the rim of a seat.",
        ),
    )


def _answered(folder: Path, judge: BatchJudge) -> Answered:
    """Return what a set's pictures are answered to show."""
    views = read_views(folder)
    scene = reconstruct(views.views, name=folder.name, up=views.up, metric=views.metric)
    truth = json.loads((folder / "ground_truth.json").read_text(encoding="utf-8"))
    return of_scene(scene, truth, judge)


def of_scene(scene: Scene, truth: dict[str, object], judge: BatchJudge) -> Answered:
    """Return what a scene of that name is answered to show, where a set's ground truth is so."""
    bounds = _bounds(scene)
    held = [
        v for v in judge.judge(fact_rows(scene)) if v.state is State.HOLDS and v.model in CLASSES
    ]
    at_origin = min(bounds, key=lambda name: _away(bounds[name]), default=None)
    own = [v for v in held if v.thing == at_origin]
    label = str(truth["label"])
    beside = truth.get("other_boxes") or []
    assert isinstance(beside, list)
    are_boxes = {v.thing for v in held if v.model == "box"}
    taken: set[str] = set()
    for cuboid in map(_cuboid_bounds, beside):
        best = max(bounds, key=lambda name: _in_common(bounds[name], cuboid), default=None)
        if best in are_boxes and _in_common(bounds[best], cuboid) >= SAME:
            taken.add(best)
    return Answered(
        scene.name,
        label,
        _truth(label),
        best_first(own)[0].model if own else NONE,
        len(taken),
        len(beside),
    )


def _truth(label: str) -> str | None:
    if label in PERHAPS_BOXES:
        return None
    own = label if label in CLASSES else NONE
    return COUNTED_AS.get(label, Truth(own)).answer


def _bounds(scene: Scene) -> dict[str, FloatArray]:
    """Return the lowest and the highest coordinates (2, 3) of each thing."""
    memo = SceneMemo.of(scene)
    points = [memo.table.points[own] for own in memo.members]
    return {
        str(name): np.array([own.min(axis=0), own.max(axis=0)])
        for name, own in zip(memo.thing_names, points, strict=True)
    }


def _cuboid_bounds(cuboid: dict[str, object]) -> FloatArray:
    turn = np.radians(float(str(cuboid["turn_z_deg"])))
    c, s = abs(np.cos(turn)), abs(np.sin(turn))
    reach = np.array([[c, s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.array(cuboid["half_sides"])
    middle = np.array(cuboid["centre"])
    return np.array([middle - reach, middle + reach])


def _away(bounds: FloatArray) -> tuple[float, float]:
    """Return how far bounds are from the origin, seen from above, and then their middle."""
    outside = np.maximum(0.0, np.maximum(bounds[0], -bounds[1]))[:2]
    middle = bounds.mean(axis=0)[:2]
    return float(np.hypot(*outside)), float(np.hypot(*middle))


def _in_common(one: FloatArray, other: FloatArray) -> float:
    """Return the volume that two bounds have in common, as a share of what both take."""
    sides = np.minimum(one[1], other[1]) - np.maximum(one[0], other[0])
    common = float(np.maximum(sides, 0.0).prod())
    both = float(np.ptp(one, axis=0).prod() + np.ptp(other, axis=0).prod()) - common
    return common / both if both > 0.0 else 0.0


def _counts(groups: Iterable[tuple[str, Sequence[Answered]]]) -> Iterator[Row]:
    for name, group in groups:
        yield {
            "sets": name,
            "right": sum(one.right for one in group),
            "of": sum(one.truth is not None for one in group),
            "wrong": sum(one.wrong for one in group),
            "boxes beside": sum(one.boxes for one in group),
            "of cuboids": sum(one.beside for one in group),
        }
