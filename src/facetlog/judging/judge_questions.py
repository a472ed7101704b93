"""What the process that judges a growing collection is given at its start, and what it is asked."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from facetlog.exploring.needs import Interest

__all__ = ["EndRecording", "Explore", "Judge", "Opening", "Question"]


@dataclass(frozen=True, slots=True)
class Opening:
    """The folder of the views, the models with their trust, and the MCAP file to record, if any."""

    folder: Path
    models: tuple[Path, ...]
    trusted: bool
    mcap: Path | None


@dataclass(frozen=True, slots=True)
class Judge:
    """What the first `views` views show, with `finally_` all at once and their poses corrected;
    with `degrees` in place of confidences. The answer is a ViewVerdict.
    """

    views: int
    finally_: bool = False
    degrees: bool = False


@dataclass(frozen=True, slots=True)
class Explore:
    """The same of all at once, with what is undecided of what is of interest."""

    views: int
    interest: "Interest"


@dataclass(frozen=True, slots=True)
class EndRecording:
    """End the recording, with all views that are there; the answer is None."""


Question: TypeAlias = Judge | Explore | EndRecording
