"""How soon and how well are things recognised when the next view is chosen?

Worlds with one thing and starts anywhere round it, seeds in turn. `explore` chooses views as
`facetlog collect --explore` does, without a goal, so it decides itself when to end; `random` takes
as many views from the same candidates by chance, after the same first ones; `ring 8` and `ring 24`
drive round once, evenly. No robot is driven: each view is rendered from the pose that was chosen,
so poses are exact, and ways are those of the routes. All views of a run are then judged at once.
Rings and keep-out circle are as large as the thing's real size asks for: models of furniture are
looked at by a robot as small as they are, and metres are those of that robot.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from benchmarks.calibration_scenes import world_truth
from benchmarks.common import Cell, Report, Settings, Table, command
from benchmarks.recognition import Run, in_metres, recognised
from facetlog.errors import FacetlogError
from facetlog.exploring.choice import beginning
from facetlog.exploring.explorer import Explorer, Judge
from facetlog.exploring.needs import Interest, needs_of
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.fewest_views import FEWEST_VIEWS
from facetlog.perception.step_clock import StepClock
from facetlog.perception.types import Pose, View
from facetlog.pipeline import FrontEnd, open_models, recognize_views
from facetlog.robot.camera.checks import Quality
from facetlog.robot.collecting.mount import DEFAULT_MOUNT, LENGTHS, PARAMETERS
from facetlog.robot.collecting.next_stop import Around, Chosen
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.record import Taken
from facetlog.robot.collecting.ring_views import Candidate
from facetlog.robot.collecting.route import Circle
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.head.sony_models import EVI_D30
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import BLOCK_CENTRE, INCH, make_world
from facetlog.robot.tour import tour_camera
from facetlog.view_verdicts import ViewVerdict

__all__ = ["NAME", "Trial", "main", "measure", "report", "trials_of"]

NAME = "accuracy_explore"
SEEDS = 5
WORLDS = ("block", "table", "chair", "stool", "desk")
MOST = 24
# The keep-out circle, with the robot's radius and the planner's clearance, m: the inner ring is
# then as far off as the paper's tour; and what is kept free besides.
CLOSED, KEPT_FREE = 0.75 + 0.25 + 0.03, 0.05
# Where the robot starts, from the target, m; the height that is aimed at: a block's middle, m.
START, AIM = 1.5, 0.08
WAYS = ("explore", "random", "ring 8", "ring 24")


@dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """One run: the world, the way views were chosen, their number, metres and what it came to."""

    world: str
    way: str
    views: int
    metres: float
    run: Run

    @property
    def is_right(self) -> bool:
        """Whether the name that stands first is one of the thing's."""
        return self.run.first is not None and world_truth(self.world, self.run.first) is True


def measure(settings: Settings) -> Report:
    """All worlds over the seeds, by each way."""
    seeds = settings.seeds(SEEDS)
    return report(
        [trial for name in WORLDS for seed in seeds for trial in trials_of(name, seed)], seeds
    )


def report(trials: Sequence[Trial], seeds: range) -> Report:
    """The tables of some trials, of all worlds over these seeds."""
    return Report(
        NAME,
        (
            Table("All worlds", tuple(_row(w, [t for t in trials if t.way == w]) for w in WAYS)),
            Table(
                "Each world",
                tuple(
                    {
                        "world": name,
                        **_row(w, [t for t in trials if (t.way, t.world) == (w, name)]),
                    }
                    for name in WORLDS
                    for w in WAYS
                ),
            ),
        ),
        {"seeds": len(seeds), "first seed": seeds.start, "most views": MOST},
        ("right: the name that stands first is one of the thing's.",),
    )


def _row(way: str, trials: Sequence[Trial]) -> dict[str, Cell]:
    return {
        "views chosen by": way,
        "right": f"{sum(t.is_right for t in trials)} of {len(trials)}",
        "views": round(float(np.mean([t.views for t in trials])), 1),
        "most": max(t.views for t in trials),
        "metres": round(float(np.mean([t.metres for t in trials])), 1),
    }


