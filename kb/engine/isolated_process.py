"""Prolog in a process of its own, with a memory limit: for rules that strangers wrote.

The same requests as engine_pool.py takes go over a socket, as JSON and bytes; nothing that the
process says is ever unpickled. If it dies, whoever waits gets an error that says so, and the next
request starts another one, in which what was loaded is loaded again.
"""

import json
import logging
import os
import queue
import resource
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from itertools import count
from multiprocessing.connection import Connection
from typing import TypeAlias

from facetlog.errors import EngineError
from facetlog.kb.engine.engine import OK, Piece, Reply, piece_text
from facetlog.kb.engine.engine_pool import (
    CLOCK_FACTOR,
    GRACE_SECONDS,
    LONGEST_WAIT,
    Replies,
    engine_pool,
)
from facetlog.python_process import import_path, python_module

__all__ = ["IsolatedProcess"]

START_SECONDS = 20.0
"""How long Python and Prolog may take to start; a third of a second is usual."""

MARGIN_SECONDS = GRACE_SECONDS + 0.3
"""What the process may take beyond a question's own time limit, before it is killed."""

MEGABYTE = 1 << 20

SERVING_STACK_BYTES = 1 << 20  # of a thread that only passes on what a worker says

_LOG = logging.getLogger(__name__)

_Message: TypeAlias = Mapping[str, object]
_Inbox: TypeAlias = "queue.SimpleQueue[tuple[Reply, bool] | EngineError]"


class _Answering:
    """The replies of one request to the process, pulled one by one."""

    def __init__(self, owner: "_Process", number: int, seconds: float) -> None:
        self._owner, self._number, self._seconds = owner, number, seconds
        self.inbox: _Inbox = queue.SimpleQueue()
        self._state = "running"

    def __iter__(self) -> "_Answering":
        return self

    def __next__(self) -> Reply:
        if self._state == "ended":
            raise StopIteration
        if self._state == "waiting":
            self._state = "running"
            self._owner.send({"do": "next", "id": self._number})
        try:
            wait = min(CLOCK_FACTOR * self._seconds + MARGIN_SECONDS, LONGEST_WAIT)
            answer = self.inbox.get(timeout=wait)
        except queue.Empty:
            self._state = "ended"
            self._owner.kill()
            raise EngineError(
                "the time limit was reached, and the isolated process was ended"
            ) from None
        except BaseException:  # Ctrl-C while waiting
            self.close()
            raise
        if isinstance(answer, EngineError):
            self._state = "ended"
            raise answer
        reply, last = answer
        self._state = "ended" if last else "waiting"
        if last and not reply:
            raise StopIteration
        return reply

    def close(self) -> None:
        """Ends the request; harmless if it has ended."""
        if self._state != "ended":
            self._state = "ended"
            self._owner.drop(self._number)

    def __del__(self) -> None:
        self.close()


