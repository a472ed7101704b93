"""Facts that a scene gets only when somebody asks for them: some take as long as all others.

Whether a question or a file of rules asks is seen by its text: whoever wants such a fact names it,
or one of the vocabulary's words that rest on it. A word that stands there for nothing costs time,
and changes no answer.
"""

import re
import threading
from collections.abc import Callable, Iterable
from typing import TypeAlias

from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.fact_schema import ON_DEMAND

__all__ = ["FactMaker", "PromisedFacts", "asks_on_demand"]

FactMaker: TypeAlias = Callable[[], Iterable[Fact]]
"""Works out the facts on demand of one scene."""

# What asks for facts on demand without naming them: words of the vocabulary (rules/line_labels.pl,
# rules/vocabulary.pl), and the requests for what was not seen (sight.pl) and for where something
# comes from (origin.pl), which may be a piece.
RESTING_WORDS = (
    "sight",
    "origin",
    "line_label",
    "impossible_drawing",
    r"(?:piece|opening)_\w+",
    "largest_pieces",
    "largest_openings",
    "thickness",
)
# Words of everyday texts and names of parts, too: they count where something is said by them.
EVERYDAY = frozenset(
    {"piece", "joins", "carries", "board", "bar", "block", "opening", "frames", "beside", "inside"}
)
_NAMED = re.compile(
    rf"\b(?:(?:{'|'.join((*sorted(ON_DEMAND - EVERYDAY), *RESTING_WORDS))})\b"
    rf"|(?:{'|'.join(sorted(EVERYDAY))})\()"
)


def asks_on_demand(text: str) -> bool:
    """Whether a question, or the text of rules, may ask for a fact that is made on demand.

    >>> asks_on_demand("line_label(view1, E, concave)"), asks_on_demand("face(F)")
    (True, False)
    """
    return _NAMED.search(text) is not None


class PromisedFacts:
    """What the scenes of a knowledge base, by their modules, can still be asked for.

    `load` adds facts to a module; `always` says whether any question may need them, as it may
    where a model does. A scene keeps its promise where making or loading fails.
    """

    def __init__(
        self, load: Callable[[str, Iterable[Fact]], object], always: Callable[[], bool]
    ) -> None:
        self._load, self._always = load, always
        self._makers: dict[str, FactMaker] = {}
        self._lock = threading.RLock()

    def promise(self, module: str, make: FactMaker | None) -> None:
        """The scene of that module has these facts, if anyone should ask."""
        if make is not None:
            self._makers[module] = make

    def forget(self, module: str) -> None:
        """The scene is gone."""
        self._makers.pop(module, None)

    def keep(self, text: str, modules: Iterable[str]) -> None:
        """Makes and loads what was promised of these modules, once, if the question asks for it."""
        if not self._makers or not (self._always() or asks_on_demand(text)):
            return
        with self._lock:
            for module in modules:
                make = self._makers.get(module)
                if make is not None:
                    self._load(module, make())
                    self.forget(module)
