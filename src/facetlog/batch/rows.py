"""A row of results: what one scene came to. The models here are the border; inside it is a dict.

Rows are made where the scenes are read and travel, and wait in the journal, as lines of JSON. What
reads them back from somebody's file checks them here.
"""

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, NonNegativeInt, ValidationError

from facetlog import __version__
from facetlog.batch.settings import Item, Settings
from facetlog.errors import InputError

if TYPE_CHECKING:
    from facetlog.kb.batch_judge import BriefVerdict

__all__ = [
    "HOLDS",
    "TOOK_LONGER",
    "Row",
    "RowRecord",
    "best_verdict",
    "closest",
    "error_row",
    "results_schema",
    "row_from",
    "run_out",
    "scene_row",
]

SCHEMA_DIALECT = "https://json-schema.org/draft/2020-12/schema"
HOLDS = "holds"

TOOK_LONGER = "took longer than"
"""What the error says of a scene whose worker was ended."""
# The same of the engine's own limit (engine_pool.py and isolated_process.py of facetlog.kb), and of
# a worker's memory (memory.py).
RUN_OUT = (TOOK_LONGER, "the time limit was reached", "needs more memory than")

Row: TypeAlias = dict[str, Any]
"""A row as plain data, with the fields of RowRecord in their order."""

Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PartRecord(_Record):
    """A part of a model and the faces (or edges) that play it, by the names of docs/facts.md."""

    role: str
    names: tuple[str, ...]


class SizeRecord(_Record):
    """A length of the thing: metres if the row is metric, else units of the scene."""

    name: str
    value: FiniteFloat
    sd: FiniteFloat


class VerdictRecord(_Record):
    """What one model says of one thing; without the thing if there was none to ask about."""

    model: str
    thing: str
    state: Literal["holds", "fails", "unknown"]
    degree: Share
    degree_at_most: Share
    probability: Share | None
    parts: tuple[PartRecord, ...] = ()
    sizes: tuple[SizeRecord, ...] = ()


class RowRecord(_Record):
    """One scene: what was read, by what it was judged, and the verdicts; or the error."""

    model_config = ConfigDict(frozen=True, extra="forbid", title="facetlog-results/1")

    path: str = Field(description="of the scene, as it was given")
    sha256: str | None = Field(description="of the file's content; null if it was not read")
    models_hash: str = Field(description="of all models that were asked")
    model: str | None = Field(description="the model that holds with the highest degree")
    thing: str | None = Field(description="the thing that it holds of")
    degree: Share | None = Field(description="the degree to which it holds")
    probability: Share | None = Field(description="how often a verdict of this degree was right")
    verdicts: tuple[VerdictRecord, ...] = Field(description="of each model on each thing")
    faces: NonNegativeInt | None
    things: NonNegativeInt | None
    seconds: Annotated[FiniteFloat, Field(ge=0.0)] = Field(description="to read and to judge it")
    error: str | None = Field(description="why there are no verdicts, in one line")
    warnings: tuple[str, ...] = Field(
        default=(), description="what is doubtful about the scene, as its reader says it"
    )
    up: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = Field(
        description="unit vector upwards in the scene's frame, if known"
    )
    metric: bool | None = Field(description="whether lengths are metres")
    read_as: str = Field(description="the options that it was read and judged with")
    facetlog: str = Field(description="version of the program")


def results_schema() -> str:
    """The JSON Schema of a row, as docs/results.schema.json holds it."""
    schema = {"$schema": SCHEMA_DIALECT, **RowRecord.model_json_schema()}
    return json.dumps(schema, indent=2) + "\n"


def row_from(data: object, source: str) -> Row:
    """The row of somebody's data; raises InputError, with the source and the field, if it is none.

    Columns that facetlog does not know, as others may add to a table, are left out.
    """
    known = data
    if isinstance(data, dict):
        known = {key: value for key, value in data.items() if key in RowRecord.model_fields}
    try:
        return RowRecord.model_validate(known).model_dump()
    except ValidationError as exc:
        first = exc.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or "row"
        message = " ".join(first["msg"].split())
        raise InputError(f"{source}: {place}: {message}: is it a table of classify?") from exc


def best_verdict(verdicts: Sequence["BriefVerdict"]) -> "BriefVerdict | None":
    """Of the verdicts that hold the surest, by probability if all have one; None if none holds.

    Of equals the first, in the order of things and models.
    """
    holding = [v for v in verdicts if v.state.value == HOLDS]
    counted = all(v.probability is not None for v in holding)
    return max(
        holding,
        key=lambda v: ((v.probability or 0.0) if counted else v.degree, v.degree),
        default=None,
    )


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
        "probability": verdict.probability,
        "parts": [{"role": role, "names": list(names)} for role, names in verdict.parts],
        "sizes": [{"name": name, "value": value, "sd": sd} for name, value, sd in verdict.sizes],
    }


def scene_row(
    item: Item,
    settings: Settings,
    verdicts: Sequence["BriefVerdict"],
    *,
    sha256: str,
    models_hash: str,
    faces: int,
    things: int,
    seconds: float,
    up: Sequence[float] | None,
    metric: bool,
    warnings: Sequence[str] = (),
) -> Row:
    """The row of a scene that was read and judged."""
    best = best_verdict(verdicts)
    return {
        "path": item.path,
        "sha256": sha256,
        "models_hash": models_hash,
        "model": best.model if best else None,
        "thing": best.thing if best else None,
        "degree": best.degree if best else None,
        "probability": best.probability if best else None,
        "verdicts": [_verdict(verdict) for verdict in verdicts],
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
        "probability": None,
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
