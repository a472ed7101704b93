"""A run on a dask.distributed cluster that exists already.

A task of the cluster is a handful of scenes. Whoever works at it hands them to a process of its own
with an engine, kept from task to task, so that limits, retries and rows are those of a run on one
machine. What is lost with a machine is done again by another.

A file is read where the work is done if it is there with the same content (the client hashes what
it can read, once), else its bytes are sent. Files beside it, as a glTF may name, are not sent. The
models' files are sent always, as they are here.
"""

import atexit
import hashlib
import json
import logging
import os
import queue
import shutil
import tempfile
import threading
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from facetlog.batch.arrow_batch import borrow_pool
from facetlog.batch.content import hash_content
from facetlog.batch.memory import compute_share_mb
from facetlog.batch.pool import ATTEMPTS, Answer, Pool, Task
from facetlog.batch.profile import Profile
from facetlog.batch.rows import error_row
from facetlog.batch.settings import Item, Settings
from facetlog.errors import EngineError, FacetlogError, InputError, make_missing_extra_error
from facetlog.kb.loading.rule_source import read_rule_sources
from facetlog.kb.recognize import rule_files
from facetlog.safe_read import MOST_SHAPE_BYTES, read_regular
from facetlog.terminal import warn

SCENES_PER_TASK = 16
"""A scheduler takes some milliseconds a task, a scene as many: so few that it is no burden."""

TASKS_PER_THREAD = 3
"""Under way for each thread of the cluster: enough that none waits, few to hold in memory."""

CONNECT_SECONDS = 10.0
"""How long a scheduler may take to answer."""

LOOKED_SECONDS = 5.0
"""Without an answer so long, it is looked whether there are workers at all."""

GONE = "the cluster went away or forgot the work: go on with --resume"

Package = dict[str, Any]
"""The settings, and all files of the models by their path below a common folder."""


