"""Prolog on threads of its own: questions nest, interleave, and can be stopped at any time.

Every request runs on a worker, a thread with an attached Prolog engine, and an open question keeps
its worker until it is exhausted or closed. The caller only waits, so a signal reaches Python at
once; the worker is then interrupted by thread_signal/2. One more worker, the keeper, starts
SWI-Prolog and delivers those interrupts. A worker that does not react, since it is inside a
builtin written in C, is given up; so is, in the end, each that was interrupted.
"""

import atexit
import logging
import os
import queue
import sys
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count

from facetlog.errors import EngineError
from facetlog.kb.engine.engine import OK, CrashError, Engine, Reply, decode_piece, start

__all__ = ["MOST_OPEN", "Replies", "engine_pool"]

_LOG = logging.getLogger(__name__)

GRACE_SECONDS = 0.5
"""How long an interrupted question may take to end before its worker is given up."""

CLOCK_FACTOR = 5.0
"""How many seconds a limited second of processor time may take on a busy machine."""

LONGEST_WAIT = threading.TIMEOUT_MAX  # seconds; what is more counts as that

MOST_OPEN = 128
"""Questions that may be open at once: each has a thread and Prolog stacks."""

QUIET_SECONDS = 60.0  # for a clean-up that nobody waits for

STACK_BYTES = 8 << 20
"""Size of the C stack, on which Prolog reads and compiles nested terms by recursion: reading.pl."""

# Of the setting of threads' stacks.
_spawning = threading.Lock()

IDLE_KEPT = 4  # workers that wait for the next question; more are let go

_STILL_RUNNING = "the time limit was reached, inside a step that cannot be interrupted"


@dataclass(slots=True)
class _Job:
    """One request: what the caller sends, and where the replies go."""

    number: int
    operation: str
    text: str
    replies: "queue.SimpleQueue[tuple[Reply, bool] | EngineError]" = field(
        default_factory=queue.SimpleQueue
    )
    # True asks for the next reply, False closes.
    wishes: "queue.SimpleQueue[bool]" = field(default_factory=queue.SimpleQueue)
    interrupted: bool = False


class _Worker:
    """A thread with a Prolog engine, serving one job after the other."""

    def __init__(self, pool: "EnginePool") -> None:
        self._pool = pool
        self.prolog_thread = -1
        self.jobs: queue.SimpleQueue[_Job | None] = queue.SimpleQueue()
        self.ended = False
        """Whether it will not call Prolog any more."""
        self._ready = threading.Event()
        self._trouble: EngineError | None = None
        self._clock: int | None = None
        self._spent = 0.0
        self.thread = threading.Thread(target=self._run, name="facetlog-prolog", daemon=True)
        with _spawning:  # the size is a setting of the whole process
            before = threading.stack_size(STACK_BYTES)
            try:
                self.thread.start()
            finally:
                threading.stack_size(before)

    @property
    def processor_seconds(self) -> float:
        """The processor time that the thread has used; the clock's where the system counts none."""
        if self._clock is None:
            return time.monotonic()
        with suppress(OSError):  # of a thread that has ended
            self._spent = time.clock_gettime(self._clock)
        return self._spent

    def wait_ready(self) -> None:
        """Wait until the worker can serve; raise what hinders it."""
        self._ready.wait()
        if self._trouble is not None:
            raise self._trouble

    def _run(self) -> None:
        if sys.platform == "linux":
            self._clock = time.pthread_getcpuclockid(threading.get_ident())
        try:
            engine = self._begin()
        except Exception as exc:
            # Report any failure to the threads that wait for the start.
            said = exc if isinstance(exc, EngineError) else None
            self._trouble = said or EngineError(f"SWI-Prolog does not start: {exc}")
            self.ended = True
            return
        finally:
            self._ready.set()
        while (job := self.jobs.get()) is not None:
            self._serve(engine, job)
        self._end(engine)
        self.ended = True

    def _begin(self) -> Engine:
        engine = start()
        self.prolog_thread = engine.attach()
        return engine

    def _end(self, engine: Engine) -> None:
        engine.detach()

    def _serve(self, engine: Engine, job: _Job) -> None:
        solutions = engine.request(job.number, job.operation, job.text)
        answer: tuple[Reply, bool] | EngineError = ((), True)
        try:
            for reply, last in solutions:
                answer = reply, last
                if last:
                    break
                job.replies.put(answer)
                if not job.wishes.get():
                    return
            else:
                answer = (), True
        except CrashError:
            answer = EngineError(f"SWI-Prolog did not answer the request {job.operation}")
        except EngineError as exc:
            answer = exc
        except Exception as exc:  # the worker must outlive it, and the caller must hear of it
            answer = EngineError(f"the request {job.operation} failed: {exc}")
        finally:
            solutions.close()
            # Free before the caller knows: its next request finds this worker again.
            self._pool.put_back(self)
        job.replies.put(answer)


