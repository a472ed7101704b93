"""Do texts of a crate, a gate and a bookcase hold of meshes, scans and pictures alike?

Three texts (benchmarks/own_texts) as a new user writes them who has read the tutorial of
docs/models.md, of things of boards and bars whose sizes were chosen before (three_things.py). A
scan is what a depth sensor with the noise of a Kinect sees of a thing on a floor, half a metre
long, from four places by chance, or from one; pictures are 24 rendered ones, by hand (the thing
fills them, from three heights) or of the demo's tour, which hardly looks into a crate. The texts of
crate and gate are also judged of the shapes that were made for a newcomer's (FACETLOG_DATA,
newcomer), if those are there. No text was changed after it had been judged.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from benchmarks.common import Report, Row, Settings, Table, find_data_set, hash_tree
from benchmarks.shapes.accuracy_newcomer import (
    OPTIONS,
    STATES,
    find_best_verdict,
    find_deciding_conditions,
)
from benchmarks.shapes.three_things import THINGS, by_hand, from_mesh, from_scan, on_a_tour
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.recognize import open_knowledge_base
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.read_shape import read_shape
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import reconstruct_views

__all__ = ["NAME", "TEXTS", "measure"]

NAME = "accuracy_three_inputs"
TEXTS = Path(__file__).resolve().parent / "own_texts"
NEWCOMER = {"crate": "oc", "gate": "ga"}


def _seen(views: ViewSet) -> Scene:
    return reconstruct_views(views, clock=StepClock())


INPUTS: Mapping[str, tuple[int, Callable[[str, int], Scene]]] = {
    "mesh": (1, lambda name, _: from_mesh(name)),
    "scan from four places": (4, lambda name, seed: from_scan(name, seed, places=4)),
    "scan from one place": (8, lambda name, seed: from_scan(name, seed, places=1)),
    "pictures by hand": (2, lambda name, seed: _seen(by_hand(name, seed))),
    "pictures of a tour": (2, lambda name, seed: _seen(on_a_tour(name, seed))),
}
"""How many seeds each has, and its scene of a thing and a seed."""


def _row(base: KnowledgeBase, name: str, kind: str, settings: Settings) -> Row:
    number, scene_of = INPUTS[kind]
    verdicts = [
        find_best_verdict(base, name, scene_of(name, seed)) for seed in settings.seeds(number)
    ]
    states = Counter(verdict.state for verdict in verdicts)
    others = Counter(
        by for verdict in verdicts if (by := find_deciding_conditions(verdict)) is not None
    )
    return {
        "text": name,
        "of": kind,
        "judged": len(verdicts),
        **{state.value: states[state] for state in STATES},
        "fails or is open by": "; ".join(others) or None,
    }


def _of_newcomer(base: KnowledgeBase, shapes: Path) -> Iterator[Row]:
    for name, prefix in NEWCOMER.items():
        for shape in sorted(shapes.glob(f"{prefix}[+-]*.ply")):
            verdict = find_best_verdict(base, name, read_shape(shape, OPTIONS))
            yield {
                "text": name,
                "shape": shape.stem,
                "should hold": shape.stem.startswith(f"{prefix}+"),
                "holds": verdict.state is State.HOLDS,
                "fails or is open by": find_deciding_conditions(verdict),
            }


def measure(settings: Settings) -> Report:
    """Return a row each text and kind of input, and one each of a newcomer's shapes."""
    folder = find_data_set("newcomer")
    with open_knowledge_base([TEXTS], trusted=True, raw=True) as base:
        rows = tuple(_row(base, name, kind, settings) for name in THINGS for kind in INPUTS)
        tables = [Table("Each text and input", rows)]
        if not isinstance(folder, str):
            shapes = tuple(_of_newcomer(base, folder / "shapes"))
            tables.append(Table("The texts of a newcomer's shapes", shapes))
    notes = (folder,) if isinstance(folder, str) else ()
    return Report(NAME, tuple(tables), {"texts": hash_tree(TEXTS)}, notes)
