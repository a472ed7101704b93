"""A scene in the knowledge base of a worker process, for proofs: rows are judged without them."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from facetlog.batch.settings import Settings
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact
from facetlog.kb.recognize import open_knowledge_base
from facetlog.perception.facts.all_facts import FactRows, fact_rows
from facetlog.perception.facts.fact_schema import ON_DEMAND
from facetlog.perception.scene import Scene

SCENE = "scene"
"""Its name while it is loaded."""

SECONDS_PER_REASON = 10.0
"""A page of reasons is waited for: one that takes longer is said to have taken too long."""


@contextmanager
def loaded_scene(scene: Scene, settings: Settings) -> Iterator[KnowledgeBase]:
    """Return the knowledge base with the settings' models and, while it is in use, the scene as
    SCENE.

    Raise FacetlogError if the scene cannot be loaded.
    """
    base = _base(settings)
    base.load_scene(
        SCENE, _flat(fact_rows(scene)), on_demand=lambda: _flat(fact_rows(scene, ON_DEMAND))
    )
    try:
        yield base
    finally:
        base.drop_scene(SCENE)


def _flat(rows: FactRows) -> Iterator[Fact]:
    return ((name, *args) for name, found in rows.items() for args in found)


@cache
def _base(settings: Settings) -> KnowledgeBase:
    """Return the knowledge base of this process, which ends with it."""
    return open_knowledge_base(
        tuple(map(Path, settings.models)),
        trusted=settings.trusted,
        crisp=settings.crisp,
        raw=settings.raw,
        limits=Limits(seconds=min(settings.seconds, SECONDS_PER_REASON)),
    )