class _Drive:
    """A robot without a clock before a world: it is where it was sent, and sees what is there."""

    def __init__(self, name: str, seed: int) -> None:
        self.name, self.seed = name, seed
        self.world: World = make_world(name, seed)
        scale = self._scale = self.world.model_scale
        target = scale * np.array([*(INCH * np.array(BLOCK_CENTRE)), AIM])
        angle = float(np.random.default_rng(seed).uniform(-np.pi, np.pi))
        x, y = target[:2] + scale * START * np.array([math.cos(angle), math.sin(angle)])
        values = [
            value * scale if part in LENGTHS else value
            for part, value in zip(PARAMETERS, DEFAULT_MOUNT.values, strict=True)
        ]
        closed = (Circle(float(target[0]), float(target[1]), scale * CLOSED),)
        mount = DEFAULT_MOUNT.with_values(tuple(values))
        reach = Reach(mount, EVI_D30.limits, tour_camera(), closed)
        here = Pose2(float(x), float(y), angle + math.pi)
        radius = scale * (CLOSED + KEPT_FREE)
        pace = Pace(speed=scale * Pace().speed)
        self.around = Around(target, radius, angle, reach, pace, here)
        self.taken: list[Taken] = []
        self.views: list[View] = []
        self._way = 0.0

    @property
    def metres(self) -> float:
        """Driven so far, as the robot counts."""
        return self._way / self._scale

    def take(self, candidate: Candidate) -> None:
        """Goes there and takes the view."""
        stop, pose = candidate.stop, candidate.pose
        number = len(self.taken)
        small = Pose(pose.rotation, pose.centre / (INCH * self._scale))
        # The noise of a view follows from its place among all.
        (view,) = views_of(self.world, [small], tour_camera(), seed=1000 * self.seed + number)
        self.views.append(replace(view, name=stop.view.name))
        self.taken.append(_taken(stop.number, stop.view.name, pose, stop.robot))
        self._way += candidate.way
        self.around = replace(self.around, here=stop.robot)

    def judged(self, way: str) -> Trial:
        """What all views at once come to."""
        view_set = in_metres(f"{self.name}-{self.seed}", self.views, self.world.model_scale)
        run = recognised(view_set, FrontEnd.LINES)
        return Trial(self.name, way, len(self.views), self.metres, run)


def _taken(number: int, name: str, pose: Pose, robot: Pose2) -> Taken:
    sure = np.zeros((6, 6))
    return Taken(
        number, name, pose, sure, robot, robot, 0.0, 0.0, 0, 0.0, Quality(1.0, 1.0, 0.0), ()
    )


def _judge(drive: _Drive) -> Judge:
    """Judges the views of a drive as the process beside a collection does."""

    def judge(count: int, interest: Interest) -> ViewVerdict:
        views = in_metres("explored", drive.views[:count], drive.world.model_scale)
        try:
            found = recognize_views(views, base=_base(), clock=StepClock())
        except FacetlogError as exc:
            return ViewVerdict(count, fault=str(exc))
        best = tuple(v.summary for v in found.recognition.best)
        return ViewVerdict(count, best, needs=needs_of(found.scene, found.recognition, interest))

    return judge


def trials_of(name: str, seed: int) -> list[Trial]:
    """One run by each way."""
    explored = _Drive(name, seed)
    explorer = Explorer(_judge(explored), most=MOST)
    while isinstance(found := explorer.next_stop(explored.around, tuple(explored.taken)), Chosen):
        number = len(explored.taken) + 1
        wanted = found.stop
        explored.take(
            next(
                each
                for each in explored.around.candidates(number)
                if each.stop.robot == wanted.robot
            )
        )
    return [
        explored.judged("explore"),
        _random(name, seed, len(explored.views)).judged("random"),
        *(_ring(name, seed, count).judged(f"ring {count}") for count in (8, 24)),
    ]


def _random(name: str, seed: int, count: int) -> _Drive:
    drive, rng = _Drive(name, seed), np.random.default_rng(seed)
    while len(drive.views) < count:
        candidates = drive.around.candidates(len(drive.taken) + 1)
        places = [view.pose.centre for view in drive.taken]
        first = None
        if len(places) < FEWEST_VIEWS:
            first = beginning(candidates, drive.around.target, places)
        drive.take(first or candidates[int(rng.integers(len(candidates)))])
    return drive


def _ring(name: str, seed: int, count: int) -> _Drive:
    drive = _Drive(name, seed)
    start = drive.around.first
    for k in range(count):
        turned = replace(drive.around, first=start + math.tau * k / count)
        drive.take(turned.candidates(k + 1)[0])
    return drive


@cache
def _base() -> KnowledgeBase:
    return open_models()


main = command(NAME, __doc__, measure)

if __name__ == "__main__":
    main(None)
