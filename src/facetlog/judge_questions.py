"""What the process that judges a growing collection is given at its start, and what it is asked."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from facetlog.recordings.recorders import Recordings

if TYPE_CHECKING:
    from facetlog.exploring.needs import Interest

__all__ = ["EndRecordings", "Explore", "ExplorePlace", "Judge", "Opening", "Question"]


@dataclass(frozen=True, slots=True)
class Opening:
    """The folder of the views, the models with their trust, and what is recorded."""

    folder: Path
    models: tuple[Path, ...]
    trusted: bool
    recordings: Recordings


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
class ExplorePlace:
    """The same of views with these names; the answer has the things that they show, too."""

    names: tuple[str, ...]
    interest: "Interest"


@dataclass(frozen=True, slots=True)
class EndRecordings:
    """Recordings are whole afterwards, with all views that are there; the answer is None."""


Question: TypeAlias = Judge | Explore | ExplorePlace | EndRecordings
