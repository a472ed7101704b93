"""Verdicts on a growing collection, from a separate process so that the robot never waits.

Reconstruction keeps a processor busy for seconds, in which no thread of the same process would
renew the robot's lease in time. The pictures are read from the folder, where each is whole: one at
a time while it grows (folder_judge.py), and all at once at the end. A recording is written there,
too (judge_process.py).
"""

import socket
import subprocess
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeAlias

from facetlog.errors import EngineError, FacetlogError
from facetlog.kb.confidence import DEGREES_ASKED, Confidence
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict_text import NO_MODEL
from facetlog.perception.name_lists import named
from facetlog.perception.types import FloatArray
from facetlog.python_process import make_importing_environment, make_module_command

if TYPE_CHECKING:
    from facetlog.exploring.open_questions import Interest, Needs
    from facetlog.kb.explaining.verdict import Recognition

__all__ = [
    "EndRecording",
    "Explore",
    "Judge",
    "Opening",
    "Question",
    "ViewVerdict",
    "ViewVerdicts",
    "verdict_of",
]


@dataclass(frozen=True, slots=True)
class Opening:
    """First message to the judging process; `mcap` is the file to record to, if any."""

    folder: Path
    models: tuple[Path, ...]
    trusted: bool
    mcap: Path | None


@dataclass(frozen=True, slots=True)
class Judge:
    """Judge the first `views` views, with `finally_` all at once and their poses corrected; with
    `degrees` in place of confidences. The answer is a ViewVerdict.
    """

    views: int
    finally_: bool = False
    degrees: bool = False


@dataclass(frozen=True, slots=True)
class Explore:
    """Judge the first `views` views at once, and list what is undecided of what is of interest."""

    views: int
    interest: "Interest"


@dataclass(frozen=True, slots=True)
class EndRecording:
    """End the recording, with all views that are there; the answer is None."""


Question: TypeAlias = Judge | Explore | EndRecording


@dataclass(frozen=True, slots=True)
class ViewVerdict:
    """The verdicts on the first `views` views.

    `best` has a line for what holds; `excluded` and `unknown` are names of models that hold for
    nothing there; `problems` name views that were read since the verdict before and not used, or
    contradict others. `document` is all of it as `recognize --json` prints it; `fault` is why there
    is none. `outlines` are what holds, each with those of its faces (n, 3), of the last verdict.
    `needs` are what is undecided, where that was asked and something is known.
    """

    views: int
    best: tuple[str, ...] = ()
    excluded: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()
    document: Mapping[str, object] | None = None
    fault: str = ""
    outlines: tuple[tuple[str, tuple[FloatArray, ...]], ...] = field(default=(), compare=False)
    needs: "Needs | None" = field(default=None, compare=False)

    @property
    def line(self) -> str:
        """One line: what it is, what it is not, what is undecided, or why there is no verdict."""
        if self.fault:
            return "; ".join((self.fault, *self.problems))
        said = list(self.best) or [NO_MODEL]
        if self.unknown:
            said.append(f"unknown: {named(self.unknown)}")
        if self.excluded:
            said.append(f"no: {named(self.excluded)}")
        said += self.problems
        return "; ".join(said)


def verdict_of(
    recognition: "Recognition", views: int, problems: tuple[str, ...] = (), *, degrees: bool = False
) -> ViewVerdict:
    """Return the verdict on so many views; with `degrees` in place of confidences."""
    best = recognition.best
    if degrees:
        best = tuple(
            replace(verdict, confidence=Confidence(reason=DEGREES_ASKED)) for verdict in best
        )
    # Of several things a model may be open for one and excluded for another: then it is open.
    open_for = {v.model: None for v in recognition.verdicts if v.state is State.UNKNOWN}
    asked = {verdict.model: None for verdict in recognition.verdicts}
    unknown = tuple(model for model in open_for if model not in recognition.models)
    return ViewVerdict(
        views,
        tuple(verdict.summary for verdict in best),
        tuple(m for m in asked if m not in recognition.models and m not in open_for),
        unknown,
        problems,
        recognition.to_json(),
    )


