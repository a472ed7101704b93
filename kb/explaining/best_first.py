"""In which order names stand that hold: one rule for all lists and answers of the program."""

from collections.abc import Iterable
from typing import Protocol, TypeVar

from facetlog.kb.explaining.proof import State

__all__ = ["Named", "best_first"]


class Named(Protocol):
    """What of a verdict its place in such a list hangs on."""

    @property
    def model(self) -> str:
        """The model's name."""

    @property
    def thing(self) -> str:
        """The thing that was judged."""

    @property
    def state(self) -> State:
        """Whether it holds."""

    @property
    def degree(self) -> float:
        """The probability that the true values are within the model's limits."""

    @property
    def confidence(self) -> float | None:
        """How often the model was right where it gave such a verdict; None if not calibrated."""

    @property
    def specialises(self) -> tuple[str, ...]:
        """The models of which this one is a special case."""

    @property
    def rather_than(self) -> tuple[str, ...]:
        """The models whose names stand after this one's where both hold."""


EVEN = 0.5
"""A degree above it: the thing is more probably as the model says than not."""

_Verdict = TypeVar("_Verdict", bound=Named)


def best_first(verdicts: Iterable[_Verdict]) -> list[_Verdict]:
    """Those that hold, the most probable first; of one thing what is special before what it is.

    By the confidences if all have one, else by the degrees. A name that its model says to go before
    another does so where it is more probable than not that the thing is within the model's limits
    and expectations. Of equals that of the higher degree, then the earlier one.
    """
    holding = [v for v in verdicts if v.state is State.HOLDS]
    counted = all(v.confidence is not None for v in holding)

    def sure(verdict: _Verdict) -> float:
        return (verdict.confidence or 0.0) if counted else verdict.degree

    held = {(v.thing, v.model): v for v in holding}

    def after(verdict: _Verdict) -> dict[tuple[str, str], _Verdict]:
        # What holds and stands after it, also by way of others.
        found: dict[tuple[str, str], _Verdict] = {}
        further = [verdict]
        while further:
            one = further.pop()
            others = one.specialises + (one.rather_than if one.degree > EVEN else ())
            new = {(one.thing, model) for model in others} & held.keys() - found.keys()
            found |= {key: held[key] for key in new}
            further += [held[key] for key in new]
        return found

    def standing(verdict: _Verdict) -> tuple[float, int, float]:
        # As probable as what it goes before, and before that.
        behind = after(verdict)
        return -max(map(sure, (verdict, *behind.values()))), -len(behind), -verdict.degree

    return sorted(holding, key=standing)
