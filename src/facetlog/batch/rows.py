"""A row of results: what one scene came to.

A row is made where its scene is read, and travels and waits in the journal as a line of JSON.
RowRecord is its definition: columns, schema and types of tables follow from it.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import (
    AliasChoices,
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    NonNegativeInt,
    ValidationError,
)

from facetlog import __version__
from facetlog.batch.settings import Item, Settings
from facetlog.errors import InputError
from facetlog.kb.confidence import Confidence
from facetlog.kb.explaining.best_first import best_first
from facetlog.kb.explaining.proof import State

if TYPE_CHECKING:
    from facetlog.kb.brief_verdict import BriefVerdict

HOLDS = "holds"

TOOK_LONGER = "took longer than"
"""In the error of a scene whose worker was ended."""
# Errors of the engine's own limit (engine_pool.py of facetlog.kb) and of a worker's memory
# (memory.py) are recognised by these words, too.
RUN_OUT = (TOOK_LONGER, "the time limit was reached", "needs more memory than")

Row: TypeAlias = dict[str, Any]
"""A row as plain data, with the COLUMNS in their order."""

Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
# Older tables call it otherwise.
ConfidenceShare = Annotated[
    Share | None, Field(validation_alias=AliasChoices("confidence", "probability"))
]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PartRecord(_Record):
    """A part of a model and the faces (or edges) that play it, by their names in facts."""

    role: str
    names: tuple[str, ...]


class SizeRecord(_Record):
    """A length of the thing: metres if the row is metric, else units of the scene."""

    name: str
    value: FiniteFloat
    sd: FiniteFloat


class VerdictRecord(_Record):
    """Verdict of one model on one thing; `thing` is empty if there was none.

    What fails without a degree that counts has neither parts nor sizes: `why-not` names its nearest
    miss.
    """

    model: str
    thing: str
    state: Literal["holds", "fails", "unknown"]
    degree: Share
    degree_at_most: Share
    confidence: ConfidenceShare = None
    confidence_low: Share | None = None
    confidence_high: Share | None = None
    confidence_origin: str | None = None
    parts: tuple[PartRecord, ...] = ()
    sizes: tuple[SizeRecord, ...] = ()


class RowRecord(_Record):
    """One scene: what was read, by what it was judged, and the verdicts; or the error."""

    model_config = ConfigDict(frozen=True, extra="forbid", title="facetlog-results/1")

    path: str = Field(description="of the scene, as it was given")
    sha256: str | None = Field(description="of the file's content; null if it was not read")
    models_hash: str = Field(description="of all models that were judged")
    model: str | None = Field(description="the answer: the first of what holds")
    thing: str | None = Field(description="the thing that it holds of")
    degree: Share | None = Field(description="the degree to which it holds")
    confidence: ConfidenceShare = Field(
        default=None, description="how often such a verdict is right"
    )
    confidence_low: Share | None = Field(default=None, description="at least; nine in ten times")
    confidence_high: Share | None = Field(default=None, description="at most; nine in ten times")
    confidence_origin: str | None = Field(
        default=None, description="the cases that it was counted on, or why there is none"
    )
    verdicts: tuple[VerdictRecord, ...] = Field(
        description="of each model on each thing; first what holds, the answer first"
    )
    faces: NonNegativeInt | None
    things: NonNegativeInt | None
    seconds: Annotated[FiniteFloat, Field(ge=0.0)] = Field(description="to read and to judge it")
    error: str | None = Field(description="why there are no verdicts, in one line")
    warnings: tuple[str, ...] = Field(default=(), description="warnings of the scene's reader")
    up: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = Field(
        description="unit vector upwards in the scene's frame, if known"
    )
    metric: bool | None = Field(description="whether lengths are metres")
    read_as: str = Field(description="the options that it was read and judged with")
    facetlog: str = Field(description="version of the program")


COLUMNS = tuple(RowRecord.model_fields)
"""The names of a row's fields."""


def parse_row(data: object, source: str) -> Row:
    """Return the row of somebody's data; raise InputError, with the source and the field, if it is
    none.

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


def closest(row: Row) -> dict[str, Row]:
    """Return the best verdict of each model, by model."""
    best: dict[str, Row] = {}
    for verdict in row["verdicts"]:
        known = best.get(verdict["model"])
        if known is None or _standing(verdict) > _standing(known):
            best[verdict["model"]] = verdict
    return best


def _standing(verdict: Row) -> tuple[bool, float, float]:
    return verdict["state"] == HOLDS, verdict["degree"], verdict["degree_at_most"]


def read_confidence(verdict: Row) -> Confidence:
    """Return the confidence of a verdict, or of the answer of a row.

    There is none with --raw, and no bounds in older tables.

    >>> read_confidence({"degree": 1.0, "confidence": 0.7}).format(1.0)
    '70%'
    """
    low, high = verdict.get("confidence_low"), verdict.get("confidence_high")
    return Confidence(verdict.get("confidence"), low, high)


def has_run_out(row: Row) -> bool:
    """Return whether it ran out of time or memory: that depends on the machine, so that it may go
    well another time.

    >>> has_run_out({"path": "a.ply", "error": "a.ply: took longer than 60 s"})
    True
    """
    said = (row["error"] or "").removeprefix(row["path"])
    return any(words in said for words in RUN_OUT)


def make_scene_row(
    item: Item, settings: Settings, verdicts: Sequence["BriefVerdict"], **known: Any
) -> Row:
    """Return the row of a scene that was read and judged; `known` are the other columns."""
    holding = best_first(verdicts)
    # Readers take the first verdict that holds for the answer (confusion.py).
    in_order = (*holding, *(v for v in verdicts if v.state is not State.HOLDS))
    best = holding[0] if holding else None
    known |= {name: getattr(best, name, None) for name in ("model", "thing", "degree")}
    known |= {} if best is None else best.confidence.to_json()
    return _row(item, settings, verdicts=[_verdict(verdict) for verdict in in_order], **known)


def error_row(item: Item, settings: Settings, error: str, **known: Any) -> Row:
    """Return the row of a scene without verdicts, and why; `known` are other columns."""
    return _row(item, settings, error=error, **known)


def _row(item: Item, settings: Settings, *, seconds: float = 0.0, **known: Any) -> Row:
    return {
        **dict.fromkeys(COLUMNS),
        "path": item.path,
        "verdicts": [],
        "seconds": round(seconds, 6),
        "warnings": [],
        "read_as": item.read_as(settings),
        "facetlog": __version__,
        **known,
    }


def _verdict(verdict: "BriefVerdict") -> Row:
    return {
        "model": verdict.model,
        "thing": verdict.thing,
        "state": verdict.state.value,
        "degree": verdict.degree,
        "degree_at_most": verdict.degree_at_most,
        **verdict.confidence.to_json(),
        "parts": [{"role": role, "names": list(names)} for role, names in verdict.parts],
        "sizes": [{"name": name, "value": value, "sd": sd} for name, value, sd in verdict.sizes],
    }
