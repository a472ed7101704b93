"""Do texts of someone who had read docs/models.md once hold where they should?

Third-party texts under FACETLOG_DATA (newcomer/models), each judged of the shapes that were made
for it (newcomer/shapes: metres, z up; `pf+NAME` is a picture_frame, `pf-NAME` is none, and so on).
Of each there is the state, and the conditions by which it does not hold. No text is changed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.common import Report, Row, Settings, Table, find_data_set, hash_tree
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.kb.recognize import open_knowledge_base
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape
from facetlog.perception.shapes.shape_options import UP_AXES

NAME = "accuracy_newcomer"
MODELS = {
    "bed": "bed",
    "ga": "gate",
    "oc": "open_crate",
    "pf": "picture_frame",
    "ss": "step_stool",
}
STATES = (State.HOLDS, State.UNKNOWN, State.FAILS)
OPTIONS = ShapeOptions(up=UP_AXES["z"], unit="m", override=True)


@dataclass(frozen=True, slots=True)
class Trial:
    """A text judged of a shape: the best verdict on its things, and whether one is `wanted`."""

    shape: str
    wanted: bool
    verdict: Verdict

    @property
    def holds(self) -> bool:
        """Whether the text holds of a thing in the shape."""
        return self.verdict.state is State.HOLDS

    def row(self) -> Row:
        """Return what is shown of it."""
        return {
            "model": self.verdict.model,
            "shape": self.shape,
            "should hold": self.wanted,
            "state": self.verdict.state.value,
            "degree": round(self.verdict.degree, 2),
            "fails or is open by": find_deciding_conditions(self.verdict),
        }


def tried(folder: Path) -> tuple[Trial, ...]:
    """Return every text of the folder judged of the shapes that were made for it, text by text."""
    with open_knowledge_base([folder / "models"], trusted=True, raw=True) as base:
        shapes = sorted((folder / "shapes").glob("*.ply"))
        return tuple(_trial(base, shape) for shape in shapes)


def _trial(base: KnowledgeBase, shape: Path) -> Trial:
    prefix, wanted, _ = shape.stem.partition("+")
    if not wanted:
        prefix = shape.stem.partition("-")[0]
    best = find_best_verdict(base, MODELS[prefix], read_shape(shape, OPTIONS))
    return Trial(shape.stem, bool(wanted), best)


def find_best_verdict(base: KnowledgeBase, model: str, scene: Scene) -> Verdict:
    """Return what a model says of the thing of a scene that it fits best; ValueError if there is
    none.
    """

    def on_demand() -> Iterator[Fact]:
        return (fact.row for fact in facts_on_demand(scene))

    facts = [fact.row for fact in scene_facts(scene)]
    name = base.load_scene(scene.name, facts, on_demand=on_demand).name
    things = [str(fact[1]) for fact in facts if fact[0] == "thing"]
    every = [base.judge(name, model, thing) for thing in things]
    base.drop_scene(name)
    return max(every, key=lambda verdict: (-STATES.index(verdict.state), verdict.degree))


def find_deciding_conditions(verdict: Verdict) -> str | None:
    """Return the labels of the conditions that fail, then of the open ones; None if all hold."""
    labels = [c.label for state in STATES[:0:-1] for c in verdict.list_conditions_in_state(state)]
    return ", ".join(labels) or None


def _counts(found: Sequence[Trial]) -> Row:
    positives = [trial for trial in found if trial.wanted]
    negatives = [trial for trial in found if not trial.wanted]
    return {
        "should hold": len(positives),
        "of these hold": sum(trial.holds for trial in positives),
        "should not": len(negatives),
        "of these do": sum(trial.holds for trial in negatives),
    }


def measure(_settings: Settings) -> Report:
    """Return all trials; without the third-party data the benchmark is skipped."""
    folder = find_data_set("newcomer")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    found = tried(folder)
    return Report(
        NAME,
        (
            Table("Texts that a newcomer wrote", (_counts(found),)),
            Table("Each text and shape", tuple(trial.row() for trial in found)),
        ),
        {"texts and shapes": hash_tree(folder)},
        ("Wanted: 12 of 13 hold that should, 1 of 20 that should not.",),
    )
