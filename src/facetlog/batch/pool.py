"""Worker processes that classify: fed in small batches, watched, ended and replaced.

Not concurrent.futures: a pool of it that loses one process loses them all, and does not say at
which task. Here each process has a socket of its own, so the scene at which one died or stayed is
known: the one for which it owes the next row.
"""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, Self

from facetlog.batch.memory import (
    MEGABYTE,
    compute_share_mb,
    format_memory_error,
    is_memory_exhausted,
)
from facetlog.batch.profile import Profile
from facetlog.batch.rows import TOOK_LONGER, error_row
from facetlog.batch.settings import Item, Settings
from facetlog.batch.worker import Word
from facetlog.batch.worker import main as serve
from facetlog.errors import EngineError, InputError, RuleSyntaxError
from facetlog.one_thread import ONE_THREAD
from facetlog.python_process import make_importing_environment, make_module_command

START_SECONDS = 120.0
"""How long a worker may take to load its engine and models; a second is usual."""

BATCH_SECONDS = 0.3
"""Work that a worker is handed at once: so much that it need not wait for more, and little to do
again or to wait for at the end."""

FADES_OVER = 20
"""Scenes over whose mean time a rare slow one fades."""
LARGEST_BATCH = 64

FAULTS = (Word.FAULT.value, Word.SPENT.value)

ATTEMPTS = 2
"""How often a scene is tried at which a worker process died: it may have been another's fault."""

STARTS = 3
"""How often in turn a worker may die while it starts: once it may have been killed, three times it
cannot start."""

LOOKED_SECONDS = 0.05
"""Processor time is looked at no more often: a tick of it is a fifth of that."""

QUEUE_SECONDS = 1.0
"""A task that takes less is not asked how long it waited for a processor."""

# getrusage(2): kilobytes, but on macOS bytes.
RSS_UNITS_PER_MB = 1 << 20 if sys.platform == "darwin" else 1 << 10

WORKER = PROGRAM = make_module_command("facetlog.batch.worker")

FORKED_MB = 100.0
"""A process that holds more is not forked: it would count as what its worker takes. The command
line holds half of it."""

# proc_pid_stat(5): fields 14 and 15 are utime and stime, in ticks. The name before them, in
# brackets, may hold blanks, so they are counted from its end; field 3 is the first after it.
USER, SYSTEM = 14 - 3, 15 - 3


# sched-stats.rst of Linux: time on a processor, time waiting for one (both nanoseconds), turns.
WAITING = 1
NANOSECONDS = 1e9


