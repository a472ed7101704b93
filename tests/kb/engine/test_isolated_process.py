"""Prolog in a process of its own: the same answers, and what happens when it dies."""

import logging
import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import EngineError, QueryError, RuleSyntaxError
from facetlog.kb.engine.terms import Atom
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from tests.kb.fresh import python
from tests.patience import allowed

ENDLESS = "between(1, inf, X), X < 0"
UNLIMITED = Limits(seconds=60.0, inferences=10**15)


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase(isolated=True, memory_mb=400) as base:
        base.load_scene("s", [("face", "f1"), ("face", "f2")])
        yield base


def usable(base: KnowledgeBase) -> bool:
    return list(base.query("face(F)")) == [(Atom("f1"),), (Atom("f2"),)]


def kill(base: KnowledgeBase) -> None:
    assert base.process_id is not None
    os.kill(base.process_id, signal.SIGKILL)


def test_it_is_another_process_with_the_same_answers(base: KnowledgeBase) -> None:
    assert base.process_id not in (None, os.getpid())
    assert usable(base)
    rows = list(base.query("between(1, 5000, X), Y = 'ä€'"))
    assert rows == [(i, Atom("ä€")) for i in range(1, 5001)]
    assert base.query("between(1, 3000, X), Y is X/2.0").arrays()["Y"].sum() == 2250750.0


def test_questions_interleave_and_are_dropped(base: KnowledgeBase) -> None:
    first, second = base.query("between(1, inf, X)"), base.query("between(10, inf, X)")
    assert [next(first), next(second), next(first)] == [(1,), (10,), (2,)]
    del first, second
    assert usable(base)


def test_a_question_that_cannot_be_asked_is_an_error_here(base: KnowledgeBase) -> None:
    with pytest.raises(QueryError):
        base.query("halt")
    assert usable(base)


def test_a_kill_is_reported_and_the_next_question_works(base: KnowledgeBase) -> None:
    threading.Timer(0.3, kill, (base,)).start()
    with pytest.raises(EngineError, match=r"signal 9 \(SIGKILL\)"):
        list(base.query(ENDLESS, limits=UNLIMITED))
    assert usable(base)


def test_a_kill_between_questions_is_logged(
    base: KnowledgeBase, caplog: pytest.LogCaptureFixture
) -> None:
    before = base.process_id
    kill(base)
    time.sleep(0.3)
    with caplog.at_level(logging.WARNING):
        assert usable(base)
    assert "SIGKILL" in caplog.text
    assert base.process_id != before


def test_what_was_dropped_is_not_loaded_again(base: KnowledgeBase) -> None:
    base.load_scene("other", [("face", "f3")])
    base.drop_scene("other")
    base.load_scene("s", [("face", "f1"), ("face", "f2")])
    kill(base)
    time.sleep(0.3)
    assert usable(base)


def test_limits_hold(base: KnowledgeBase) -> None:
    begin = time.monotonic()
    with pytest.raises(EngineError, match="time limit"):
        list(base.query(ENDLESS, limits=Limits(seconds=0.3, inferences=10**15)))
    assert time.monotonic() - begin < allowed(0.3)
    assert usable(base)


@pytest.mark.slow
def test_a_process_that_does_not_answer_is_replaced(base: KnowledgeBase) -> None:
    assert base.process_id is not None
    os.kill(base.process_id, signal.SIGSTOP)
    begin = time.monotonic()
    with pytest.raises(EngineError, match="time limit"):
        list(base.query("face(F)", limits=Limits(seconds=0.2)))
    assert time.monotonic() - begin < allowed(0.2)
    assert usable(base)


def test_its_memory_is_limited(base: KnowledgeBase) -> None:
    # Far more than the process may have: Prolog's own limit does not come into play.
    hungry = "findall(X, between(1, 100000000, X), L), length(L, N)"
    with pytest.raises(EngineError, match="memory"):
        list(base.query(hungry, limits=Limits(seconds=30.0, inferences=10**15, stack_mb=50_000)))
    assert usable(base)


def test_ctrl_c_is_heeded(base: KnowledgeBase) -> None:
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        list(base.query(ENDLESS, limits=UNLIMITED))
    assert time.monotonic() - begin < allowed(0.3)
    assert usable(base)


def test_python_functions_cannot_be_called_from_there(base: KnowledgeBase) -> None:
    with pytest.raises(ValueError, match="isolated"):
        base.define("f", 0, lambda: True)


def test_closing_ends_the_process(base: KnowledgeBase) -> None:
    number = base.process_id
    assert number is not None
    base.close()
    with pytest.raises(ProcessLookupError):
        os.kill(number, 0)


def test_nothing_is_imported_from_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "queue.py").write_text("open('touched', 'w').close()\nraise ImportError\n")
    monkeypatch.chdir(tmp_path)
    with KnowledgeBase(isolated=True) as base:
        assert list(base.query("X = 1")) == [(1,)]
    assert not (tmp_path / "touched").exists()


@pytest.mark.slow
def test_a_process_that_does_not_read_holds_nobody_up(base: KnowledgeBase) -> None:
    assert base.process_id is not None
    os.kill(base.process_id, signal.SIGSTOP)
    begin = time.monotonic()
    with pytest.raises(EngineError, match="time limit"):
        base.query("X = Y", bindings={"Y": "a" * 3_000_000}, limits=Limits(seconds=0.2))
    assert time.monotonic() - begin < allowed(0.2)
    assert usable(base)


def test_what_failed_to_load_is_not_loaded_again(base: KnowledgeBase, tmp_path: Path) -> None:
    faulty = tmp_path / "faulty.pl"
    faulty.write_text("nonsense(")
    for _ in range(3):
        with pytest.raises(RuleSyntaxError):
            base.load_rules(faulty, trusted=True)
    kill(base)
    time.sleep(0.3)
    assert usable(base)
    assert "faulty" not in str(base._process and base._process._kept)


def test_a_closed_base_starts_no_other_process(base: KnowledgeBase) -> None:
    base.close()
    with pytest.raises(EngineError, match="closed"):
        base.query("X = 1")
    assert base.process_id is None


def test_a_forked_process_is_told_to_spawn() -> None:
    run = python(
        "import os, warnings\n"
        "warnings.simplefilter('ignore')\n"  # Python says from 3.12 on that it may not go well
        "from facetlog.errors import EngineError\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "base = KnowledgeBase(isolated=True)\n"
        "if os.fork() == 0:\n"
        "    try:\n"
        "        base.query('X = 1')\n"
        "    except EngineError as exc:\n"
        "        os.write(1, str(exc).encode())\n"
        "    os._exit(0)\n"
        "os.wait()\n"
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert "spawn" in run.stdout