class _Process:
    """One running process and the thread that reads what it says."""

    def __init__(self, memory_mb: int) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            self.popen = subprocess.Popen(
                python_module("facetlog.kb.engine.isolated_process", str(memory_mb)),
                stdin=theirs.fileno(),
                cwd=os.sep,
                stdout=subprocess.DEVNULL,
                # A Ctrl-C of the terminal is for us; we tell the process what to stop.
                start_new_session=True,
                env=_environment(),
            )
        self._memory_mb = memory_mb
        self._connection = Connection(ours.detach())
        self._numbers = count(1)
        # Not the _Answering: one that is dropped half-read must be closed.
        self._open: dict[int, _Inbox] = {}
        # Re-entrant: what is dropped may be collected, and closed, while the lock is held.
        self._lock = threading.RLock()
        self.dead: EngineError | None = None
        # What is to be sent; a process that does not read must not hold up who writes.
        self._outbox: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self.reported = False  # whether someone who waited knows that it is dead
        for task in (self._read, self._write):
            threading.Thread(target=task, name="facetlog-isolated", daemon=True).start()

    def ask(self, operation: str, text: str, seconds: float) -> _Answering:
        number = next(self._numbers)
        answering = _Answering(self, number, seconds)
        with self._lock:
            if self.dead is not None:
                raise self.dead
            self._open[number] = answering.inbox
        self.send(
            {"do": "ask", "id": number, "operation": operation, "text": text, "seconds": seconds}
        )
        return answering

    def drop(self, number: int) -> None:
        """Nobody waits for this request any more."""
        self.send({"do": "close", "id": number})
        with self._lock:
            self._open.pop(number, None)

    def send(self, message: _Message) -> None:
        # Encoded here: without memory for it the sender gets the error, not a thread of ours.
        self._outbox.put(json.dumps(message).encode())

    def _write(self) -> None:
        try:
            while (message := self._outbox.get()) is not None:
                self._connection.send_bytes(message)
        except (OSError, MemoryError):
            self.kill()  # or is now: the reading thread wakes those who wait

    def kill(self) -> None:
        """Ends the process; who asks from now on gets another one."""
        self.popen.kill()
        self._died()

    def end(self) -> None:
        """Ends the process for good."""
        self.reported = True
        self.kill()

    def _read(self) -> None:
        try:
            while True:
                head = json.loads(self._connection.recv_bytes())
                pieces = tuple(self._piece(kind) for kind in head["pieces"])
                self._deliver(int(head["id"]), pieces, bool(head["last"]), head.get("error"))
        except (EOFError, OSError, ValueError, KeyError, TypeError, MemoryError):
            self._died()

    def _piece(self, kind: str) -> Piece:
        data = self._connection.recv_bytes()
        return data.decode("utf-8", "surrogatepass") if kind == "text" else data

    def _deliver(self, number: int, pieces: Reply, last: bool, error: object) -> None:
        with self._lock:
            inbox = self._open.pop(number, None) if last else self._open.get(number)
        if inbox is not None:
            inbox.put((pieces, last) if error is None else EngineError(str(error)))

    def _died(self) -> None:
        self.popen.kill()
        code = self.popen.wait()
        with self._lock:
            if self.dead is not None:
                return
            self.dead = EngineError(self._obituary(code))
            waiting, self._open = tuple(self._open.values()), {}
            self.reported = self.reported or bool(waiting)
        self._outbox.put(None)
        for inbox in waiting:
            inbox.put(self.dead)

    def _obituary(self, code: int) -> str:
        how = f"with exit code {code}"
        if code < 0:
            how = f"by signal {-code} ({signal.Signals(-code).name})"
        return (
            f"the isolated process ended {how}; it may have reached its memory limit of "
            f"{self._memory_mb} MB. The next question starts a new one"
        )


class IsolatedProcess:
    """The way to Prolog in a process of its own; started again when it died.

    Requests with a `state` change what is loaded: they are kept, and sent to a new process.
    """

    def __init__(self, memory_mb: int) -> None:
        self._memory_mb = memory_mb
        self._lock = threading.RLock()
        self._owner = os.getpid()
        self._closed = False
        self._process: _Process | None = None
        self._kept: dict[str, list[tuple[str, str]]] = {}

    def replies(self, operation: str, text: str, *, seconds: float) -> _Answering:
        """The replies to a request, one for each solution."""
        return self._running().ask(operation, text, seconds)

    def reply(
        self, operation: str, text: str, *, seconds: float, state: str | None = None
    ) -> Reply:
        """The only reply to a request that has one; what it loaded belongs to `state`."""
        replies = self.replies(operation, text, seconds=seconds)
        try:
            reply = next(replies, ())
        finally:
            replies.close()
        if state is not None and reply and piece_text(reply[0]).startswith(OK):
            with self._lock:
                self._kept.setdefault(state, []).append((operation, text))
        return reply

    def when_quiet(self, operation: str, text: str, *, state: str) -> bool:
        """Forgets `state` when all that is running now has ended; False: that may be later."""
        with self._lock:
            self._kept.pop(state, None)
            process = self._process
        if process is not None and process.dead is None:
            process.send({"do": "quiet", "id": 0, "operation": operation, "text": text})
        return False

    def close(self) -> None:
        """Ends the process; there will be no other one."""
        with self._lock:
            self._closed = True
            if self._process is not None:
                self._process.end()
                self._process = None

    def kill(self) -> None:
        """Ends the process without waiting for anything."""
        self._closed = True
        process = self._process
        if process is not None:
            process.popen.kill()

    @property
    def process_id(self) -> int | None:
        """Of the process that runs now."""
        with self._lock:
            return None if self._process is None else self._process.popen.pid

    def _running(self) -> _Process:
        if self._owner != os.getpid():
            raise EngineError(
                "Prolog belongs to the process that started it: start worker processes by spawn"
            )
        with self._lock:
            if self._closed:
                raise EngineError("the knowledge base is closed")
            if self._process is not None and self._process.dead is not None:
                if not self._process.reported:
                    _LOG.warning("%s", self._process.dead)
                self._process = None
            if self._process is None:
                self._process = _Process(self._memory_mb)
                for requests in tuple(self._kept.values()):
                    for operation, text in requests:
                        next(self._process.ask(operation, text, START_SECONDS), None)
            return self._process


