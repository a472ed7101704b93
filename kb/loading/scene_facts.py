"""The facts of a knowledge base's scenes, loaded into Prolog."""

from collections.abc import Callable, Iterable
from itertools import islice

from facetlog.kb.engine.terms import Term
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.fact_columns import FACTS_PER_CHUNK, facts_request
from facetlog.kb.loading.promised_facts import FactMaker, PromisedFacts
from facetlog.kb.loading.scene_cache import SceneCache

__all__ = ["SceneFacts"]


class SceneFacts:
    """What the scenes, by their modules, hold, and what they can still be asked for.

    `request(operation, text, state=...)` reaches Prolog; `on_demand` says whether any question may
    need facts on demand.
    """

    def __init__(self, request: Callable[..., Term], on_demand: Callable[[], bool]) -> None:
        self._request = request
        self._cache = SceneCache()
        self._promised = PromisedFacts(self.add, on_demand)

    def load(self, module: str, facts: Iterable[Fact], cache_key: str | None) -> int:
        """How many facts the new module has now: those of the key, or else these."""
        path = None
        if cache_key is not None:
            path = self._cache.path(cache_key, str(self._request("cache_identity", "")))
            if (cached := self._cache.load(path, module, self._request)) is not None:
                return cached
        total = self.add(module, facts)
        self._cache.save(path, module, self._request)
        return total

    def add(self, module: str, facts: Iterable[Fact]) -> int:
        """How many facts were added to the module."""
        total = 0
        source = iter(facts)
        while chunk := tuple(islice(source, FACTS_PER_CHUNK)):
            self._request("add_columns", facts_request(module, chunk), state=module)
            total += len(chunk)
        return total

    def promise(self, module: str, make: FactMaker | None) -> None:
        """The module can have these facts too, if anyone should ask."""
        self._promised.promise(module, make)

    def keep(self, text: str, modules: Iterable[str]) -> None:
        """Loads what was promised of these modules, if the question asks for it."""
        self._promised.keep(text, modules)

    def forget(self, module: str) -> None:
        """The scene is gone."""
        self._promised.forget(module)
