"""Why a scene was answered as it was: its picture, and what the knowledge base says of it."""

import base64
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, TypedDict

from facetlog.batch.loaded_scene import SCENE, loaded_scene
from facetlog.batch.rows import HOLDS, Row, read_confidence
from facetlog.batch.settings import Item, Settings, open_scene
from facetlog.errors import FacetlogError, QueryError
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.terminal import fit_on_one_line


class Mistaken(TypedDict):
    """A mistake: the answer given and the right one.

    `verdicts` are the row's, by model: what they say of which thing is explained.
    """

    answered: str
    right: str
    verdicts: dict[str, Row]


class Reason(TypedDict):
    """A heading and lines of text under it."""

    title: str
    lines: list[str]


def explained(item: Item, settings: Settings, question: Mistaken) -> dict[str, Any]:
    """Return the picture of a scene (PNG, base64) and the reasons; without what cannot be had.

    Of the wrong answer why it holds, of the right one why it does not.
    """
    try:
        scene = open_scene(item, settings).scene()
    except (FacetlogError, MemoryError):
        return {"picture": None, "reasons": []}  # the row says why
    from facetlog.perception.surfaces.drawing.thumbnail import thumbnail

    picture = base64.b64encode(thumbnail(scene)).decode("ascii")
    try:
        with loaded_scene(scene, settings) as base:
            return {"picture": picture, "reasons": list(_reasons(base, question))}
    except FacetlogError as exc:  # of loading it
        return {"picture": picture, "reasons": [_reason("No reasons", [fit_on_one_line(str(exc))])]}


def _reasons(base: KnowledgeBase, question: Mistaken) -> Iterator[Reason]:
    right, answered = question["right"], question["answered"]
    found = {model: row for model, row in question["verdicts"].items() if model in base.models}
    if right in found and found[right]["state"] != HOLDS:
        yield from _iter_reason(
            f"Why not {right}", lambda: _why(base, found[right]).iter_miss_lines()
        )
    if answered in found and answered != right:
        yield from _iter_reason(f"Why {answered}", lambda: _why(base, found[answered]).lines())


def _iter_reason(title: str, ask: Callable[[], Iterable[str]]) -> Iterator[Reason]:
    """Yield the answer under its title, if there is one; what one question runs into is
    said there.
    """
    try:
        lines = list(ask())
    except FacetlogError as exc:
        lines = [fit_on_one_line(str(exc))]
    if lines:
        yield _reason(title, lines)


def _why(base: KnowledgeBase, row: Row) -> Verdict:
    """Return the proof of the verdict in the row: of its thing, with the parts that it has there.

    Without those parts all assignments would be searched anew, which in a cluttered room takes
    minutes. Sets of parts, which stand behind them in the row, follow from them: of a row's parts
    as many are given as the model knows.
    """
    named = [(part["role"], part["names"]) for part in row["parts"]]
    parts = [(role, *names) for role, names in named if len(names) == 1]
    while True:
        try:
            found = base.why(SCENE, row["model"], thing=row["thing"], parts=dict(parts))
            # of given parts it has no confidence
            return replace(found, confidence=read_confidence(row), asked=())
        except QueryError:
            if not parts:
                raise
            parts.pop()


def _reason(title: str, lines: list[str]) -> Reason:
    return {"title": title, "lines": lines}
