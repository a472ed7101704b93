"""Verdicts on a collection while it grows: in a process of its own, so that the robot never waits.

Reconstruction keeps a processor busy for seconds, in which no thread of the same process would
renew the robot's lease in time. The pictures are read from the folder, where each is whole: one at
a time while it grows (stream.py), all at once at the end.
"""

import signal
from collections.abc import Mapping
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from facetlog.errors import FacetlogError
from facetlog.kb.explaining.proof import State
from facetlog.perception.step_clock import StepClock

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.perception.online.online_scene import OnlineScene

__all__ = ["ViewVerdict", "ViewVerdicts"]

_judges: "list[_Judge]" = []
"""Of the worker process: who judges, once its knowledge base is open."""


@dataclass(frozen=True, slots=True)
class ViewVerdict:
    """What the models say of the first `views` views.

    `best` has a line for what holds; `excluded` and `unknown` are names of models that hold for
    nothing there; `problems` name views that were read since the verdict before and not used, or
    contradict others. `document` is all of it as `recognize --json` prints it; `fault` is why there
    is none.
    """

    views: int
    best: tuple[str, ...] = ()
    excluded: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()
    document: Mapping[str, object] | None = None
    fault: str = ""

    @property
    def line(self) -> str:
        """One line: what it is, what it is not and what is open, or why nothing can be said."""
        if self.fault:
            return "; ".join((self.fault, *self.problems))
        said = list(self.best) or ["no model matches"]
        if self.unknown:
            said.append(f"unknown: {', '.join(self.unknown)}")
        if self.excluded:
            said.append(f"no: {', '.join(self.excluded)}")
        said += self.problems
        return "; ".join(said)


class ViewVerdicts:
    """A worker process that is asked after every view; answers come in the order of the questions.

    A question that waits while a newer one comes is dropped: of views that come faster than they
    are judged, the newest is of interest.
    """

    def __init__(
        self, folder: Path, models: tuple[Path, ...] = (), *, trusted: bool = False
    ) -> None:
        # Not by fork: Prolog and threads do not outlive one.
        self._pool = ProcessPoolExecutor(
            1, get_context("spawn"), initializer=_open, initargs=(folder, models, trusted)
        )
        self._asked: list[Future[ViewVerdict]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._pool.shutdown(wait=True, cancel_futures=True)

    def ask(self, views: int, *, finally_: bool = False) -> None:
        """Asks for a verdict on the first `views` views of the folder.

        Only at the end are poses corrected by the pictures, which takes longer than to drive on.
        """
        self._asked = [future for future in self._asked if not future.cancel()]
        try:
            self._asked.append(self._pool.submit(_judge, views, finally_))
        except BrokenProcessPool:
            # Said by the answer to an earlier question.
            return

    def ready(self) -> list[ViewVerdict]:
        """The verdicts that have come since it was last called; does not wait."""
        done: list[Future[ViewVerdict]] = []
        waiting: list[Future[ViewVerdict]] = []
        for future in self._asked:
            (done if future.done() else waiting).append(future)
        self._asked = waiting
        return list(map(_answer, done))

    def last(self) -> list[ViewVerdict]:
        """All verdicts that are still to come; waits for them."""
        waiting, self._asked = self._asked, []
        return list(map(_answer, waiting))


def _answer(future: Future[ViewVerdict]) -> ViewVerdict:
    try:
        return future.result()
    except (BrokenProcessPool, CancelledError):
        return ViewVerdict(0, fault="the process that judges views has died: no more verdicts")


def _open(folder: Path, models: tuple[Path, ...], trusted: bool) -> None:
    """In the worker: opens the models once for all questions."""
    from facetlog.pipeline import open_models

    # Ctrl-C and Ctrl-Z end the collection; this process ends with it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTSTP, signal.SIG_IGN)
    _judges.append(_Judge(folder / "transforms.json", open_models(models, trusted=trusted)))


def _judge(views: int, finally_: bool) -> ViewVerdict:
    """In the worker: the verdict on the first views of the folder."""
    judge = _judges[0]
    try:
        recognition = judge.at_once(views) if finally_ else judge.so_far(views)
    except FacetlogError as exc:
        return ViewVerdict(views, fault=str(exc))
    if recognition is None:
        return ViewVerdict(
            views, fault="too little was seen to say what is there", problems=judge.problems()
        )
    # Of several things a model may be open for one and excluded for another: then it is open.
    open_for = {v.model: None for v in recognition.verdicts if v.state is State.UNKNOWN}
    asked = {verdict.model: None for verdict in recognition.verdicts}
    unknown = tuple(model for model in open_for if model not in recognition.models)
    return ViewVerdict(
        views,
        tuple(verdict.summary for verdict in recognition.best),
        tuple(m for m in asked if m not in recognition.models and m not in open_for),
        unknown,
        judge.problems(),
        recognition.to_json(),
    )


class _Judge:
    """Knows what the views read so far show."""

    def __init__(self, path: Path, base: "KnowledgeBase") -> None:
        from facetlog.perception.reading.follow_views import FollowedViews

        self._path, self._base = path, base
        self._source = FollowedViews(path, timeout=0.0)
        self._online: OnlineScene | None = None
        self._read = 0
        self._problems: list[str] = []

    def problems(self) -> tuple[str, ...]:
        """What is wrong with views that were read since this was last asked."""
        problems, self._problems = tuple(self._problems), []
        return problems

    def so_far(self, views: int) -> "Recognition | None":
        """What the first views show, read one after the other, None if that is too little."""
        from facetlog.perception.online.online_scene import OnlineScene
        from facetlog.stream import judged

        for view in islice(self._source, max(views - self._read, 0)):
            if self._online is None:
                self._online = OnlineScene(
                    name=self._source.name,
                    up=self._source.up,
                    metric=self._source.metric,
                    error_kind=self._source.error_kind,
                )
            if problem := self._online.add(view).problem:
                self._problems.append(problem)
            self._read += 1
        return None if self._online is None else judged(self._base, self._online)[1]

    def at_once(self, views: int) -> "Recognition":
        """The same with the poses corrected by the pictures, from all of them together."""
        from facetlog.pipeline import recognize_views, views_from

        clock = StepClock()
        found = views_from(self._path, unit=None, progress=None, clock=clock)
        first = replace(found, views=found.views[:views])
        return recognize_views(first, base=self._base, clock=clock).recognition
