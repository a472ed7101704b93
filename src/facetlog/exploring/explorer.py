"""Explores a target: first views beside one another, then the best next one until none is needed.

What is undecided after the views so far is asked of a judge (in a process of its own while a robot
is driven); the choice itself is a pure function (choice.py).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from facetlog.errors import EngineError
from facetlog.exploring.choice import Choice, beginning, choose, undecided
from facetlog.exploring.needs import Interest, Needs
from facetlog.perception.fewest_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.next_stop import CHOSEN, EXPLORED, Around, Chosen, Finished
from facetlog.robot.collecting.record import Taken
from facetlog.robot.collecting.ring_views import Candidate
from facetlog.stream import Goal
from facetlog.view_verdicts import ViewVerdict

__all__ = ["Explorer", "Judge"]

Judge: TypeAlias = Callable[[int, Interest], ViewVerdict]
"""The verdict on the first so many views, with what is undecided of what is of interest."""


class Explorer:
    """Chooses views until the `goal` is reached, nothing can change any more, or there are `most`.

    Without a goal everything that is asked is to be decided.
    """

    def __init__(self, judge: Judge, *, goal: Goal | None = None, most: int) -> None:
        self._judge, self._goal, self._most = judge, goal, most
        self._before: Needs | None = None
        self.reached = False
        """Whether the goal is, after the last verdict."""

    @property
    def most(self) -> int:
        """The most views of the whole collection."""
        return self._most

    def next_stop(self, around: Around, taken: tuple[Taken, ...]) -> Chosen | Finished:
        """The next stop after the views `taken`, or why none; EngineError where nobody judges."""
        number = 1 + max((view.number for view in taken), default=0)
        places = [view.pose.centre for view in taken]
        if len(taken) < FEWEST_VIEWS:
            return self._begin(around.candidates(number), around.target, places)
        models = () if self._goal is None else (self._goal.model,)
        interest = Interest(around.target, around.radius, models)
        verdict = self._judge(len(taken), interest)
        if verdict.fault and not verdict.views:
            raise EngineError(verdict.fault)
        # Where nothing is known yet, or views contradict one another, others may settle it.
        needs = verdict.needs or Needs.of_nothing(around.target)
        said = (f"of {verdict.views} views: {verdict.line}", self._brought(needs))
        self._before = needs
        self.reached = verdict.reached
        if verdict.reached and self._goal is not None:
            reached = f"{self._goal.model} holds to {self._goal.degree:.0%} at least"
            return self._finished(reached, said)
        if len(taken) >= self._most:
            most = f"there are {len(taken)} views, as many as --max-views allows"
            return self._finished(most, said)
        candidates = around.candidates(number)
        cov = taken[-1].covariance
        choice = choose(candidates, needs, around.reach.camera, places, cov)
        if choice is None:
            return self._finished(self._nothing_left(needs, candidates), said)
        line = {
            **_line(choice.candidate, len(taken)),
            "undecided": _open_json(needs),
            "promise": {
                "mass": choice.promise.mass,
                "sides": choice.promise.sides,
                "space": choice.promise.space,
                "corners": choice.promise.corners,
            },
            "why": choice.why,
        }
        return Chosen(choice.candidate.stop, line, (*said, *_words(choice)))

    def _begin(
        self, candidates: Sequence[Candidate], target: FloatArray, places: Sequence[FloatArray]
    ) -> Chosen | Finished:
        first = beginning(candidates, target, places)
        if first is None:
            return self._finished(
                "no view of the target can be reached: give a smaller --keep-out, or --target", ()
            )
        why = f"one of the first {FEWEST_VIEWS}, which a face needs: the nearest in time"
        line = {**_line(first, len(places)), "undecided": [], "promise": None, "why": why}
        return Chosen(first.stop, line, (f"next {first.stop.view.name}: {why}",))

    def _brought(self, needs: Needs) -> str:
        now = f"{needs.mass:.2f} verdicts may turn: {undecided(needs)}"
        if self._before is None:
            return now
        return f"{now}; before this view {self._before.mass:.2f}"

    def _nothing_left(self, needs: Needs, candidates: Sequence[Candidate]) -> str:
        if not needs.open and self._goal is not None:
            return (
                f"{self._goal.model} does not hold to {self._goal.degree:.0%}, and nothing is open "
                "or so poorly measured that a view may change that"
            )
        if not needs.open:
            return "nothing is undecided that was asked"
        if not candidates:
            return "no view of the target can be reached from here"
        return (
            f"none of {len(candidates)} views is likely to change what is undecided, which is "
            f"{undecided(needs)}: too little that is new shows from them"
        )

    def _finished(self, reason: str, said: tuple[str, ...]) -> Finished:
        line = {
            "result": EXPLORED,
            "reason": reason,
            "undecided": [] if self._before is None else _open_json(self._before),
        }
        return Finished(reason, line, said)


def _words(choice: Choice) -> tuple[str, ...]:
    return (f"next {choice.candidate.stop.view.name}: {choice.why}",)


def _open_json(needs: Needs) -> list[Mapping[str, object]]:
    return [
        {"thing": e.thing, "model": e.model, "unseen": e.unseen, "measured": e.measured}
        for e in needs.open
    ]


def _line(candidate: Candidate, after: int) -> Mapping[str, object]:
    robot = candidate.stop.robot
    return {
        "result": CHOSEN,
        "after": after,
        "image": candidate.stop.view.name,
        "robot": [robot.x, robot.y, math.degrees(robot.heading)],
        "way": candidate.way,
        "turns_deg": math.degrees(candidate.turns),
        "seconds": candidate.seconds,
    }
