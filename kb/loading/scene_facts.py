"""The facts of a knowledge base's scenes: loaded at once, or when somebody asks for them.

Some facts take as long as all others. Whether a question or a file of rules asks for them is seen
by its text: whoever wants such a fact names it, or one of the vocabulary's words that rest on it. A
word that stands there for nothing costs time, and changes no answer.
"""

import re
import threading
from collections.abc import Callable, Iterable
from itertools import islice
from typing import TypeAlias

from facetlog.kb.engine.terms import Term
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.fact_columns import FACTS_PER_CHUNK, build_facts_request
from facetlog.kb.loading.scene_cache import SceneCache
from facetlog.perception.facts.fact_schema import ON_DEMAND

__all__ = ["FactMaker", "SceneFacts", "needs_facts_on_demand"]

FactMaker: TypeAlias = Callable[[], Iterable[Fact]]
"""Works out the facts on demand of one scene."""

# Goals that need facts on demand without naming them: vocabulary words (rules/line_labels.pl,
# rules/vocabulary.pl), and the requests for what was not seen (sight.pl) and for where something
# comes from (origin.pl), which may be a piece.
RESTING_WORDS = (
    "sight",
    "origin",
    "line_label",
    "impossible_drawing",
    r"(?:piece|opening)_\w+",
    "hollow_in",
    "largest_pieces",
    "largest_openings",
    "largest_hollows",
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


def needs_facts_on_demand(text: str) -> bool:
    """Return whether a question, or the text of rules, may ask for a fact that is made on demand.

    >>> needs_facts_on_demand("line_label(view1, E, concave)"), needs_facts_on_demand("face(F)")
    (True, False)
    """
    return _NAMED.search(text) is not None


class SceneFacts:
    """The facts that scenes, by their modules, hold, and those that they can still be asked for.

    `request(operation, text)` reaches Prolog; `always` says whether any question may need facts on
    demand, as it may where a model does. A scene can be asked again where making or loading fails.
    """

    def __init__(self, request: Callable[[str, str], Term], always: Callable[[], bool]) -> None:
        self._request, self._always = request, always
        self._cache = SceneCache()
        self._makers: dict[str, FactMaker] = {}
        self._lock = threading.RLock()

    def load(self, module: str, facts: Iterable[Fact], cache_key: str | None) -> int:
        """Load the facts of the key, or else these, into a new module; return their number."""
        path = None
        if cache_key is not None:
            path = self._cache.path(cache_key, str(self._request("cache_identity", "")))
            if (cached := self._cache.load(path, module, self._request)) is not None:
                return cached
        total = self._add(module, facts)
        self._cache.save(path, module, self._request)
        return total

    def _add(self, module: str, facts: Iterable[Fact]) -> int:
        total = 0
        source = iter(facts)
        while chunk := tuple(islice(source, FACTS_PER_CHUNK)):
            self._request("add_columns", build_facts_request(module, chunk))
            total += len(chunk)
        return total

    def promise(self, module: str, make: FactMaker | None) -> None:
        """Remember how to make further facts of the module, if anyone should ask."""
        if make is not None:
            self._makers[module] = make

    def keep(self, text: str, modules: Iterable[str]) -> None:
        """Make and load what was promised of these modules, once, if the question asks for it."""
        if not self._makers or not (self._always() or needs_facts_on_demand(text)):
            return
        with self._lock:
            for module in modules:
                make = self._makers.get(module)
                if make is not None:
                    self._add(module, make())
                    self.forget(module)

    def forget(self, module: str) -> None:
        """Forget a scene that is gone."""
        self._makers.pop(module, None)
