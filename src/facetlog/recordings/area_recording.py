"""The recording of an explored area: each view with what those of its place showed by then.

A recursion over all views of a room would be over views that show nothing of one another, and
whose places odometry has moved apart by more than a thing. So views are judged place by place, all
of one place at once, as the explorer does while the robot drives: a recording shows what it knew.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import FacetlogError
from facetlog.mapping.place import Place, places_of, thing_at
from facetlog.perception.fewest_views import FEWEST_VIEWS
from facetlog.recordings.moments import read_moment
from facetlog.robot.collecting.record import Taken, read_log, read_record

if TYPE_CHECKING:
    from facetlog.exploring.area_judge import PlaceSeen
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.recordings.moments import Recorder

__all__ = ["AreaRecording"]


@dataclass(eq=False, slots=True)
class AreaRecording:
    """Records the views of a `folder` that grows, each once, in the order in which they were taken.

    InputError where the folder cannot be read or the recording not be written.
    """

    folder: Path
    base: "KnowledgeBase"
    recorder: "Recorder"
    _recorded: set[str] = field(default_factory=set)
    _until: float = 0.0

    def add(self, names: tuple[str, ...], seen: "PlaceSeen | None") -> None:
        """Takes what the views of a place showed when the last one of these was taken, None if they
        make no scene. It is recorded, and before it what was taken since the view before.
        """
        last = names[-1]
        if last in self._recorded:
            return
        self._record_to(last, seen)

    def rest(self) -> None:
        """Records all views that are left."""
        self._record_to(None, None)

    def _record_to(self, last: str | None, seen: "PlaceSeen | None") -> None:
        _, taken = read_record(self.folder)
        places = places_of(read_log(self.folder))
        for number, view in enumerate(taken, start=1):
            if view.name not in self._recorded:
                place = _place_of(view, places)
                if view.name != last:
                    self._record(view, place, self._seen(place, taken[:number]))
                else:
                    self._record(view, place, seen)
            if view.name == last:
                return

    def _seen(self, place: Place | None, taken: Sequence[Taken]) -> "PlaceSeen | None":
        """What the views of a place that were taken show; nothing of views on the way."""
        from facetlog.exploring.area_judge import place_seen

        if place is None:
            return None
        names = tuple(view.name for view in taken if view.name in place.names)
        if len(names) < FEWEST_VIEWS:
            return None
        try:
            return place_seen(self.folder, names, self.base)
        except FacetlogError:
            # So few views or views that contradict one another show nothing: more may come.
            return None

    def _record(self, view: Taken, place: Place | None, seen: "PlaceSeen | None") -> None:
        scene = None if seen is None else seen.found.scene
        said = None if place is None or seen is None else _of_thing(place, seen)
        moment = read_moment(self.folder, view.name, self._until, scene, said)
        self._recorded.add(view.name)
        if moment is None:
            return
        self._until = view.time
        self.recorder.add(replace(moment, place=0 if place is None else place.number))


def _place_of(view: Taken, places: Sequence[Place]) -> Place | None:
    return next((place for place in places if view.name in place.names), None)


def _of_thing(place: Place, seen: "PlaceSeen") -> "Recognition":
    """The verdicts on the thing at a place: what else is in its pictures has views of its own."""
    thing = thing_at(place, seen.part.things)
    name = None if thing is None else thing.source[1]
    found = seen.found.recognition
    return replace(found, verdicts=tuple(each for each in found.verdicts if each.thing == name))
