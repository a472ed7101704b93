"""Why a scene was answered as it was: its picture, and what the knowledge base says of it."""

import base64
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypedDict

from facetlog.batch.settings import Item, Settings, shape_options
from facetlog.errors import FacetlogError
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.proof import State
from facetlog.kb.recognize import open_knowledge_base
from facetlog.perception.facts import fact_rows
from facetlog.perception.shapes.read import read_shape
from facetlog.terminal import one_line

__all__ = ["Doubt", "Reason", "explained"]

SCENE = "scene"


class Doubt(TypedDict):
    """What was answered, and what would have been right: models, or other words."""

    answered: str
    right: str


class Reason(TypedDict):
    """A heading and lines of text under it."""

    title: str
    lines: list[str]


def explained(item: Item, settings: Settings, question: Doubt) -> dict[str, Any]:
    """The picture of a scene (PNG, base64) and the reasons; without what cannot be had.

    The wrong answer is told why it holds, the right one why it does not.
    """
    try:
        scene = read_shape(Path(item.place), shape_options(item, settings))
    except FacetlogError:
        return {"picture": None, "reasons": []}  # the row says why
    from facetlog.batch.thumbnail import thumbnail

    picture = base64.b64encode(thumbnail(scene)).decode("ascii")
    base = _base(settings)
    try:
        rows = fact_rows(scene)
        base.load_scene(SCENE, ((name, *args) for name, found in rows.items() for args in found))
        try:
            return {"picture": picture, "reasons": list(_reasons(base, question))}
        finally:
            base.drop_scene(SCENE)
    except FacetlogError as exc:
        return {"picture": picture, "reasons": [_reason("No reasons", [one_line(str(exc))])]}


@cache
def _base(settings: Settings) -> KnowledgeBase:
    """The knowledge base of this process, which ends with it."""
    return open_knowledge_base(
        tuple(map(Path, settings.models)),
        trusted=settings.trusted,
        crisp=settings.crisp,
        limits=Limits(seconds=settings.seconds),
    )


def _reasons(base: KnowledgeBase, question: Doubt) -> Iterator[Reason]:
    right, answered = question["right"], question["answered"]
    if right in base.models:
        verdict = base.why(SCENE, right)
        if verdict.state is not State.HOLDS:
            misses = base.why_not(SCENE, right, count=1)
            lines = [line for miss in misses for line in miss.miss_lines()]
            yield _reason(f"Why not {right}", lines or [verdict.summary])
    if answered in base.models and answered != right:
        yield _reason(f"Why {answered}", list(base.why(SCENE, answered).lines()))


def _reason(title: str, lines: list[str]) -> Reason:
    return {"title": title, "lines": lines}
