"""Judge the views of a growing folder one after the other, and record them."""

from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.perception.step_clock import StepClock

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.perception.online.online_scene import OnlineScene
    from facetlog.pipeline import Recognised
    from facetlog.recordings.frames import Recorder

__all__ = ["FolderJudge"]

POSES_FILE = "transforms.json"


class FolderJudge:
    """Judges the views that are read so far; each goes to the `recorder` as it is read, with the
    verdicts on the views up to it.
    """

    def __init__(
        self, folder: Path, base: "KnowledgeBase", recorder: "Recorder | None" = None
    ) -> None:
        from facetlog.perception.reading.follow_views import FollowedViews

        self.folder, self.base, self._recorder = folder, base, recorder
        self._source = FollowedViews(folder / POSES_FILE, timeout=0.0)
        self._online: OnlineScene | None = None
        self._read = 0
        self._recorded_until = 0.0
        self._problems: list[str] = []

    def problems(self) -> tuple[str, ...]:
        """Return the problems of views that were read since the last call."""
        problems, self._problems = tuple(self._problems), []
        return problems

    def so_far(self, views: int) -> "Recognition | None":
        """Judge the first views, read one after the other; return None if that is too little."""
        from facetlog.perception.online.online_scene import OnlineScene
        from facetlog.stream import judged

        waiting = ""
        for view in islice(self._source, max(views - self._read, 0)):
            if self._online is None:
                self._online = OnlineScene(
                    name=self._source.name,
                    up=self._source.up,
                    metric=self._source.metric,
                    error_kind=self._source.error_kind,
                )
            if waiting and self._recorder is not None:
                # Views of an earlier run come together, as do those that nobody asked about.
                self._record(waiting, judged(self.base, self._online)[1])
            if problem := self._online.add(view).problem:
                self._problems.append(problem)
            self._read += 1
            waiting = view.name
        found = None if self._online is None else judged(self.base, self._online)[1]
        if waiting:
            self._record(waiting, found)
        return found

    def at_once(self, views: int) -> "Recognised":
        """Judge the first views all together, with their poses corrected by the pictures."""
        from facetlog.pipeline import read_views_from, recognize_views

        clock = StepClock()
        path = self.folder / POSES_FILE
        found = read_views_from(path, unit=None, progress=None, clock=clock)
        first = replace(found, views=found.views[:views])
        return recognize_views(first, base=self.base, clock=clock)

    def _record(self, name: str, found: "Recognition | None") -> None:
        """Record a view with what is known after it."""
        if self._recorder is None or self._online is None:
            return
        from facetlog.recordings.frames import read_moment

        since, scene = self._recorded_until, self._online.scene
        moment = read_moment(self.folder, name, since, scene, found)
        if moment is None:
            return
        self._recorded_until = moment.taken.time
        self._recorder.add(moment)
