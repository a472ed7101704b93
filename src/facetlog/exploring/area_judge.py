"""What the views of one place show, while an area is explored."""

from dataclasses import dataclass, replace
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
    from facetlog.pipeline import Recognised

__all__ = ["PlaceSeen", "PlaceVerdict", "place_seen", "place_verdict"]


@dataclass(frozen=True, eq=False, slots=True)
class PlaceSeen:
    """What the views of one place show together: their judged scene, and things in the world."""

    found: "Recognised"
    part: ScenePart


def place_seen(folder: Path, names: tuple[str, ...], base: "KnowledgeBase") -> PlaceSeen:
    """What the views with these names of a collection's folder show, all at once; FacetlogError
    where they make no scene.
    """
    from facetlog.perception.reading.read_views import read_views
    from facetlog.pipeline import recognize_views

    views = read_views(folder / TRANSFORMS_FILE)
    own = [k for k, view in enumerate(views.views) if view.name in names]
    look = chosen_views(views, own, views.name)
    found = recognize_views(look.views, base=base, clock=StepClock())
    return PlaceSeen(found, part_of(found, look, views.name))


@dataclass(frozen=True, eq=False, slots=True)
class PlaceVerdict:
    """The verdict on views of one place, with what is undecided, and what they have `seen`; None
    where they make no scene: then the verdict says why.
    """

    verdict: ViewVerdict
    seen: PlaceSeen | None = None

    @property
    def part(self) -> ScenePart:
        """What they give to a map."""
        return ScenePart() if self.seen is None else self.seen.part


def place_verdict(
    folder: Path, names: tuple[str, ...], interest: Interest, base: "KnowledgeBase"
) -> PlaceVerdict:
    """The verdict on the views with these names of a collection's folder."""
    try:
        seen = place_seen(folder, names, base)
        recognition = seen.found.recognition
        needs = needs_of(seen.found.scene, recognition, interest)
    except FacetlogError as exc:
        return PlaceVerdict(ViewVerdict(len(names), fault=str(exc)))
    verdict = verdict_of(recognition, len(names), degrees=True)
    return PlaceVerdict(replace(verdict, needs=needs), seen)