class _Keeper(_Worker):
    """The thread that starts SWI-Prolog, whose main thread it is as long as the process lives."""

    def _begin(self) -> Engine:
        engine = start()
        if not engine.is_main_thread:  # an earlier keeper, whose caller was interrupted, began
            engine.attach()
        return engine

    def _end(self, engine: Engine) -> None:
        # Prolog cannot be stopped while a thread is in it, and says so; the process ends anyway.
        if engine.is_main_thread and self._pool.all_ended:
            engine.stop()


class Replies:
    """The replies of one request, pulled one by one; an iterator that may be dropped at any time.

    `seconds` is the processor time that Prolog may take for all of them together, and a fifth of
    the time by the clock: a machine that is busy with other things ends no question. What the
    caller does between two replies does not count.
    """

    def __init__(self, pool: "EnginePool", worker: _Worker, job: _Job, seconds: float) -> None:
        self._pool, self._worker, self._job = pool, worker, job
        self._left, self._clock_left = seconds, CLOCK_FACTOR * seconds
        self._state = "running"  # then waiting, running, ..., ended
        self._changing = threading.Lock()  # of the state
        self._reading = threading.Lock()  # one thread reads, another may close

    @property
    def ended(self) -> bool:
        """Whether the last reply was read, or the question was ended."""
        return self._state == "ended"

    def __iter__(self) -> "Replies":
        return self

    def __next__(self) -> Reply:
        with self._reading:
            with self._changing:
                if self._state == "ended":
                    raise StopIteration
                if self._state == "waiting":
                    self._state = "running"
                    self._job.wishes.put(True)
            try:
                answer = self._wait()
            except BaseException:
                self._leave(False)
                raise
            if isinstance(answer, EngineError):
                self._leave(True)
                raise answer
            reply, last = answer
            with self._changing:
                closed = self._state == "ended"
                if not closed:
                    self._state = "ended" if last else "waiting"
            if closed:
                raise EngineError("the question was stopped")
            if last and not reply:
                raise StopIteration
            return reply

    def _wait(self) -> tuple[Reply, bool] | EngineError:
        begin, spent = time.monotonic(), self._worker.processor_seconds
        try:
            while True:
                used = self._worker.processor_seconds - spent
                clock = time.monotonic() - begin
                left = min(self._left - used, self._clock_left - clock)
                try:
                    answer = self._job.replies.get(timeout=min(max(0.0, left), LONGEST_WAIT))
                except queue.Empty:
                    if left > 0.0:
                        continue  # the machine was busy with other things meanwhile
                    self._pool.interrupt(self._worker, self._job, "time_limit")
                    break
                self._left -= self._worker.processor_seconds - spent
                self._clock_left -= time.monotonic() - begin
                return answer
        except BaseException:  # Ctrl-C while waiting
            self._pool.interrupt(self._worker, self._job, "stopped")
            raise
        try:
            # What an interrupted question still says, mostly that it was interrupted.
            return self._job.replies.get(timeout=GRACE_SECONDS)
        except queue.Empty:
            raise EngineError(_STILL_RUNNING) from None

    def _leave(self, last: bool) -> None:
        """Stop reading. A worker that is still at it leaves when it next looks for a wish."""
        with self._changing:
            if self._state != "ended":
                self._state = "ended"
                if not last:
                    self._job.wishes.put(False)

    def close(self) -> None:
        """End the question; harmless if it has ended. A running one is interrupted."""
        with self._changing:
            running = self._state == "running"
        if running:
            self._pool.interrupt(self._worker, self._job, "stopped")
        self._leave(False)

    def __del__(self) -> None:
        self.close()


