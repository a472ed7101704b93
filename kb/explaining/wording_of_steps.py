"""Steps of a proof that count groups or ask another model, in words."""

from dataclasses import dataclass

from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.wording import with_article

__all__ = ["Tally", "model_cause", "model_words"]

_MODEL_CAUSES = {
    "unseen": "the thing was not seen",
    "unstated": "the scene has no such thing",
    "cycle": "that model is itself being judged for this thing",
}


@dataclass(frozen=True, slots=True)
class Tally:
    """How many groups are wanted (at least or at most `count`), how many hold and how many may.

    `deciding` is the member of a group that decides, or empty; `is_all` says that there are no more
    groups than these, `grouped` that some have several members, which do not stand apart.
    """

    at_least: bool
    count: int
    holding: int
    undecided: int
    deciding: str
    is_all: bool = False
    grouped: bool = False

    def brief(self) -> str:
        """The numbers alone.

        >>> Tally(True, 3, 4, 0, "f7").brief()
        '4 hold, 0 may, f7 decides'
        """
        decides = f", {self.deciding} decides" if self.deciding else ""
        return f"{self.holding} hold, {self.undecided} may{decides}"

    def words(self) -> str:
        """The numbers in a sentence.

        >>> Tally(True, 3, 2, 1, "f7").words()
        '2 were found, at least 3 are wanted, but there may be more; f7 comes next'
        >>> Tally(False, 1, 2, 0, "f9").words()
        '2 were found, at most 1 is wanted; f9 is one too many'
        >>> Tally(True, 3, 4, 0, "f7", grouped=True).words()
        '4 that stand apart were found, at least 3 are wanted; f7 decides'
        """
        bound = "at least" if self.at_least else "at most"
        more = f", {self.undecided} more may be" if self._is_open_above() else ""
        wanted = f"{bound} {self.count} {'is' if self.count == 1 else 'are'} wanted"
        apart = " that stand apart" if self.grouped else ""
        found = {0: "none was", 1: "1 was"}.get(self.holding, f"{self.holding}{apart} were")
        return f"{found} found{more}, {wanted}{self._end()}"

    def _is_open_above(self) -> bool:
        some = self.holding <= self.count < self.holding + self.undecided
        return not self.at_least and some

    def _end(self) -> str:
        if self.at_least and self.holding < self.count:
            if self.is_all:
                return ""
            following = f"; {self.deciding} comes next" if self.deciding else ""
            return f", but there may be more{following}"
        if not self.at_least and self.holding > self.count:
            return f"; {self.deciding} is one too many"
        return f"; {self.deciding} decides" if self.deciding else ""


def model_words(thing: str, model: str, state: State) -> str:
    """What another model says of a thing, as a clause.

    >>> model_words("t2", "table", State.FAILS)
    't2 is no table'
    """
    one = with_article(model)
    match state:
        case State.HOLDS:
            return f"{thing} is {one}"
        case State.FAILS:
            return f"{thing} is no {model}"
        case State.UNKNOWN:
            return f"it is open whether {thing} is {one}"


def model_cause(cause: str) -> str:
    """Why another model says nothing, or an empty text."""
    return _MODEL_CAUSES.get(cause, "")