@contextmanager
def cluster(address: str, settings: Settings) -> Iterator["Cluster"]:
    """Return the cluster whose scheduler is at this address; InputError if there is none.

    An engine is opened here first: it says whether the models can be used, and explains mistakes.
    """
    try:
        import distributed
    except ImportError as exc:
        raise make_missing_extra_error("--dask", "dask.distributed", "dask") from exc
    # It logs a lost connection in forty lines; what it means is said in one, here.
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with Pool(settings) as pool:
        try:
            # Untyped where it is installed.
            connect: Any = distributed.Client
            client = connect(address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as exc:
            raise InputError(f"--dask {address}: no scheduler answers there: {exc}") from exc
        with client:
            yield Cluster(client, settings, pool, address)


class Cluster:
    """The workers of a cluster, as run.py takes them."""

    def __init__(self, client: Any, settings: Settings, pool: Pool, address: str) -> None:
        self._client, self._settings, self._pool = client, settings, pool
        self._address = address
        self._deaths: Counter[Item] = Counter()

    @property
    def models_hash(self) -> str:
        """Hash of the models here; the workers of the cluster must have the same."""
        return self._pool.models_hash

    @property
    def models(self) -> tuple[str, ...]:
        """The names of the models here."""
        return self._pool.models

    @property
    def profile(self) -> Profile:
        """Where the time of the process here went."""
        return self._pool.profile

    def answers(self, tasks: Iterable[Task]) -> Iterator[Answer]:
        """Yield an answer to each task, as they come; raise EngineError if the cluster is lost.

        Scenes are classified on the cluster; mistakes are explained, and pages made, here.
        """
        every = tuple(tasks)
        yield from self._pool.answers(task for task in every if not task.classifies)
        yield from self._spread(deque(task for task in every if task.classifies))

    def _spread(self, waiting: deque[Task]) -> Iterator[Answer]:
        if not waiting:
            return
        package = pack_models(self._settings)
        done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        handed: dict[str, list[tuple[Task, bytes | None]]] = {}

        def hand(some: list[tuple[Task, bytes | None]]) -> None:
            items = [_sent(task.item, content) for task, content in some]
            future = self._client.submit(
                work, package, items, self.models_hash, pure=False, retries=0
            )
            handed[future.key] = some
            future.add_done_callback(done.put)

        def refill() -> None:
            threads = self._threads() or 1
            while waiting and len(handed) < threads * TASKS_PER_THREAD:
                count = min(SCENES_PER_TASK, max(1, len(waiting) // (threads * 2)))
                hand([(waiting.popleft(), None) for _ in range(count) if waiting])

        refill()
        while handed:
            future = self._next_done(done)
            some = handed.pop(future.key)
            if future.status == "finished":
                for (task, content), found in zip(some, future.result(), strict=True):
                    if found is None and content is None:
                        yield from self._with_content(task, hand)
                    else:
                        failed, line = found
                        yield Answer(task, line, failed)
            else:
                yield from self._lost(some, future, hand)
            future.release()
            refill()

    def _threads(self) -> int:
        """Return how many threads the workers have; EngineError if the scheduler does not say."""
        try:
            return sum(self._client.nthreads().values())
        except (OSError, TimeoutError) as exc:
            raise EngineError(GONE) from exc

    def _next_done(self, done: "queue.SimpleQueue[Any]") -> Any:
        """Wait for the next task that is done, and say so if nobody works at any."""
        warned = False
        while True:
            try:
                return done.get(timeout=LOOKED_SECONDS)
            except queue.Empty:
                if not warned and self._threads() == 0:
                    warn(
                        f"the cluster at {self._address} has no workers: start some (dask worker "
                        f"{self._address}); they are waited for, Ctrl-C ends it"
                    )
                    warned = True

    def _with_content(self, task: Task, hand: Any) -> Iterator[Answer]:
        """Hand a scene again whose file is not there, with its content if it is here."""
        try:
            content = read_regular(Path(task.item.path), MOST_SHAPE_BYTES)
        except OSError as exc:
            yield self._failed(task, f"cannot be read: {exc.strerror or exc}")
            return
        hand([(task, content)])

    def _lost(
        self, some: list[tuple[Task, bytes | None]], future: Any, hand: Any
    ) -> Iterator[Answer]:
        """Hand tasks of a lost machine out again, one by one; yield an error for
        error.
        """
        from distributed import KilledWorker

        error = future.exception() if future.status == "error" else None
        if future.status == "cancelled" or isinstance(error, CancelledError):
            raise EngineError(GONE)
        if error is None:  # it was done, and its machine went away before the answer was fetched
            hand(some)
            return
        if isinstance(error, FacetlogError):
            raise error
        if not isinstance(error, KilledWorker):
            raise EngineError(f"the cluster cannot do it: {type(error).__name__}: {error}")
        for task, content in some:
            self._deaths[task.item] += 1
            if self._deaths[task.item] >= ATTEMPTS:
                yield self._failed(task, f"workers of the cluster died at it: {error}")
            else:
                hand([(task, content)])

    def _failed(self, task: Task, why: str) -> Answer:
        error = f"{task.item.path}: {why}"
        row = error_row(task.item, self._settings, error, models_hash=self.models_hash)
        return Answer(task, json.dumps(row, separators=(",", ":")).encode(), failed=True)


def _sent(item: Item, content: bytes | None) -> dict[str, Any]:
    """Return an item with what says which content is meant: the digest, or the content itself."""
    if content is not None:
        return {"item": item.to_json(), "content": content}
    try:
        return {"item": item.to_json(), "sha256": hash_content(Path(item.path))}
    except InputError:
        return {"item": item.to_json(), "sha256": None}  # it may be there, though not here


def pack_models(settings: Settings) -> Package:
    """Return the settings with all that their models are made of, for machines that do not have
    them.

    Raise RuleSyntaxError for models that cannot be read.
    """
    named = rule_files(map(Path, settings.models))
    files = dict.fromkeys(
        file.resolve()
        for path in named
        for source in read_rule_sources(path)
        for file in source.files
    )
    if not files:
        return {"settings": settings.to_json(), "named": [], "files": {}}
    root = Path(os.path.commonpath([file.parent for file in files]))
    return {
        "settings": settings.to_json(),
        "named": [str(path.relative_to(root)) for path in named],
        "files": {str(file.relative_to(root)): _read_model_text(file) for file in files},
    }


def _read_model_text(file: Path) -> bytes:
    try:
        return read_regular(file)
    except OSError as exc:
        raise InputError(f"{file}: cannot be read: {exc.strerror or exc}") from exc


def work(
    package: Package, items: list[dict[str, Any]], models_hash: str
) -> list[tuple[bool, bytes] | None]:
    """Classify items on a worker; return whether each failed, and its row as JSON.

    None for an item whose file is not here, or has another content. Raise InputError if the models
    come out differently than on the client: another version of the program.
    """
    answers: dict[str, tuple[bool, bytes]] = {}
    settings = _apply_memory_share(_unpacked(package))
    with tempfile.TemporaryDirectory(prefix="facetlog-") as folder, borrow_pool(settings) as pool:
        if pool.models_hash != models_hash:
            raise InputError(
                "the cluster's models are not those of the client: install the same version there"
            )
        at_hand = [found for sent in items if (found := _find_item_at_hand(sent, Path(folder)))]
        for answer in pool.answers(map(Task, at_hand)):
            answers[answer.task.item.path] = (answer.failed, answer.line)
    return [answers.get(sent["item"]["path"]) for sent in items]


def _find_item_at_hand(sent: Mapping[str, Any], folder: Path) -> Item | None:
    item = Item(**sent["item"])
    if "content" in sent:
        # Under its own name, which errors tell, in a folder of its own.
        place = hashlib.sha256(item.path.encode("utf-8", "surrogateescape")).hexdigest()
        file = folder / place / Path(item.path).name
        file.parent.mkdir()
        file.write_bytes(sent["content"])
        return replace(item, file=str(file))
    try:
        return item if sent["sha256"] in (None, hash_content(Path(item.path))) else None
    except InputError:
        return None


# Of this process of the cluster: the folders of models, by the digest of their package.
_folders: dict[str, Path] = {}
_unpacking = threading.Lock()


def _apply_memory_share(settings: Settings) -> Settings:
    """Return the settings with a limit of memory: that of this worker of the cluster by its
    threads.
    """
    if settings.memory_mb is not None:
        return settings
    from distributed import get_worker

    try:
        worker: Any = get_worker()  # untyped where it is installed
    except ValueError:  # called outside of a cluster
        return settings
    limit = worker.memory_manager.memory_limit  # bytes; None: it has none
    of_mb = limit / (1 << 20) if limit else None
    return replace(settings, memory_mb=compute_share_mb(worker.state.nthreads, of_mb))


def _unpacked(package: Package) -> Settings:
    """Return the settings with the models' files on this machine; they stay while the
    process does.
    """
    settings = Settings.from_json(package["settings"])
    if not package["files"]:
        return settings
    digest = hashlib.sha256(repr(sorted(package.items())).encode()).hexdigest()
    with _unpacking:
        folder = _folders.get(digest)
        if folder is None:
            folder = _folders[digest] = Path(tempfile.mkdtemp(prefix="facetlog-models-"))
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            for name, content in package["files"].items():
                file = folder / name
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(content)
    return replace(settings, models=tuple(str(folder / name) for name in package["named"]))