@dataclass(frozen=True, slots=True)
class Task:
    """A scene to classify, or with `mistaken` one to explain (see explain.py).

    With `page`, the SHA-256 of its content, it is one to show (scene_page.py).
    """

    item: Item
    mistaken: dict[str, Any] | None = None
    page: str | None = None

    @property
    def classifies(self) -> bool:
        """Whether the answer is a row."""
        return self.mistaken is None and self.page is None

    @property
    def message(self) -> dict[str, Any]:
        """The task as a worker takes it."""
        wanted = {"explain": self.mistaken, "page": self.page}
        asked = {key: value for key, value in wanted.items() if value is not None}
        return {**self.item.to_json(), **asked}


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a task: one line of JSON, and whether it is an error."""

    task: Task
    line: bytes
    failed: bool


@dataclass(frozen=True, slots=True)
class _Death:
    """The end of a process, and the most memory (MB) that it had resident."""

    how: str
    resident_mb: float


@dataclass(slots=True)
class _Fork:
    """A forked process, with the attributes of a Popen that are needed."""

    pid: int
    returncode: int | None = None


@dataclass(slots=True)
class _Worker:
    """One process; `assigned` are its tasks in turn, the first since `since`, when it had worked
    for `worked` seconds (None: the system does not tell), and by the first look at it waited for a
    processor for `queued`.
    """

    process: subprocess.Popen[bytes] | _Fork
    connection: Connection
    assigned: deque[Task] = field(default_factory=deque)
    since: float = field(default_factory=time.monotonic)
    worked: float | None = None
    queued: float | None = None
    ready: bool = False

    @classmethod
    def started(cls, settings: Settings, *, fork: bool = False) -> Self:
        """Return a new process that opens its engine; what it says first is whether it could."""
        ours, theirs = socket.socketpair()
        with theirs:
            process = _fork(theirs) if fork and _can_fork() else _spawn(theirs)
        worker = cls(process, Connection(ours.detach()))
        worker.send(settings.to_json())
        return worker

    def send(self, message: object) -> None:
        """Hand over a message; that the process is gone shows when it is listened to."""
        with suppress(OSError):
            self.connection.send_bytes(json.dumps(message).encode())

    def begin(self) -> None:
        """Count the time of the task that is first in turn from now on."""
        self.since, self.worked = time.monotonic(), processor_seconds(self.process.pid)
        self.queued = None

    def waited(self) -> float:
        """Return seconds since then by the clock, without those in which it waited for a processor:
        that the machine has other work is no fault of a scene.
        """
        passed = time.monotonic() - self.since
        if passed < QUEUE_SECONDS:
            return passed
        queued = get_queued_seconds(self.process.pid)
        if self.queued is None:
            self.queued = queued
        return passed - max(0.0, queued - self.queued)

    def busy(self) -> float:
        """Return seconds since then that it worked; by the clock where nothing else is known."""
        now = processor_seconds(self.process.pid)
        return self.waited() if now is None or self.worked is None else now - self.worked

    def end(self) -> "_Death":
        """End the process. Return what it died of if it had."""
        code = self.process.returncode
        resident_mb = 0.0
        if code is None:
            # It is still there, if only as what may be asked for: its number is no other's yet.
            os.kill(self.process.pid, signal.SIGKILL)
            # The socket closes before the process is gone: wait for what it says of itself.
            _, status, usage = os.wait4(self.process.pid, 0)
            code = self.process.returncode = os.waitstatus_to_exitcode(status)
            resident_mb = usage.ru_maxrss / RSS_UNITS_PER_MB
        self.connection.close()
        how = f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
        return _Death(how, resident_mb)


def _environment() -> dict[str, str]:
    return {**make_importing_environment(), **dict.fromkeys(ONE_THREAD, "1")}


def _spawn(stdin: socket.socket) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        WORKER,
        stdin=stdin.fileno(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        # A Ctrl-C of the terminal is for us.
        start_new_session=True,
        env=_environment(),
    )


def _can_fork() -> bool:
    """Return whether a fork of this process can be a worker, which then need not load again what
    is loaded: no other thread can hold a lock in it, and no engine runs in it.
    """
    with suppress(OSError):  # no Linux
        pages = int(Path("/proc/self/statm").read_bytes().split()[1])
        small = pages * os.sysconf("SC_PAGE_SIZE") <= FORKED_MB * MEGABYTE
        alone = len([*Path("/proc/self/task").iterdir()]) == 1
        return small and alone and WORKER is PROGRAM and "pyswip" not in sys.modules
    return False


def _fork(stdin: socket.socket) -> _Fork:
    pid = os.fork()
    if pid:
        return _Fork(pid)
    try:
        os.setsid()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.environ.update(_environment())
        os.dup2(stdin.fileno(), 0)
        null = os.open(os.devnull, os.O_RDWR)
        # Not closed: whoever still has the number of a file of the parent must not close another.
        for descriptor in [int(path.name) for path in Path("/proc/self/fd").iterdir()]:
            if descriptor not in (0, null):
                os.dup2(null, descriptor, inheritable=descriptor <= 2)
        serve()
    finally:
        os._exit(1)  # nothing of the parent's is done here: serve() ends the process itself


class Pool:
    """`count` worker processes with an engine each; a context manager that ends them."""

    def __init__(self, settings: Settings, count: int = 1) -> None:
        if count < 1:
            raise InputError(f"{count} workers: give a number above 0")
        self._most_mb = settings.memory_mb or compute_share_mb(count)
        self._settings = replace(settings, memory_mb=self._most_mb)
        self._starts = 0  # in turn, at which a worker died
        self._crew: list[_Worker] = []
        self._seconds_each = BATCH_SECONDS  # of a scene, at first one at a time
        self._answered = 0
        self._deaths: Counter[Item] = Counter()
        self._profiles: dict[int, bytes] = {}  # the last of each process
        self.models_hash = ""
        self.models: tuple[str, ...] = ()
        try:
            # All at once, for each takes a second; the first says whether the models can be used.
            self._crew.extend(_Worker.started(self._settings, fork=True) for _ in range(count))
            self._await_first()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all processes, whatever they are doing."""
        while self._crew:
            self._crew.pop().end()

    @property
    def profile(self) -> Profile:
        """Where the time of all workers went, if the settings ask for it."""
        total = Profile()
        for said in self._profiles.values():
            total += Profile.from_json(json.loads(said))
        return total

    def _await_first(self) -> None:
        while not self.models_hash:
            worker = self._crew[0]
            if not worker.connection.poll(START_SECONDS):
                raise EngineError(f"a worker process was not ready after {START_SECONDS:g} s")
            try:
                message = worker.connection.recv_bytes()
            except (EOFError, OSError):
                self._crew.remove(worker)
                self._died_at_start(worker.end())
                self._crew.append(_Worker.started(self._settings))
            else:
                self._got_ready(worker, message)

    def _died_at_start(self, death: _Death) -> None:
        """Count it; raise EngineError if that was not the first or second time in turn."""
        self._starts += 1
        if self._starts >= STARTS:
            raise EngineError(f"a worker process could not start, {STARTS} times: {death.how}")

    def _got_ready(self, worker: _Worker, message: bytes) -> None:
        word, content = Word(message[:1]), json.loads(message[1:])
        if word is Word.REFUSED:
            kinds = {"rules": RuleSyntaxError, "input": InputError}
            raise kinds.get(content["kind"], EngineError)(content["error"])
        if self.models_hash and content["models_hash"] != self.models_hash:
            raise InputError("the models were changed while they were in use: run it again")
        self.models_hash, self.models = content["models_hash"], tuple(content["models"])
        self._starts = 0
        worker.ready = True
        worker.begin()

    def answers(self, tasks: Iterable[Task]) -> Iterator[Answer]:
        """Yield an answer to each task, as they come; raise EngineError if no worker can be
        started.

        A worker that dies is replaced, also while it starts. The scene at which it died is tried
        once more, and has an error for an answer if another worker dies at it; so has one that
        takes too long, or more memory than a worker may take.
        """
        waiting = deque(tasks)
        while waiting or any(worker.assigned for worker in self._crew):
            for worker in self._crew:
                self._feed(worker, waiting)
            connections = {worker.connection: worker for worker in self._crew}
            for connection in wait(list(connections), timeout=self._patience()):
                yield from self._heard(connections[connection], waiting)  # type: ignore[index]
            yield from self._overdue(waiting)

    def _feed(self, worker: _Worker, waiting: deque[Task]) -> None:
        share = -(-len(waiting) // len(self._crew))
        most = int(min(LARGEST_BATCH, max(1.0, BATCH_SECONDS / self._seconds_each), share))
        if not worker.ready or len(worker.assigned) > most // 2 or not waiting:
            return
        if not worker.assigned:
            worker.begin()
        batch = [waiting.popleft() for _ in range(most)]
        worker.assigned.extend(batch)
        worker.send([task.message for task in batch])

    def _left(self, worker: _Worker) -> float:
        """Return seconds until it may be overdue: one thread works no more than the clock runs."""
        waited = worker.waited()
        if not worker.ready:
            return START_SECONDS - waited
        by_clock = self._settings.clock_seconds - waited
        if waited < self._settings.seconds:
            return min(by_clock, self._settings.seconds - waited)
        return min(by_clock, max(LOOKED_SECONDS, self._settings.seconds - worker.busy()))

    def _patience(self) -> float:
        """Return seconds until the first of the workers may be overdue."""
        return max(0.0, min(self._left(w) for w in self._crew if w.assigned or not w.ready))

    def _heard(self, worker: _Worker, waiting: deque[Task]) -> Iterator[Answer]:
        """Yield the answers that a worker has sent, all that there are."""
        try:
            while True:
                message = worker.connection.recv_bytes()
                if not worker.ready:
                    self._got_ready(worker, message)
                elif message[:1] == Word.PROFILE.value:
                    self._profiles[worker.process.pid] = message[1:]
                else:
                    yield self._answer(worker, message)
                    if message[:1] == Word.SPENT.value:
                        worker.end()
                        self._replace(worker, waiting)
                        return
                if not worker.connection.poll():
                    return
        except (EOFError, OSError):
            yield from self._died(worker, waiting)

    def _answer(self, worker: _Worker, message: bytes) -> Answer:
        now = time.monotonic()
        self._answered += 1
        share = 1.0 / min(self._answered, FADES_OVER)
        self._seconds_each += share * (now - worker.since - self._seconds_each)
        worker.begin()
        return Answer(worker.assigned.popleft(), message[1:], message[:1] in FAULTS)

    def _died(self, worker: _Worker, waiting: deque[Task]) -> Iterator[Answer]:
        death = worker.end()
        if not worker.ready:
            self._died_at_start(death)
        elif worker.assigned:
            task = worker.assigned[0]
            self._deaths[task.item] += 1
            if self._deaths[task.item] >= ATTEMPTS:
                worker.assigned.popleft()
                why = f"the worker process died at it, {ATTEMPTS} times: {death.how}"
                if is_memory_exhausted(death.resident_mb, self._most_mb):
                    why = format_memory_error(self._most_mb)
                yield self._failed(task, why)
        self._replace(worker, waiting)

    def _overdue(self, waiting: deque[Task]) -> Iterator[Answer]:
        for worker in tuple(self._crew):
            if not worker.ready and worker.waited() >= START_SECONDS:
                raise EngineError(f"a worker process was not ready after {START_SECONDS:g} s")
            limit = self._limit_reached(worker)
            if limit and not worker.connection.poll():
                worker.end()
                yield self._failed(worker.assigned.popleft(), f"{TOOK_LONGER} {limit}")
                self._replace(worker, waiting)

    def _limit_reached(self, worker: _Worker) -> str:
        """Return the limit of time that a worker is beyond at its scene, in words; '' if there is
        none.
        """
        settings, waited = self._settings, worker.waited()
        if not worker.ready or not worker.assigned or waited < settings.seconds:
            return ""
        if waited >= settings.clock_seconds:
            return f"{settings.clock_seconds:g} s by the clock"
        return f"{settings.seconds:g} s" if worker.busy() >= settings.seconds else ""

    def _replace(self, worker: _Worker, waiting: deque[Task]) -> None:
        waiting.extendleft(reversed(worker.assigned))
        self._crew[self._crew.index(worker)] = _Worker.started(self._settings)

    def _failed(self, task: Task, why: str) -> Answer:
        error = f"{task.item.path}: {why}"
        row = error_row(task.item, self._settings, error, models_hash=self.models_hash)
        return Answer(task, json.dumps(row, separators=(",", ":")).encode(), failed=True)


def processor_seconds(pid: int) -> float | None:
    """Return seconds that a process has worked, all its threads together; None where nothing says
    it.

    >>> (processor_seconds(os.getpid()) or 1.0) > 0.0
    True
    """
    try:
        content = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:
        return None
    fields = content.rpartition(b")")[2].split()
    return (int(fields[USER]) + int(fields[SYSTEM])) / os.sysconf("SC_CLK_TCK")


def get_queued_seconds(pid: int) -> float:
    """Return seconds that threads of a process could have worked, and no processor was free for
    them.

    0.0 where nothing says it.

    >>> get_queued_seconds(os.getpid()) >= 0.0
    True
    """
    total = 0
    for path in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with suppress(OSError, IndexError, ValueError):  # the thread has ended
            total += int(path.read_bytes().split()[WAITING])
    return total / NANOSECONDS
