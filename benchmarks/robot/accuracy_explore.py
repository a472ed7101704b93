"""How soon and how well are things recognised when the next view is chosen?

Worlds with a thing and clutter beside it, starts anywhere round it, seeds in turn; the robot's
wheels slip as those of the simulated robot do (explored_world.py). `explore` chooses views as
`facetlog collect --explore` does, without a goal, so it decides itself when to end; `until` does
with the thing's own name as the goal, `--until "table >= 80%"`; `random` takes as many views as
`explore` from the same candidates by chance, after the same first ones; `ring 8` and `ring 24`
drive round once, evenly. All views of a run are judged at once, with the poses corrected by the
pictures. Keep-out circle and rings are as large as the thing's real size asks for: models of
furniture are looked at by a robot as small as they are, and metres are those of that robot.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.common import Cell, Report, Settings, Table
from benchmarks.knowledge.calibration_scenes import get_world_truth
from benchmarks.processes import spread
from benchmarks.robot.explored_world import KEEP_OUT, ExploredWorld
from facetlog.errors import FacetlogError
from facetlog.exploring.choice import beginning
from facetlog.exploring.explorer import Explorer, Judge
from facetlog.exploring.open_questions import Interest, find_needs
from facetlog.judging.view_verdicts import ViewVerdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import open_models, recognize_views
from facetlog.robot.collecting.next_stop import Chosen, Finished
from facetlog.stream import Goal

NAME = "accuracy_explore"
SEEDS = 10
# Worlds, and the name that `until` asks for there.
WORLDS = {"block": "box", "table": "table", "chair": "chair", "stool": "stool", "desk": "desk"}
MOST = 24
WAYS = ("explore", "until", "random", "ring 8", "ring 24")
WANTED = 0.8  # the degree of `until`


@dataclass(frozen=True, slots=True)
class Trial:
    """One run: the world, the way views were chosen, their number, metres, how near the robot came
    (m), and the name that stands first of the thing at the target, empty if there is none.
    """

    world: str
    seed: int
    way: str
    views: int
    metres: float
    nearest: float
    name: str

    @property
    def is_right(self) -> bool:
        """Whether the name is one of the thing's."""
        return bool(self.name) and get_world_truth(self.world, self.name) is True

    @property
    def is_wrong(self) -> bool:
        """Whether it is one of other things."""
        return bool(self.name) and get_world_truth(self.world, self.name) is False


def measure(settings: Settings) -> Report:
    """Measure all worlds over the seeds, by each way."""
    seeds = settings.seeds(SEEDS)
    worlds = [(name, seed) for seed in seeds for name in WORLDS]
    return report([trial for trials in spread(_trials, worlds) for trial in trials], seeds)


def _trials(world: tuple[str, int]) -> list[Trial]:
    return trials_of(*world)


def report(trials: Sequence[Trial], seeds: range) -> Report:
    """Return the tables of some trials, of all worlds over these seeds."""
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
        {"seeds": len(seeds), "first seed": seeds.start, "most views": MOST, "keep-out": KEEP_OUT},
        (
            "right, wrong: the name that stands first of the thing at the target is one of the "
            "thing's, or is not; the others have no name, or one of which people would not agree.",
            "nearest: of any part of the robot to the target in any run, m. Seeds 0 to 5 were "
            "looked at while the choice was made, later ones (--first-seed 6) were not.",
        ),
    )


def _row(way: str, trials: Sequence[Trial]) -> dict[str, Cell]:
    return {
        "views chosen by": way,
        "right": f"{sum(t.is_right for t in trials)} of {len(trials)}",
        "wrong": sum(t.is_wrong for t in trials),
        "views": round(float(np.mean([t.views for t in trials])), 1),
        "most": max(t.views for t in trials),
        "metres": round(float(np.mean([t.metres for t in trials])), 1),
        "nearest": round(min(t.nearest for t in trials), 2),
    }


def trials_of(name: str, seed: int) -> list[Trial]:
    """Return one run by each way."""
    drive, until = ExploredWorld(name, seed), ExploredWorld(name, seed)
    explored(drive)
    explored(until, Goal(WORLDS[name], WANTED))
    return [
        _trial(drive, "explore"),
        _trial(until, "until"),
        _trial(take_random_views(name, seed, len(drive.views)), "random"),
        *(_trial(_ring(name, seed, count), f"ring {count}") for count in (8, 24)),
    ]


def explored(drive: ExploredWorld, goal: Goal | None = None) -> Finished:
    """Let a robot explore. Return why it ended."""
    explorer = Explorer(_judge(drive), goal=goal, most=MOST)
    while isinstance(found := explorer.next_stop(drive.around, tuple(drive.taken)), Chosen):
        wanted = found.stop.robot
        candidates = drive.around.candidates(len(drive.taken) + 1)
        drive.take(next(each for each in candidates if each.stop.robot == wanted))
    return found


def take_random_views(name: str, seed: int, count: int) -> ExploredWorld:
    """Return so many views by chance, of which the first are those that exploring begins with."""
    drive, rng = ExploredWorld(name, seed), np.random.default_rng(seed)
    while len(drive.views) < count:
        around = drive.around
        candidates = around.candidates(len(drive.taken) + 1)
        places = [view.pose.centre for view in drive.taken]
        first = None
        if len(places) < FEWEST_VIEWS:
            first = beginning(candidates, around.target, places)
        drive.take(first or candidates[int(rng.integers(len(candidates)))])
    return drive


def _ring(name: str, seed: int, count: int) -> ExploredWorld:
    drive = ExploredWorld(name, seed)
    for candidate in drive.ring(count):
        drive.take(candidate)
    return drive


def _judge(drive: ExploredWorld) -> Judge:
    """Judge the views of a drive as the process beside a collection does."""

    def judge(count: int, interest: Interest) -> ViewVerdict:
        try:
            found = recognize_views(drive.view_set(count), base=_base(), clock=StepClock())
        except FacetlogError as exc:
            return ViewVerdict(count, fault=str(exc))
        best = tuple(v.summary for v in found.recognition.best)
        return ViewVerdict(count, best, needs=find_needs(found.scene, found.recognition, interest))

    return judge


def get_leading_name(drive: ExploredWorld) -> str:
    """Return the name that stands first of the thing at the target, by all views; empty if none
    does.
    """
    around = drive.around
    places = np.array([view.pose.centre for view in drive.views])
    interest = Interest(around.target, around.radius, places)
    needs = _judge(drive)(len(drive.views), interest).needs
    return "" if needs is None or needs.lead is None else needs.lead.model


def _trial(drive: ExploredWorld, way: str) -> Trial:
    """Return what all views at once come to."""
    count, name = len(drive.views), get_leading_name(drive)
    return Trial(drive.name, drive.seed, way, count, drive.robot.driven, drive.nearest, name)


@cache
def _base() -> KnowledgeBase:
    return open_models()
