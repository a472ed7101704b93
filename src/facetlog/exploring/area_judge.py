"""What the views of one place show, while an area is explored."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import FacetlogError
from facetlog.exploring.needs import Interest, needs_of
from facetlog.mapping.room_map import ScenePart, part_of
from facetlog.mapping.visit import chosen_views
from facetlog.perception.step_clock import StepClock
from facetlog.robot.collecting.record import TRANSFORMS_FILE
from facetlog.view_verdicts import ViewVerdict, verdict_of

if TYPE_CHECKING:
    from facetlog.kb.knowledge_base import KnowledgeBase

__all__ = ["place_verdict"]


def place_verdict(
    folder: Path, names: tuple[str, ...], interest: Interest, base: "KnowledgeBase"
) -> tuple[ViewVerdict, ScenePart]:
    """The verdict on the views with these names of a collection's folder, all at once, with what is
    undecided, and the things that they show, in the world. A fault is in the verdict.
    """
    from facetlog.perception.reading.read_views import read_views
    from facetlog.pipeline import recognize_views

    try:
        found = read_views(folder / TRANSFORMS_FILE)
        own = [k for k, view in enumerate(found.views) if view.name in names]
        look = chosen_views(found, own, found.name)
        seen = recognize_views(look.views, base=base, clock=StepClock())
        needs = needs_of(seen.scene, seen.recognition, interest)
        part = part_of(seen, look, found.name)
    except FacetlogError as exc:
        return ViewVerdict(len(names), fault=str(exc)), ScenePart((), ())
    return replace(verdict_of(seen.recognition, len(names), degrees=True), needs=needs), part
