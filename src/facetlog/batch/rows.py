"""A row of results: what one scene came to, a dict.

Rows are made where the scenes are read and travel, and wait in the journal, as lines of JSON. What
reads them back from somebody's file checks them by row_records.py.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from facetlog import __version__
from facetlog.batch.settings import Item, Settings
from facetlog.kb.explaining.best_first import best_first
from facetlog.kb.explaining.proof import State

if TYPE_CHECKING:
    from facetlog.kb.brief_verdict import BriefVerdict

__all__ = [
    "COLUMNS",
    "HOLDS",
    "TOOK_LONGER",
    "Row",
    "closest",
    "error_row",
    "run_out",
    "scene_row",
    "sureness",
]

HOLDS = "holds"

TOOK_LONGER = "took longer than"
"""What the error says of a scene whose worker was ended."""
# The same of the engine's own limit (kb/engine/engine_pool.py), and of a worker's memory
# (memory.py).
RUN_OUT = (TOOK_LONGER, "the time limit was reached", "needs more memory than")

Row: TypeAlias = dict[str, Any]
"""A row as plain data, with the COLUMNS in their order."""

COLUMNS = (
    "path",
    "sha256",
    "models_hash",
    "model",
    "thing",
    "degree",
    "confidence",
    "verdicts",
    "faces",
    "things",
    "seconds",
    "error",
    "warnings",
    "up",
    "metric",
    "read_as",
    "facetlog",
)
"""What a row says: the fields of RowRecord."""


def closest(row: Row) -> dict[str, Row]:
    """Of each model the verdict on the thing that is nearest to it."""
    best: dict[str, Row] = {}
    for verdict in row["verdicts"]:
        known = best.get(verdict["model"])
        if known is None or _standing(verdict) > _standing(known):
            best[verdict["model"]] = verdict
    return best


def _standing(verdict: Row) -> tuple[bool, float, float]:
    return verdict["state"] == HOLDS, verdict["degree"], verdict["degree_at_most"]


def sureness(verdict: Row) -> float:
    """How sure it is that a verdict holds: its confidence, or the degree where there is none.

    >>> sureness({"degree": 1.0, "confidence": 0.7}), sureness({"degree": 1.0})
    (0.7, 1.0)
    """
    degree: float = verdict["degree"]
    confidence: float | None = verdict.get("confidence")  # none with --raw, nor in older tables
    return degree if confidence is None else confidence


def run_out(row: Row) -> bool:
    """Whether it ran out of time or memory: that depends on the machine, so that it may go well
    another time.

    >>> run_out({"path": "a.ply", "error": "a.ply: took longer than 60 s"})
    True
    """
    said = (row["error"] or "").removeprefix(row["path"])
    return any(words in said for words in RUN_OUT)


def _verdict(verdict: "BriefVerdict") -> Row:
    return {
        "model": verdict.model,
        "thing": verdict.thing,
        "state": verdict.state.value,
        "degree": verdict.degree,
        "degree_at_most": verdict.degree_at_most,
        "confidence": verdict.confidence,
        "parts": [{"role": role, "names": list(names)} for role, names in verdict.parts],
        "sizes": [{"name": name, "value": value, "sd": sd} for name, value, sd in verdict.sizes],
    }


def scene_row(
    item: Item,
    settings: Settings,
    verdicts: Sequence["BriefVerdict"],
    *,
    sha256: str | None,
    models_hash: str,
    faces: int,
    things: int,
    seconds: float,
    up: Sequence[float] | None,
    metric: bool,
    warnings: Sequence[str] = (),
) -> Row:
    """The row of a scene that was read and judged."""
    holding = best_first(verdicts)
    best = holding[0] if holding else None
    # What reads a row takes the first that holds for the answer (confusion.py).
    in_order = (*holding, *(v for v in verdicts if v.state is not State.HOLDS))
    return {
        "path": item.path,
        "sha256": sha256,
        "models_hash": models_hash,
        "model": best.model if best else None,
        "thing": best.thing if best else None,
        "degree": best.degree if best else None,
        "confidence": best.confidence if best else None,
        "verdicts": [_verdict(verdict) for verdict in in_order],
        "faces": faces,
        "things": things,
        "seconds": round(seconds, 6),
        "error": None,
        "warnings": list(warnings),
        "up": None if up is None else list(up),
        "metric": metric,
        "read_as": item.read_as(settings),
        "facetlog": __version__,
    }


def error_row(
    item: Item,
    settings: Settings,
    error: str,
    *,
    models_hash: str,
    seconds: float = 0.0,
    sha256: str | None = None,
) -> Row:
    """The row of a scene without verdicts, and why."""
    return {
        "path": item.path,
        "sha256": sha256,
        "models_hash": models_hash,
        "model": None,
        "thing": None,
        "degree": None,
        "confidence": None,
        "verdicts": [],
        "faces": None,
        "things": None,
        "seconds": round(seconds, 6),
        "error": error,
        "warnings": [],
        "up": None,
        "metric": None,
        "read_as": item.read_as(settings),
        "facetlog": __version__,
    }
