"""Judging of forms: one model, and its verdicts on solids."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.scene import Scene
from facetlog.prototype.assembly import Form
from facetlog.prototype.fit import Try
from facetlog.prototype.objective import Judged, compute_margins

SCENE = "drawn"
THING = "t1"


@dataclass(frozen=True, slots=True)
class Candidate:
    """A form, and what the model says of it with some sizes."""

    form: Form
    judged: Judged


class Workbench:
    """A model of a knowledge base, asked about exact solids.

    `report` is called with the number of solids that were judged.
    `missed` are the labels that solids missed together, each set with the best of those solids.
    """

    def __init__(
        self, base: KnowledgeBase, model: str, report: Callable[[int], None] | None = None
    ) -> None:
        self._base, self._report = base, report
        self.model = model
        self.judged = 0
        self.missed: dict[frozenset[str], Candidate] = {}

    def judge(self, scene: Scene, sizes: Mapping[str, float]) -> Judged:
        """Return what the model says of the only thing in a scene."""
        self.judged += 1
        if self._report is not None:
            self._report(self.judged)
        self._base.load_scene(
            SCENE,
            (fact.row for fact in scene_facts(scene)),
            on_demand=lambda: (fact.row for fact in facts_on_demand(scene)),
        )
        try:
            verdict = self._base.judge(SCENE, self.model, THING)
        finally:
            self._base.drop_scene(SCENE)
        return Judged(dict(sizes), scene, verdict, compute_margins(verdict))

    def trying(self, form: Form) -> Try:
        """Judge a form of any sizes."""

        def judge(sizes: Mapping[str, float]) -> Judged | None:
            try:
                scene = form.scene(sizes)
            except ValueError:
                return None
            found = self.judge(scene, sizes)
            missed = frozenset(found.missed)
            kept = self.missed.get(missed)
            is_solid = bool(scene.bodies)
            if is_solid and (kept is None or found.rank > kept.judged.rank):
                self.missed[missed] = Candidate(form, found)
            return found

        return judge

    def failing_alone(self, label: str) -> Candidate | None:
        """Return the best of the solids that were found to fail this condition, and nothing
        else.
        """
        found = self.missed.get(frozenset({label}))
        return found if found is not None and found.judged.fails_alone == label else None
