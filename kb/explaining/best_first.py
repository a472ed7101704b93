"""The order of what holds: the one rule by which a scene's answer is chosen, everywhere."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol, TypeVar

from facetlog.kb.explaining.proof import State

__all__ = ["best_first"]


class _Named(Protocol):
    """Fields of a verdict that its order goes by (verdict.py, brief_verdict.py)."""

    @property
    def model(self) -> str: ...
    @property
    def thing(self) -> str: ...
    @property
    def state(self) -> State: ...
    @property
    def degree(self) -> float: ...
    @property
    def specialises(self) -> tuple[str, ...]: ...
    @property
    def rather_than(self) -> tuple[str, ...]: ...
    @property
    def own(self) -> bool: ...


EVEN = 0.5
"""A degree above it: the thing is more probably as the model says than not."""

DEGREE_DIGITS = 9
"""Degrees that agree in so many digits are equal: they differ by the order of sums alone."""

_Verdict = TypeVar("_Verdict", bound=_Named)


def best_first(verdicts: Iterable[_Verdict]) -> list[_Verdict]:
    """Return the verdicts that hold, the answer first.

    Of one thing a special case comes before what it is a special case of; then a model before those
    that it says to go before (`rather than`), where its degree is above one half; then users' own
    models before built-in ones, also those of other things. All else goes by degree, where a
    verdict counts for as much as those that come after it for these reasons. Of equals the earlier
    one comes first: verdicts are in the order of things in the scene, then of models as loaded, the
    built-in ones first.
    """
    holding = [v for v in verdicts if v.state is State.HOLDS]
    of_thing: dict[str, list[int]] = defaultdict(list)
    for at, verdict in enumerate(holding):
        of_thing[verdict.thing].append(at)
    later: dict[int, set[int]] = {}
    for some in of_thing.values():
        later |= _find_later(holding, some)

    def key(at: int) -> tuple[bool, float, int, float]:
        chain = (at, *later[at])
        degrees = [round(holding[i].degree, DEGREE_DIGITS) for i in chain]
        is_own = any(holding[i].own for i in chain)
        return not is_own, -max(degrees), -len(later[at]), -degrees[0]

    return [holding[at] for at in sorted(range(len(holding)), key=key)]


def _find_later(holding: Sequence[_Named], some: Sequence[int]) -> dict[int, set[int]]:
    """Return for each of the verdicts on one thing those that come after it for a stated reason."""
    stated = _close(
        {i: {j for j in some if i != j and _is_stated(holding[i], holding[j])} for i in some}
    )
    # A user's own table comes after the built-in desk, which is one.
    own = {
        i: {j for j in some if holding[i].own and not holding[j].own and i not in stated[j]}
        for i in some
    }
    return _close({i: stated[i] | own[i] for i in some})


def _is_stated(one: _Named, other: _Named) -> bool:
    """Return whether the model of one verdict states that it comes before the other's."""
    return other.model in one.specialises or (one.degree > EVEN and other.model in one.rather_than)


def _close(later: Mapping[int, set[int]]) -> dict[int, set[int]]:
    """Return what comes after each, also by way of others."""
    closed: dict[int, set[int]] = {}
    for first in later:
        found: set[int] = set()
        further = [first]
        while further:
            new = later[further.pop()] - found
            found |= new
            further += new
        closed[first] = found - {first}
    return closed
