"""Recognition while views come: one view after the other, a verdict after each."""

import re
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from facetlog.errors import InputError
from facetlog.perception.step_clock import StepClock

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition, Verdict
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.perception.online.online_scene import OnlineScene
    from facetlog.perception.scene import Scene
    from facetlog.perception.types import FloatArray, PoseErrorKind, View

__all__ = ["Goal", "Stop", "StreamStep", "judged", "recognise_stream", "steps"]

Facts: TypeAlias = tuple[tuple[str | int | float, ...], ...]
SHOWN = 2
"""Digits of a degree that are shown: it is written in whole per cents."""
GOAL = re.compile(r"\s*([a-z]\w*)\s*>=\s*(\d+(?:\.\d+)?)\s*%\s*")


@dataclass(frozen=True, slots=True)
class Goal:
    """A model that is to hold to a degree (0 to 1) at least."""

    model: str
    degree: float

    @classmethod
    def parse(cls, text: str) -> "Goal":
        """Parse a goal such as "table >= 90%"; raise InputError for another form.

        >>> Goal.parse("table >= 90%")
        Goal(model='table', degree=0.9)
        """
        match = GOAL.fullmatch(text)
        if match is None or float(match[2]) > 100.0:
            raise InputError(f'--until {text!r}: give a model and a degree, as "table >= 90%"')
        return cls(match[1], float(match[2]) / 100.0)

    def is_met_by(self, degree: float) -> bool:
        """Return whether a degree is high enough, in whole per cents, as it is shown.

        >>> Goal("table", 0.9).is_met_by(0.896), Goal("table", 0.9).is_met_by(0.894)
        (True, False)
        """
        return round(degree, SHOWN) >= self.degree

    def reached(self, recognition: "Recognition") -> bool:
        """Return whether something is of this model to the degree."""
        return any(v.model == self.model and self.is_met_by(v.degree) for v in recognition.best)


@dataclass(frozen=True, slots=True)
class Stop:
    """When no further view is wanted: a goal is reached, the largest standard deviation (of the
    scene's unit) is at most `sd_limit`, or so many views were used.
    """

    until: Goal | None = None
    sd_limit: float | None = None
    max_views: int | None = None

    def reason(self, step: "StreamStep") -> str:
        """Return why to stop after a step; empty if not."""
        found = step.recognition
        if found is not None and self.until is not None and self.until.reached(found):
            return f"{self.until.model} holds to {self.until.degree:.0%} at least"
        sd = step.largest_sd
        if sd is not None and self.sd_limit is not None and sd <= self.sd_limit:
            return f"the largest standard deviation is below {self.sd_limit:g}"
        if self.max_views is not None and step.used >= self.max_views:
            return f"{self.max_views} views were used"
        return ""


@dataclass(frozen=True, eq=False, slots=True)
class StreamStep:
    """The state after a view.

    `view` is its name, empty of the last step, in which what is in store was adjusted together;
    `used` is how many views are used so far, `problem` why this one is not, or another that turned
    out to contradict them. Without scene and
    recognition there was too little to see. What the views saw (`Scene.sights`) is that of the last
    search for faces. `facts` are those that were judged. `ended` of the last step says why no
    further view was read.
    """

    view: str
    used: int
    scene: "Scene | None" = None
    facts: Facts = ()
    recognition: "Recognition | None" = None
    problem: str = ""
    ended: str = ""

    @property
    def largest_sd(self) -> float | None:
        """The largest standard deviation of a vertex, in the scene's unit."""
        import numpy as np

        if self.scene is None or not self.scene.vertices:
            return None
        covs = np.array([vertex.cov for vertex in self.scene.vertices])
        return float(np.sqrt(np.linalg.eigvalsh(covs)[:, -1].max()))

    @property
    def undecided(self) -> "tuple[Verdict, ...]":
        """The verdicts that are open."""
        from facetlog.kb.explaining.proof import State

        if self.recognition is None:
            return ()
        return tuple(v for v in self.recognition.verdicts if v.state is State.UNKNOWN)


def recognise_stream(
    views: "Iterable[View]",
    *,
    name: str = "views",
    up: "FloatArray | None" = None,
    metric: bool = False,
    error_kind: "PoseErrorKind | None" = None,
    base: "KnowledgeBase | None" = None,
    stop: Stop | None = None,
    polish: bool = True,
    clock: StepClock | None = None,
) -> Iterator[StreamStep]:
    """Yield a step after each view, and a last one, for which all stored views are adjusted
    together (without `polish` it is what the last view left).

    Nothing is drawn from `views` beyond the view after which `stop` is reached, so they may be a
    camera that has still to take them. `up`, `metric` as in `ViewSet`; `error_kind` is that of the
    poses whose covariance is given, errors of odometry if not said; judged by the models of `base`,
    else by the built-in ones.
    """
    from facetlog.perception.online.online_scene import OnlineScene
    from facetlog.perception.types import PoseErrorKind

    kind = error_kind or PoseErrorKind.ODOMETRY
    online = OnlineScene(name=name, up=up, metric=metric, error_kind=kind, clock=clock)
    yield from steps(online, views, base=base, stop=stop, polish=polish)


def steps(
    online: "OnlineScene",
    views: "Iterable[View]",
    *,
    base: "KnowledgeBase | None" = None,
    stop: Stop | None = None,
    polish: bool = True,
) -> Iterator[StreamStep]:
    """Yield steps as `recognise_stream`, into a scene that the caller holds."""
    from facetlog.pipeline import open_models

    ended = "there were no more views"
    with ExitStack() as stack:
        models = base or stack.enter_context(open_models())
        for view in views:
            update = online.add(view)
            facts, found = judged(models, online)
            step = StreamStep(view.name, online.used, online.scene, facts, found, update.problem)
            yield step
            if reason := (stop or Stop()).reason(step):
                ended = reason
                break
        problem = online.finish(polish=polish)
        facts, found = judged(models, online)
        yield StreamStep("", online.used, online.scene, facts, found, problem, ended)


def judged(models: "KnowledgeBase", online: "OnlineScene") -> "tuple[Facts, Recognition | None]":
    """Return the facts of what is known, and the verdicts on them; none of an unknown scene."""
    from facetlog.kb.recognize import judge_scene
    from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts

    scene = online.scene
    if scene is None:
        return (), None
    with online.clock.step("facts"):
        facts = tuple(fact.row for fact in scene_facts(scene))
    with online.clock.step("verdicts"):
        found = judge_scene(
            models,
            scene.name,
            facts,
            on_demand=lambda: (f.row for f in facts_on_demand(scene)),
        )
    return facts, found
