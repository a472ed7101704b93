"""Time of a run by stage and by model, and which conditions could not be specialised."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from time import process_time
from typing import Any, Self

from facetlog.kb.brief_verdict import BriefVerdict, Conditions, Cost

STAGES = ("read", "facts", "judge")
"""A scene file is read, facts are made of it, the models are judged."""


@dataclass(slots=True)
class Profile:
    """Sums over the scenes of a run.

    `stages` are seconds of processor time of the workers, `costs` by model what Prolog took of it;
    `conditions` by model, the same whatever the scenes.
    """

    conditions: Mapping[str, Conditions] = field(default_factory=dict)
    scenes: int = 0
    stages: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    costs: defaultdict[str, Cost] = field(default_factory=lambda: defaultdict(Cost))

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add what is done within to a stage."""
        start = process_time()
        try:
            yield
        finally:
            self.stages[stage] += process_time() - start

    def add(self, verdicts: Iterable[BriefVerdict]) -> None:
        """Count a scene that was judged."""
        self.scenes += 1
        for verdict in verdicts:
            self.costs[verdict.model] += verdict.cost

    def __iadd__(self, other: Self) -> Self:
        self.conditions = other.conditions or self.conditions
        self.scenes += other.scenes
        for stage, seconds in other.stages.items():
            self.stages[stage] += seconds
        for model, cost in other.costs.items():
            self.costs[model] += cost
        return self

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        models = {
            model: {
                "conditions": conditions.count,
                "interpreted": list(conditions.interpreted),
                **asdict(self.costs[model]),
            }
            for model, conditions in self.conditions.items()
        }
        stages = {stage: self.stages[stage] for stage in STAGES}
        return {"scenes": self.scenes, "stages": stages, "models": models}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Return the profile of plain data that `to_json` made."""
        profile = cls(scenes=data["scenes"])
        profile.stages.update(data["stages"])
        conditions = {}
        for model, said in data["models"].items():
            conditions[model] = Conditions(said["conditions"], tuple(said["interpreted"]))
            profile.costs[model] = Cost(said["candidates"], said["inferences"], said["seconds"])
        profile.conditions = conditions
        return profile

    def lines(self) -> Iterator[str]:
        """Yield all of it as text: milliseconds and numbers are those of a scene."""
        scenes = max(1, self.scenes)
        spent = ", ".join(f"{s} {1e3 * self.stages[s] / scenes:.2f} ms" for s in STAGES)
        yield f"CPU time a scene: {spent} ({self.scenes} judged)"
        width = max([len("model"), *map(len, self.conditions)])
        heads = ("conditions", "specialised", "candidates", "inferences", "CPU ms")
        yield f"{'model':{width}}  {'  '.join(heads)}"
        for model, conditions in self.conditions.items():
            cost, specialised = self.costs[model], conditions.count - len(conditions.interpreted)
            values = (
                f"{conditions.count}",
                f"{specialised}",
                f"{cost.candidates / scenes:.1f}",
                f"{cost.inferences / scenes:.0f}",
                f"{1e3 * cost.seconds / scenes:.2f}",
            )
            cells = (f"{v:>{len(head)}}" for v, head in zip(values, heads, strict=True))
            yield f"{model:{width}}  {'  '.join(cells)}"
        for model, conditions in self.conditions.items():
            if conditions.interpreted:
                yield f"left to the interpreter: {model}: {', '.join(conditions.interpreted)}"
