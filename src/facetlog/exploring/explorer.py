"""Explores a target: first views beside one another, then the best next one until none is needed.

What is undecided after the views so far is asked of a judge (in a process of its own while a robot
is driven); the choice itself is a pure function (choice.py).
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from facetlog.errors import EngineError
from facetlog.exploring.choice import Choice, beginning, choose, undecided
from facetlog.exploring.open_questions import LEAST_TURNED, Interest, Needs
from facetlog.judging.view_verdicts import ViewVerdict
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.next_stop import CHOSEN, EXPLORED, Around, Chosen, Finished
from facetlog.robot.collecting.record import Taken
from facetlog.robot.collecting.ring_views import Candidate
from facetlog.stream import Goal

UNSETTLED = 0.05
"""Without a goal a name is settled that another would take the place of in one of twenty cases; and
where none leads, a view that settles nothing in nineteen of twenty is not worth taking."""

Judge: TypeAlias = Callable[[int, Interest], ViewVerdict]
"""Return the verdict on the first views, with what is undecided about what is of interest."""


class Explorer:
    """Chooses views until the `goal` is reached, nothing can change any more, or there are `most`.

    Without a goal everything that is asked is to be decided.
    """

    def __init__(self, judge: Judge, *, goal: Goal | None = None, most: int) -> None:
        self._judge, self._goal, self._most = judge, goal, most
        self._before: Needs | None = None
        self._judged: tuple[int, ViewVerdict] | None = None
        self._excluded: tuple[str, ...] = ()
        self.reached = False
        """Whether the goal is, after the last verdict."""
        self.settled = False
        """Whether what is asked is decided, after the last verdict."""

    @property
    def most(self) -> int:
        """The most views of the whole collection."""
        return self._most

    def next_stop(self, around: Around, taken: tuple[Taken, ...]) -> Chosen | Finished:
        """Return the next stop after the views `taken`, or why there is none.

        Raise EngineError if the judge has died.
        """
        number = 1 + max((view.number for view in taken), default=0)
        places = [view.pose.centre for view in taken]
        if len(taken) < FEWEST_VIEWS:
            return self._begin(around.candidates(number), around.target, places)
        if self._judged is None:
            self._recall(around, taken[:-1])
        # The same number again: the way to the view that was chosen was blocked.
        again = self._judged is not None and self._judged[0] == len(taken)
        needs, said = self._weigh(around, taken)
        said = () if again else said
        if self.settled:
            return self._finished(f"{self._holds(needs)}{_rivals(needs)}", said)
        if len(taken) >= self._most:
            most = f"there are {len(taken)} views, as many as --max-views allows"
            return self._finished(most, said)
        candidates = around.candidates(number)
        cov = taken[-1].covariance
        # A name that leads is to be sure of; to find one, a view is to be worth its while.
        least = UNSETTLED if needs.lead is None else LEAST_TURNED
        choice = choose(candidates, needs, around.reach.camera, places, cov, least=least)
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
            "candidates": _among(choice),
        }
        return Chosen(choice.candidate.stop, line, (*said, *_words(choice)))

    def _recall(self, around: Around, taken: Sequence[Taken]) -> None:
        """Judge an earlier run's views: what they excluded, the next one may not settle alone."""
        if len(taken) >= FEWEST_VIEWS:
            self._judged = len(taken), self._verdict(around, taken)

    def _weigh(self, around: Around, taken: Sequence[Taken]) -> tuple[Needs, tuple[str, ...]]:
        """Return what is undecided after the views `taken`, three or more, and lines about it."""
        before, self._judged = self._judged, None
        if before is not None and before[0] == len(taken):
            verdict = before[1]
        else:
            verdict = self._verdict(around, taken)
            self._excluded = () if before is None else before[1].excluded
        self._judged = len(taken), verdict
        # Where nothing is known yet, or views contradict one another, others may settle it.
        needs = verdict.needs or Needs.of_nothing(around.target)
        self.reached = self._is_reached(needs)
        needs = self._asked(needs)
        doubt: tuple[str, ...] = ()
        if needs.lead is not None and (name := needs.lead.model) in self._excluded:
            needs = needs.contradicted()
            doubt = (f"before this view it was no {name}: more views are to say which",)
        said = f"of {verdict.views} views: {verdict.line}", *doubt, *self._brought(needs)
        self._before = needs
        self.settled = self._is_settled(needs)
        return needs, said

    def _verdict(self, around: Around, taken: Sequence[Taken]) -> ViewVerdict:
        places = np.array([view.pose.centre for view in taken])
        verdict = self._judge(len(taken), Interest(around.target, around.radius, places))
        if verdict.fault and not verdict.views:
            raise EngineError(verdict.fault)
        return verdict

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

    def _asked(self, needs: Needs) -> Needs:
        """Return what is open of what is asked: all while no name leads, whatever the goal, for a
        view that shows what the thing is shows also whether it is that.
        """
        if needs.lead is None:
            return needs
        if self._goal is not None and not self.reached:
            return needs.asked_of(self._goal.model)
        return needs.of_rivals()

    def _is_reached(self, needs: Needs) -> bool:
        return self._goal is not None and self._goal.is_met_by(_degree(needs, self._goal))

    def _is_settled(self, needs: Needs) -> bool:
        """Return whether the name that leads is the one that is wanted, and hardly any
        other may.
        """
        if self._goal is None:
            return needs.overtaken <= UNSETTLED
        return self.reached and self._goal.is_met_by(1.0 - needs.overtaken)

    def _holds(self, needs: Needs) -> str:
        """Say to which degree the goal's model holds, and which was wanted; without a goal that
        of the name that leads.
        """
        if self._goal is None:
            lead = needs.lead
            return f"{lead.model} leads, to {lead.degrees[lead.model]:.0%}; " if lead else ""
        degree = _degree(needs, self._goal)
        wanted = f"{self._goal.degree:.0%} wanted"
        return f"{self._goal.model} holds to {degree:.0%}, {wanted}; "

    def _brought(self, needs: Needs) -> Iterator[str]:
        if needs.lead is not None:
            yield f"{self._holds(needs)}{_rivals(needs)}"
        now = f"{needs.mass:.2f} verdicts may turn: {undecided(needs)}"
        before = "" if self._before is None else f"; before this view {self._before.mass:.2f}"
        yield f"{now}{before}"

    def _nothing_left(self, needs: Needs, candidates: Sequence[Candidate]) -> str:
        held = self._holds(needs)
        if not needs.open:
            return f"{held}nothing is undecided that was asked"
        if not candidates:
            return f"{held}no view of the target can be reached from here"
        return (
            f"{held}none of {len(candidates)} views is likely to change what is undecided, which "
            f"is {undecided(needs)}: too little that is new shows from them"
        )

    def _finished(self, reason: str, said: tuple[str, ...]) -> Finished:
        line = {
            "result": EXPLORED,
            "reason": reason,
            "undecided": [] if self._before is None else _open_json(self._before),
        }
        return Finished(reason, line, said)


def _degree(needs: Needs, goal: Goal) -> float:
    return 0.0 if needs.lead is None else needs.lead.degree_of(goal.model)


def _rivals(needs: Needs) -> str:
    return f"another name may stand first by what was not seen ({needs.overtaken:.0%})"


def _words(choice: Choice) -> tuple[str, ...]:
    return (f"next {choice.candidate.stop.view.name}: {choice.why}",)


def _among(choice: Choice) -> list[list[float]]:
    """Return, for each candidate, the pinhole's place (m), its mass, seconds, and whether it was
    chosen (1).
    """
    return [
        [
            *(round(float(x), 4) for x in each.pose.centre),
            round(mass, 6),
            round(each.seconds, 2),
            int(each is choice.candidate),
        ]
        for each, mass in choice.among
    ]


def _open_json(needs: Needs) -> list[Mapping[str, object]]:
    return [
        {
            "thing": e.thing,
            "model": e.model,
            "unseen": e.unseen,
            "measured": e.measured,
            "assumed": e.assumed,
            "lack": sorted(lack.value for lack in e.lack) if e.unseen else [],
        }
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
