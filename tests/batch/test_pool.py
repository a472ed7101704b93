"""Worker processes: each scene has an answer, whatever becomes of the one that works at it."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.batch.pool import Pool, Task
from facetlog.batch.settings import Item, Settings
from facetlog.errors import EngineError, RuleSyntaxError
from facetlog.one_thread import ONE_THREAD
from facetlog.python_process import make_importing_environment
from tests.batch.fake_worker import PAUSE
from tests.batch.fakes import fake_workers, scene_files


@pytest.fixture(autouse=True)
def _fake() -> Iterator[None]:
    with fake_workers():
        yield


def _rows(items: tuple[Item, ...], *, count: int = 2, seconds: float = 60.0) -> dict[str, dict]:
    with Pool(Settings(seconds=seconds), count) as pool:
        answers = list(pool.answers(map(Task, items)))
    assert len(answers) == len(items)
    assert all(json.loads(a.line)["path"] == a.task.item.path for a in answers)
    assert all(a.failed is (json.loads(a.line)["error"] is not None) for a in answers)
    return {Path(a.task.item.path).stem: json.loads(a.line) for a in answers}


@pytest.mark.parametrize("count", [1, 3])
def test_each_scene_has_one_answer_whatever_the_number_of_workers(
    count: int, tmp_path: Path
) -> None:
    items = scene_files(tmp_path, *(f"box-{i}" for i in range(300)), "bad-1")
    rows = _rows(items, count=count)
    assert rows["bad-1"]["error"]
    assert {row["model"] for name, row in rows.items() if name != "bad-1"} == {"box"}


def test_a_scene_at_which_workers_die_has_an_error_and_costs_no_other(tmp_path: Path) -> None:
    items = scene_files(tmp_path, "box-1", "die-1", "table-1", "die-2", "chair-1")
    rows = _rows(items)
    for name in ("die-1", "die-2"):
        assert "died at it, 2 times: ended by SIGKILL" in rows[name]["error"]
    assert [rows[n]["model"] for n in ("box-1", "table-1", "chair-1")] == ["box", "table", "chair"]


@pytest.mark.slow
def test_a_scene_that_takes_too_long_has_an_error_and_costs_no_other(tmp_path: Path) -> None:
    items = scene_files(tmp_path, *(f"box-{i}" for i in range(5)), "slow-1", "table-1")
    rows = _rows(items, count=1, seconds=0.5)
    assert rows["slow-1"]["error"].endswith("took longer than 2.5 s by the clock")
    assert rows["table-1"]["model"] == "table"


@pytest.mark.slow
def test_what_works_too_long_is_ended_and_what_waits_its_turn_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(PAUSE, "0.8")
    rows = _rows(scene_files(tmp_path, "box-1", "busy-1", "table-1"), count=1, seconds=0.5)
    assert rows["busy-1"]["error"].endswith("took longer than 0.5 s")
    assert (rows["box-1"]["model"], rows["table-1"]["model"]) == ("box", "table")


@pytest.mark.slow
def test_time_in_which_no_processor_is_free_does_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("facetlog.batch.pool.get_queued_seconds", lambda _: time.monotonic())
    monkeypatch.setenv(PAUSE, "3.0")  # twice what it may take by the clock
    rows = _rows(scene_files(tmp_path, "box-1"), count=1, seconds=0.3)
    assert rows["box-1"]["error"] is None


def test_models_that_cannot_be_used_are_the_error_of_their_kind() -> None:
    with pytest.raises(RuleSyntaxError, match="refused:1: no model"):
        Pool(Settings(models=("refused",)))


def test_answers_that_nobody_wants_any_more_leave_no_process(tmp_path: Path) -> None:
    with Pool(Settings(), 1) as pool:
        answers = pool.answers(map(Task, scene_files(tmp_path, "box-1", "slow-1")))
        next(answers)
        ids = [worker.process.pid for worker in pool._crew]
    with pytest.raises(ProcessLookupError):
        os.kill(ids[0], 0)


def test_workers_killed_while_they_replace_another_are_replaced(tmp_path: Path) -> None:
    late = tmp_path / "late"
    late.write_text("0")
    items = scene_files(tmp_path, "box-1", "once-1", "table-1")
    with Pool(Settings(models=(str(late),))) as pool:
        late.write_text("2")
        rows = [json.loads(answer.line) for answer in pool.answers(map(Task, items))]
    assert [row["error"] for row in rows] == [None, None, None]


def test_a_worker_that_never_starts_ends_the_run_and_leaves_no_process(tmp_path: Path) -> None:
    late = tmp_path / "late"
    late.write_text("0")
    items = scene_files(tmp_path, "once-1")
    with Pool(Settings(models=(str(late),))) as pool:
        late.write_text("100")
        with pytest.raises(EngineError, match="could not start, 3 times: ended by SIGKILL"):
            list(pool.answers(map(Task, items)))
    assert late.read_text() == "97"


def test_a_worker_whose_memory_ran_out_is_replaced_and_its_next_scenes_lose_nothing(
    tmp_path: Path,
) -> None:
    rows = _rows(scene_files(tmp_path, "box-1", "full-1", "full-2", "table-1"), count=1)
    assert [rows[name]["error"] is None for name in ("box-1", "full-1", "full-2", "table-1")] == [
        *(True, False, False, True)
    ]


FORKING = """
import atexit, os, sys
from facetlog.batch import pool
from facetlog.batch.settings import Item, Settings

def refuse(*_):
    raise AssertionError("another Python was started")

pool._spawn = refuse
held = open(sys.argv[1], "w")
held.write("once")
atexit.register(held.write, "at exit")
with pool.Pool(Settings(), 2) as crew:
    print(*(worker.process.pid for worker in crew._crew))
    list(crew.answers([pool.Task(Item("none.json"))]))
    print(end="", flush=True)
    sys.stdin.read()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="forks on Linux alone")
def test_a_small_process_forks_workers_that_hold_nothing_of_it_and_end_with_it(
    tmp_path: Path,
) -> None:
    held = tmp_path / "held"
    with subprocess.Popen(
        [sys.executable, "-c", FORKING, str(held)],
        env=make_importing_environment() | dict.fromkeys(ONE_THREAD, "1"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        workers = [Path("/proc", pid) for pid in process.stdout.readline().decode().split()]
        assert len(workers) == 2
        for worker in workers:
            assert str(held) not in {str(file.readlink()) for file in (worker / "fd").iterdir()}
        process.kill()
    end = time.monotonic() + 20
    while any(map(_runs, workers)) and time.monotonic() < end:
        time.sleep(0.01)
    assert not any(map(_runs, workers))
    assert held.read_text() == ""


def _runs(process: Path) -> bool:
    try:
        return (process / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
