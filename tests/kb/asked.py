"""Asks for explanations of the facts of one scene."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from facetlog.kb.explaining.origin import Origin
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact

SCENE = "s"
# The clock goes on while other tests have the processor.
PATIENT = Limits(seconds=300.0)


@dataclass(frozen=True)
class Asked:
    """A loaded scene that can be asked why."""

    base: KnowledgeBase

    def judge(self, model: str, thing: str = "t1") -> Verdict:
        return self.base.judge(SCENE, model, thing)

    def why(
        self, model: str, *, thing: str | None = None, parts: Mapping[str, str] | None = None
    ) -> Verdict:
        return self.base.why(SCENE, model, thing=thing, parts=parts or {})

    def why_not(
        self,
        model: str,
        *,
        thing: str | None = None,
        parts: Mapping[str, str] | None = None,
        count: int = 5,
    ) -> tuple[Verdict, ...]:
        return self.base.why_not(SCENE, model, thing=thing, parts=parts or {}, count=count)

    def origin(self, about: str) -> Origin:
        return self.base.origin(SCENE, about)


@contextmanager
def asked(facts: Iterable[Fact], rules: Path | None = None) -> Iterator[Asked]:
    """Yield the facts, loaded, with a user's rules if any."""
    with KnowledgeBase(PATIENT) as base:
        if rules:
            base.load_rules(rules, trusted=True)
        base.load_scene(SCENE, facts)
        yield Asked(base)
