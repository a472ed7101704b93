"""The error of a scene's unit in its facts: one that all lengths have alike, and areas twice.

It moves no two faces against each other, so it is in no covariance of theirs; each measure has it
beside its own error, which it does not depend on.
"""

from collections.abc import Iterator

import numpy as np

from facetlog.perception.facts.fact_kinds import ArgumentKind, FactKind
from facetlog.perception.facts.fact_schema import FACT_SCHEMA
from facetlog.perception.facts.named_rows import FactColumns

__all__ = ["with_scale_error"]

_SD = "Sd"
_POWERS = {ArgumentKind.LENGTH: 1.0, ArgumentKind.AREA: 2.0}


def with_scale_error(facts: FactColumns, scale_sd: float) -> FactColumns:
    """The facts of a scene whose unit has this relative standard deviation.

    Where one deviation is stated of several lengths it has the error of the longest.

    >>> facts = {"length": (["f1"], np.array([2.0]), np.array([0.03]))}
    >>> with_scale_error(facts, 0.02)["length"][-1].tolist()
    [0.05]
    """
    if not scale_sd > 0.0:
        return facts
    found = dict(facts)
    for functor, power in _measures():
        columns = facts.get(functor, ())
        if columns:
            values = np.abs([c for c in columns[:-1] if isinstance(c, np.ndarray)]).max(axis=0)
            sd = np.hypot(np.asarray(columns[-1]), power * scale_sd * values)
            found[functor] = (*columns[:-1], sd)
    return found


def _measures() -> Iterator[tuple[str, float]]:
    """Functors of lengths and areas that end with their deviation, and the power of the unit."""
    for kind in FACT_SCHEMA:
        if _is_measure(kind):
            yield kind.functor, _POWERS[kind.arguments[-1].kind]


def _is_measure(kind: FactKind) -> bool:
    last = kind.arguments[-1]
    return last.name == _SD and last.kind in _POWERS
