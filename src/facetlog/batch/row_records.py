"""Rows as their border knows them: what somebody's file says, and the schema of the results."""

from typing import Annotated, Literal

from pydantic import (
    AliasChoices,
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    NonNegativeInt,
    ValidationError,
)

from facetlog.batch.rows import Row
from facetlog.errors import InputError

__all__ = ["RowRecord", "row_from"]

Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
# Older tables call it otherwise.
Confidence = Annotated[
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
    """What one model says of one thing; without the thing if there was none to ask about."""

    model: str
    thing: str
    state: Literal["holds", "fails", "unknown"]
    degree: Share
    degree_at_most: Share
    confidence: Confidence = None
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
    confidence: Confidence = Field(default=None, description="how often such a verdict is right")
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
