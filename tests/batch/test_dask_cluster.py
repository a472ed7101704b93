"""The same run on a cluster: what its workers do, and a real scheduler with two of them."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from facetlog.batch import dask_cluster
from facetlog.batch.arrow_batch import close_idle_pools
from facetlog.batch.content import hash_content
from facetlog.batch.dask_cluster import work
from facetlog.batch.output import read_rows
from facetlog.batch.pool import Pool, Task
from facetlog.batch.settings import Settings
from facetlog.cli import main
from facetlog.errors import EngineError, InputError
from facetlog.perception.surfaces.exact_solids.polyhedra import chair, cuboid, table
from facetlog.perception.surfaces.scene_file import write_scene
from tests.batch.fake_worker import hash_of
from tests.batch.fakes import fake_workers, scene_files

MODEL = """model slab
  "Anything that has a flat face."
  face a
  seen: share(a) at least 0 %
"""


@pytest.fixture
def _engines() -> Iterator[None]:
    """Fake engines, which do not outlive the test."""
    close_idle_pools()
    with fake_workers():
        yield
    close_idle_pools()


def _told(items: list[dict[str, Any]], models_hash: str) -> list[str | None]:
    """The error of each row, '' for none, None for a scene that is not at hand."""
    package = {"settings": Settings().to_json(), "named": [], "files": {}}
    found = []
    for answer in work(package, items, models_hash):
        error = None if answer is None else json.loads(answer[1])["error"] or ""
        found.append(error)
    return found


@pytest.mark.usefixtures("_engines")
def test_a_file_counts_as_there_only_with_the_same_content(tmp_path: Path) -> None:
    (item,) = scene_files(tmp_path, "box-1")
    here = item.to_json()
    digest = hash_content(Path(item.path))
    sent: list[dict[str, Any]] = [
        {"item": here, "sha256": digest},
        {"item": {"path": "gone.json"}, "sha256": digest},
        {"item": {"path": "gone.json"}, "sha256": None},
    ]
    assert _told(sent, hash_of(())) == ["", None, None]
    assert _told([{"item": here, "sha256": "0"}], hash_of(())) == [None]
    # not to be read by the client, yet there
    assert _told([{"item": here, "sha256": None}], hash_of(())) == [""]


@pytest.mark.usefixtures("_engines")
def test_other_models_on_the_cluster_are_refused() -> None:
    with pytest.raises(InputError, match="install the same version there"):
        _told([], "another hash")


class _Slow:
    """A client, and the one task that it is handed; `threads` are the workers' each time asked."""

    key, status = "task", "finished"

    def __init__(self, *threads: int) -> None:
        self.threads = list(threads)

    def nthreads(self) -> dict[str, int]:
        if not self.threads:
            raise OSError("connection refused")
        return {"worker": self.threads.pop(0)}

    def submit(self, *_: object, **__: object) -> "_Slow":
        return self

    def add_done_callback(self, told: Callable[["_Slow"], None]) -> None:
        threading.Timer(0.5, told, (self,)).start()

    def result(self) -> list[tuple[bool, bytes]]:
        return [(False, b"{}")]

    def release(self) -> None:
        pass


@pytest.mark.parametrize(("threads", "warned"), [(0, 1), (2, 0)])
def test_a_cluster_without_workers_is_named_once_and_waited_for(
    threads: int,
    warned: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(dask_cluster, "LOOKED_SECONDS", 0.05)
    tasks = map(Task, scene_files(tmp_path, "box-1"))
    with fake_workers(), Pool(Settings()) as pool:
        client = _Slow(*[threads] * 100)
        answers = list(dask_cluster.Cluster(client, Settings(), pool, "tcp://a:1").answers(tasks))
    assert [answer.line for answer in answers] == [b"{}"]
    assert capsys.readouterr().err.count("tcp://a:1 has no workers") == warned


def test_a_scheduler_that_goes_away_ends_the_run_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_cluster, "LOOKED_SECONDS", 0.05)
    tasks = map(Task, scene_files(tmp_path, "box-1"))
    with fake_workers(), Pool(Settings()) as pool:
        cluster = dask_cluster.Cluster(_Slow(1), Settings(), pool, "tcp://a:1")
        with pytest.raises(EngineError, match="the cluster went away"):
            list(cluster.answers(tasks))


@contextmanager
def _running(module: str, *argv: str, folder: Path) -> Iterator["subprocess.Popen[bytes]"]:
    paths = os.pathsep.join(path for path in sys.path if path)
    folder.mkdir(exist_ok=True)
    process = subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{module}", *argv, "--no-dashboard"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths, "XDG_CACHE_HOME": str(folder)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


@pytest.mark.slow
def test_a_cluster_comes_to_the_same_rows_though_a_worker_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    Path("in").mkdir()
    makers = (cuboid, table, chair)
    for i in range(120):
        write_scene(makers[i % 3](), Path("in", f"s{i:03d}.json"))
    Path("in", "s050.json").write_text("{")
    Path("slab.model").write_text(MODEL)
    models = ["--models", "slab.model"]
    assert main(["classify", "in", *models, "-o", "here.jsonl", "--workers", "2"]) == 0
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    elsewhere = tmp_path / "elsewhere"  # relative paths mean nothing there: the bytes are sent
    scheduler = ("--host", "127.0.0.1", "--port", str(port))
    # No nanny: it would start another worker in the place of the killed one.
    worker = (address, "--nthreads", "1", "--no-nanny")
    with (
        _running("dask_scheduler", *scheduler, folder=elsewhere),
        _running("dask_worker", *worker, folder=elsewhere) as first,
        _running("dask_worker", *worker, folder=elsewhere),
    ):
        _wait_for_workers(address, 2)
        argv = ["classify", "in", *models, "-o", "there.jsonl", "--dask", address]
        there = _command(argv)
        _wait_for_rows(Path("there.jsonl.partial"), 20)
        first.send_signal(signal.SIGKILL)
        assert there.wait(300) == 0
    here, cluster = (
        list(map(_timeless, read_rows(Path(p)))) for p in ("here.jsonl", "there.jsonl")
    )
    assert len(here) == 120
    assert cluster == here


def _timeless(row: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in row.items() if key != "seconds"}


def _command(argv: list[str]) -> "subprocess.Popen[bytes]":
    paths = os.pathsep.join(path for path in sys.path if path)
    code = "import sys; from facetlog.cli import main; sys.exit(main(sys.argv[1:]))"
    return subprocess.Popen(
        [sys.executable, "-c", code, *argv], env={**os.environ, "PYTHONPATH": paths}
    )


def _wait_for_workers(address: str, count: int) -> None:
    import distributed

    connect: Any = distributed.Client
    with connect(address, timeout=60, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=60)


def _wait_for_rows(journal: Path, least: int) -> None:
    end = time.monotonic() + 200
    while time.monotonic() < end:
        if journal.exists() and journal.read_bytes().count(b"\n") > least:
            return
        time.sleep(0.02)
    raise AssertionError("the cluster did not begin")