class _JudgeDiedError(EngineError):
    """The process that judges has ended, by a fault of its own or because it was killed."""

    def __init__(self) -> None:
        super().__init__("the process that judges views has died: no more verdicts")


class _JudgeProcess:
    """The judging process; asked by one thread at a time.

    Not concurrent.futures: its queues have locks outside of both processes, which are left behind
    when this one is killed, and reported on the terminal. A socket goes with them.
    """

    def __init__(self, opening: Opening) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            descriptor = theirs.fileno()
            self.popen = subprocess.Popen(
                make_module_command("facetlog.judging.judge_process", str(descriptor)),
                pass_fds=[descriptor],
                stdin=subprocess.DEVNULL,
                # Ctrl-C and Ctrl-Z end the collection; that process ends with it.
                start_new_session=True,
                env=make_importing_environment(),
            )
        self._line = Connection(ours.detach())
        self._line.send(opening)
        self.has_died = False

    def answer(self, question: Question) -> Any:
        """Return the answer; raise what was raised there, _JudgeDiedError if there is none."""
        try:
            self._line.send(question)
            found = self._line.recv()
        except (EOFError, OSError) as exc:
            self.has_died = True
            raise _JudgeDiedError from exc
        if isinstance(found, FacetlogError):
            raise found
        return found

    def close(self) -> None:
        """End the process, whatever it is doing."""
        self._line.close()
        self.popen.wait()


class ViewVerdicts:
    """A process that is asked after every view; answers come in the order of the questions.

    A question that waits while a newer one comes is dropped: of views that come faster than they
    are judged, the newest is of interest.
    """

    def __init__(
        self,
        folder: Path,
        models: tuple[Path, ...] = (),
        *,
        trusted: bool = False,
        mcap: Path | None = None,
    ) -> None:
        self._records = mcap is not None
        self._judge = _JudgeProcess(Opening(folder, models, trusted, mcap))
        # A thread that waits for its answers: questions that it has not asked yet can be dropped.
        self._asking = ThreadPoolExecutor(1)
        self._asked: list[Future[ViewVerdict]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for future in self._asked:
            future.cancel()
        try:
            if self._records and not self._judge.has_died:
                self._submit_question(EndRecording()).result()
        except _JudgeDiedError:
            pass  # said by the answer to a question
        finally:
            # Nobody waits for what it still answers.
            self._judge.popen.kill()
            self._asking.shutdown(wait=True, cancel_futures=True)
            self._judge.close()

    @property
    def process(self) -> int:
        """The number of the process that judges."""
        return self._judge.popen.pid

    def ask(self, views: int, *, finally_: bool = False, degrees: bool = False) -> None:
        """Ask for a verdict on the first `views` views of the folder; with `degrees` in place of
        confidences.

        Only at the end are poses corrected by the pictures, which takes longer than to drive on.
        """
        self._asked = [future for future in self._asked if not future.cancel()]
        # That it has died was said by the answer to an earlier question.
        if not self._judge.has_died:
            self._asked.append(self._submit_question(Judge(views, finally_, degrees)))

    def explored(self, views: int, interest: "Interest") -> ViewVerdict:
        """Wait for the verdict on the first `views` views with what is undecided.

        It has degrees, which grow with what was seen.
        """
        return _wait_for_answer(self._submit_question(Explore(views, interest)))

    def ready(self) -> list[ViewVerdict]:
        """Return the verdicts that have come since it was last called, without waiting."""
        done: list[Future[ViewVerdict]] = []
        waiting: list[Future[ViewVerdict]] = []
        for future in self._asked:
            (done if future.done() else waiting).append(future)
        self._asked = waiting
        return list(map(_wait_for_answer, done))

    def last(self) -> list[ViewVerdict]:
        """Wait for all verdicts that are still to come."""
        waiting, self._asked = self._asked, []
        return list(map(_wait_for_answer, waiting))

    def _submit_question(self, question: Question) -> Future[Any]:
        return self._asking.submit(self._judge.answer, question)


def _wait_for_answer(future: Future[ViewVerdict]) -> ViewVerdict:
    try:
        return future.result()
    except _JudgeDiedError as exc:
        return ViewVerdict(0, fault=str(exc))
