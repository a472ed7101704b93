"""The JSON Schema of `facetlog-verdicts/2`: what `recognize --json` prints and verdicts.json holds.

Models of what verdict.py, reasons.py and proof.py of kb/explaining/ write, for those who read it
elsewhere; a test holds both against each other.
"""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt

from facetlog.kb.explaining.unseen import Unseen
from facetlog.perception.types import Share

__all__ = ["VerdictsRecord"]

NotNegative = Annotated[float, Field(ge=0.0)]
State = Literal["holds", "fails", "unknown"]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class FoundRecord(_Record):
    """A model that holds, and of what thing; the most probable first."""

    thing: str
    model: str


class SizeRecord(_Record):
    """A size with its standard deviation, in `length_unit`; `measure` is what was measured."""

    value: float
    sd: NotNegative
    measure: str


class AngleRecord(_Record):
    """An angle that decides, in degrees; `of` is the measure."""

    of: str
    deg: float
    sd: NotNegative


class ShortfallRecord(_Record):
    """By how much a value misses its region; `sds` null where its deviation is 0."""

    amount: float
    sd: NotNegative
    sds: float | None
    side: Literal["below", "above"]


class MissRecord(ShortfallRecord):
    """A shortfall with the condition and the measure that it is of."""

    label: str
    of: str
    kind: str


class WithinRecord(_Record):
    """The region that a value was tested against: its sort, limits, and how far its edges fade."""

    sort: str
    limits: tuple[float, ...]
    fading: float | None = None
    soft: float | None = None


class _MeasuredRecord(_Record):
    # What was compared, where a step was measured; `unseen` are the values if the space that nobody
    # saw is free, and if it is full.
    measure: str | None = None
    value: float | None = None
    sd: NotNegative | None = None
    kind: str | None = None
    within: WithinRecord | None = None
    shortfall: ShortfallRecord | None = None
    unseen: tuple[float, float] | None = None


class ProofRecord(_MeasuredRecord):
    """A test with its state and the least and greatest degree; a comparison, or a note, or both.

    `because` are the tests that it was decided by.
    """

    test: str
    state: State
    degree: tuple[Share, Share]
    note: str | None = None
    cause: str | None = None
    because: tuple["ProofRecord", ...] = ()


class ReasonRecord(_MeasuredRecord):
    """The step that decides a condition, in words; where it was measured, with its numbers.

    `state` is that of the step, `more` how many others are needed beside it.
    """

    text: str
    state: State
    more: NonNegativeInt


class NearRecord(_Record):
    """Near miss of a set: no member, or one of too many, and why.

    `nearest` is there where it lacks nothing but members of a set of its own.
    """

    name: str
    state: State
    because: ReasonRecord | None
    nearest: tuple["NearRecord", ...] = ()


class ConditionRecord(_Record):
    """A condition of the model: the author's reason, its place, its state, and what decided that.

    `because` is null where it holds because it does not apply to such a thing. `text`, the line as
    it is written, and `proof` are there with --full; `nearest`, those that miss alike, of near
    misses.
    """

    label: str
    reason: str
    place: str | None = None
    text: str | None = None
    state: State
    degree: tuple[Share, Share]
    because: ReasonRecord | None
    nearest: tuple[NearRecord, ...] = ()
    proof: ProofRecord | None = None


class VerdictRecord(_Record):
    """The verdict of one model on one thing; without the thing if there was none to ask about.

    `unseen` is there where another look might settle a condition that is open, `assumed` where part
    of what the thing fills was not seen and counts as full, if someone asked why. `confidence` is
    null for the reason in `confidence_origin`, else that says what it was counted on; `_low` and
    `_high` bound it with a probability of nine tenths.
    """

    model: str
    thing: str | None
    state: State
    degree: Share
    degree_at_most: Share
    specialises: tuple[str, ...]
    confidence: Share | None
    confidence_low: Share | None
    confidence_high: Share | None
    confidence_origin: str
    summary: str
    parts: dict[str, tuple[str, ...]]
    sizes: dict[str, SizeRecord]
    length_unit: str | None
    angles: tuple[AngleRecord, ...]
    also: NonNegativeInt
    shortfalls: tuple[MissRecord, ...]
    conditions: tuple[ConditionRecord, ...]
    assumed: Share = 0.0
    unseen: tuple[Unseen, ...] = ()


class VerdictsRecord(_Record):
    """All verdicts on a scene with the reasons for them, and what was wrong with its pictures."""

    model_config = ConfigDict(title="facetlog-verdicts/2")

    format: Literal["facetlog-verdicts/2"] = Field(alias="schema")
    scene: str
    recognised: tuple[FoundRecord, ...]
    verdicts: tuple[VerdictRecord, ...]
    problems: tuple[str, ...]
    warnings: tuple[str, ...]