class EnginePool:
    """Prolog for any thread of this process; made by `engine_pool`."""

    def __init__(self) -> None:
        self._process = os.getpid()
        self._numbers = count(1)
        # Re-entrant: what is collected while it is held may send requests.
        self._lock = threading.RLock()
        self._idle: list[_Worker] = []
        self._busy: dict[_Worker, _Job] = {}
        # All that were begun, until they have ended: also those that were let go or given up.
        self._workers: set[_Worker] = set()
        # Requests that wait until the jobs with these numbers have ended.
        self._later: list[tuple[set[int], _Job]] = []
        self._closed = False
        self._keeper = _Keeper(self)
        self._at_exit = False

    def wait_ready(self) -> None:
        """Wait until SWI-Prolog runs; EngineError if it cannot."""
        self._keeper.wait_ready()
        with self._lock:
            if not self._at_exit:
                # Not before: what pyswip does at the end must come after it.
                atexit.register(self.close)
                self._at_exit = True

    def replies(self, operation: str, text: str, *, seconds: float) -> Replies:
        """Return the replies to a request, one for each solution; the first one is being worked
        out.

        Raise EngineError in a process forked from the one that started Prolog, if too many
        questions are open, and after `close`.
        """
        if self._process != os.getpid():
            raise EngineError(
                "Prolog belongs to the process that started it: start worker processes by spawn"
            )
        job = _Job(next(self._numbers), operation, text)
        worker = self._take(job)
        try:
            worker.wait_ready()
        except BaseException:  # it cannot, or Ctrl-C: its place must not be lost
            self.put_back(worker)
            raise
        replies = Replies(self, worker, job, seconds)
        worker.jobs.put(job)
        return replies

    def reply(self, operation: str, text: str, *, seconds: float) -> Reply:
        """Return the only reply to a request that has one."""
        replies = self.replies(operation, text, seconds=seconds)
        try:
            return next(replies, ())
        finally:
            replies.close()

    def _take(self, job: _Job) -> _Worker:
        with self._lock:
            if self._closed:
                raise EngineError("the knowledge base was closed with the process")
            if len(self._busy) >= MOST_OPEN:
                raise EngineError(
                    f"{MOST_OPEN} questions are open at once: close some, or read them to the end"
                )
            worker = self._idle.pop() if self._idle else self._start_worker()
            self._busy[worker] = job
        return worker

    def _start_worker(self) -> _Worker:
        self._workers = {worker for worker in self._workers if not worker.ended}
        worker = _Worker(self)
        self._workers.add(worker)
        return worker

    @property
    def all_ended(self) -> bool:
        """Whether no worker will call Prolog any more."""
        return all(worker.ended for worker in self._workers)

    def put_back(self, worker: _Worker) -> None:
        """Take the worker back, which is free again."""
        if worker is self._keeper:
            return
        with self._lock:
            ended = self._busy.pop(worker, None)
            due = self._take_due_jobs(ended.number) if ended is not None else []
            # An interrupt in the wrong instant leaves the limit of inferences of its question
            # behind, and no later one would get farther: SWI-Prolog keeps the lower of two.
            spoilt = ended is not None and ended.interrupted
            if self._closed or spoilt or (len(self._idle) >= IDLE_KEPT and not due):
                worker.jobs.put(None)
            else:
                self._idle.append(worker)
        for job in due:
            # Nobody waits for its reply; once the pool is closed it is not served any more.
            with suppress(EngineError):
                self._take(job).jobs.put(job)

    def _take_due_jobs(self, ended: int) -> list[_Job]:
        for awaited, _ in self._later:
            awaited.discard(ended)
        due = [job for awaited, job in self._later if not awaited]
        self._later = [(awaited, job) for awaited, job in self._later if awaited]
        return due

    def send_when_quiet(self, operation: str, text: str) -> bool:
        """Send the request when all questions that are open now have ended; at once if none is.

        For what an open question may still be looking at. No one gets the reply; returned is
        whether it was sent at once, and is done.
        """
        with self._lock:
            open_now = {job.number for job in self._busy.values()}
            if open_now:
                self._later.append((open_now, _Job(next(self._numbers), operation, text)))
        if open_now:
            return False
        try:
            reply = self.reply(operation, text, seconds=QUIET_SECONDS)
        except EngineError as exc:  # what was asked before must not fail by it
            _LOG.info("%s: %s", operation, exc)
            return False
        return bool(reply) and decode_piece(reply[0]).startswith(OK)

    def interrupt(self, worker: _Worker, job: _Job, why: str) -> None:
        """Make Prolog leave this job; nothing happens if the worker has left it already.

        The worker serves no other job after this one.
        """
        job.interrupted = True
        note = _Job(0, "interrupt", f"interrupt({worker.prolog_thread},{job.number},{why})")
        self._keeper.jobs.put(note)

    def close(self) -> None:
        """End all questions, for the end of the process."""
        with self._lock:
            self._closed = True
            busy, idle, workers = dict(self._busy), tuple(self._idle), tuple(self._workers)
        if self._process != os.getpid():
            return
        for worker, job in busy.items():
            self.interrupt(worker, job, "stopped")
            job.wishes.put(False)
        for worker in (*busy, *idle):
            worker.jobs.put(None)
        end = time.monotonic() + GRACE_SECONDS
        for worker in workers:
            worker.thread.join(max(0.0, end - time.monotonic()))
        self._keeper.jobs.put(None)
        self._keeper.thread.join(GRACE_SECONDS)


_starting = threading.Lock()
_pools: list[EnginePool] = []


def engine_pool() -> EnginePool:
    """Return the process's Prolog, started at the first call; EngineError if it cannot be."""
    with _starting:
        if not _pools:
            _pools.append(EnginePool())
        pool = _pools[0]
    try:
        pool.wait_ready()
    except EngineError:
        with _starting:
            if pool in _pools:
                _pools.remove(pool)  # another call tries again
        raise
    return pool