def _environment() -> dict[str, str]:
    """What the process needs to know of ours: where programs and Python's modules are."""
    kept = ("PATH", "LANG", "LC_ALL", "HOME", "SWI_HOME_DIR", "LIBSWIPL_PATH", "LD_LIBRARY_PATH")
    return {
        **{k: v for k, v in os.environ.items() if k in kept},
        "PYTHONPATH": import_path(),
        # Each thread would reserve 64 MB of its own, of the address space that is limited.
        "MALLOC_ARENA_MAX": "2",
    }


class _Server:
    """The other side: serves the requests that come in by its standard input."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lock = threading.Lock()
        self._wishes: dict[int, queue.SimpleQueue[bool]] = {}
        self._replies: dict[int, Replies] = {}
        self._pool = engine_pool()

    def run(self) -> None:
        for message in self._messages():
            number = int(str(message["id"]))
            match message["do"]:
                case "ask":
                    self._wishes[number] = queue.SimpleQueue()
                    threading.Thread(target=self._serve, args=(message,), daemon=True).start()
                case "next" | "close" as wish:
                    wishes = self._wishes.get(number)
                    if wishes is not None:
                        wishes.put(wish == "next")
                    replies = self._replies.get(number)
                    if wish == "close" and replies is not None:
                        replies.close()
                case "quiet":
                    self._pool.when_quiet(str(message["operation"]), str(message["text"]))

    def _messages(self) -> Iterator[_Message]:
        try:
            while True:
                yield json.loads(self._connection.recv_bytes())
        except (EOFError, OSError):
            return

    def _serve(self, message: _Message) -> None:
        number = int(str(message["id"]))
        wishes = self._wishes[number]
        replies = None
        try:
            replies = self._pool.replies(
                str(message["operation"]),
                str(message["text"]),
                seconds=float(str(message["seconds"])),
            )
            self._replies[number] = replies
            for reply in replies:
                self._say(number, reply, last=replies.ended)
                if replies.ended or not wishes.get():
                    return
            self._say(number, (), last=True)
        except Exception as exc:  # whatever it is, the other side must not wait for ever
            self._say(number, (), last=True, error=str(exc) or type(exc).__name__)
        finally:
            if replies is not None:
                replies.close()
            self._replies.pop(number, None)
            self._wishes.pop(number, None)

    def _say(self, number: int, reply: Reply, *, last: bool, error: str | None = None) -> None:
        kinds = ["text" if isinstance(piece, str) else "bytes" for piece in reply]
        head = {"id": number, "last": last, "error": error, "pieces": kinds}
        with self._lock:
            self._connection.send_bytes(json.dumps(head).encode())
            for piece in reply:
                data = piece.encode("utf-8", "surrogatepass") if isinstance(piece, str) else piece
                self._connection.send_bytes(data)


def main() -> None:
    """Serves until the other side closes, within the memory (MB) that the argument says."""
    memory = int(sys.argv[1]) * MEGABYTE
    threading.stack_size(SERVING_STACK_BYTES)
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    # A worker's limit is its own: Prolog that gets no memory may stand still.
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (hard, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))  # it writes no file
    _Server(Connection(os.dup(0))).run()
    os._exit(0)  # nobody is left to wait for what still runs


if __name__ == "__main__":
    main()
