"""Questions that nest, interleave, stop and are dropped, on one thread and on many."""

import gc
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import EngineError
from facetlog.kb.engine.engine_pool import MOST_OPEN
from facetlog.kb.engine.terms import Atom
from facetlog.kb.knowledge_base import BUILTIN_MODELS, KnowledgeBase
from facetlog.kb.limits import Limits
from tests.kb.fresh import ENVIRONMENT, python
from tests.patience import GRACE, allowed

ENDLESS = "between(1, inf, X), X < 0"
STUCK = "sleeps"  # a single step outside Prolog, which heeds no signal
UNLIMITED = Limits(seconds=60.0, inferences=10**15)


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        base.load_scene("s", [("face", "f1"), ("face", "f2")])
        released = threading.Event()
        base.define(STUCK, 0, lambda: released.wait(4 * GRACE))
        yield base
        released.set()


def usable(base: KnowledgeBase) -> bool:
    return list(base.query("face(F)")) == [(Atom("f1"),), (Atom("f2"),)]


def test_a_question_may_be_asked_in_the_loop_of_another(base: KnowledgeBase) -> None:
    found = [
        (a, b)
        for (a,) in base.query("between(1, 3, X)")
        for (b,) in base.query("between(1, A, Y)", bindings={"A": a})
    ]
    # What is given is no answer, so the rows have one value.
    assert found == [(1, 1), (2, 1), (2, 2), (3, 1), (3, 2), (3, 3)]


def test_answers_that_nobody_reads_on_are_let_go(base: KnowledgeBase) -> None:
    for _ in range(3 * MOST_OPEN):
        assert next(base.query("between(1, inf, X)")) == (1,)
    gc.collect()
    assert usable(base)


def test_too_many_open_questions_are_refused_and_all_others_go_on(base: KnowledgeBase) -> None:
    opened = [base.query("between(1, inf, X)") for _ in range(MOST_OPEN)]
    with pytest.raises(EngineError, match="open at once"):
        base.query("between(1, inf, X)")
    assert {next(answers) for answers in opened} == {(1,)}
    for answers in opened:
        answers.close()
    time.sleep(0.2)
    assert usable(base)


def test_many_threads_ask_at_once(base: KnowledgeBase) -> None:
    sums: queue.SimpleQueue[int] = queue.SimpleQueue()

    def ask(start: int) -> None:
        for _ in range(20):
            rows = base.query("between(A, B, X)", bindings={"A": start, "B": start + 2500})
            sums.put(sum(x for (x,) in rows if isinstance(x, int)) - 2501 * start)

    threads = [threading.Thread(target=ask, args=(1000 * i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {sums.get() for _ in range(160)} == {2500 * 2501 // 2}


def test_one_thread_may_close_what_another_is_waiting_for(base: KnowledgeBase) -> None:
    # The first chunk comes at once, the second never.
    many = "(between(1, 64, X) ; between(1, inf, X), X < 0)"
    answers = base.query(many, limits=UNLIMITED)
    threading.Timer(0.3, answers.close).start()
    begin = time.monotonic()
    rest: list[object] = []
    with pytest.raises(EngineError, match="stopped"):
        rest += answers
    assert time.monotonic() - begin < allowed(0.3)
    assert usable(base)


def test_time_is_limited(base: KnowledgeBase) -> None:
    begin = time.monotonic()
    with pytest.raises(EngineError, match="time limit"):
        list(base.query(ENDLESS, limits=Limits(seconds=0.3, inferences=10**15)))
    assert 0.3 <= time.monotonic() - begin < allowed(0.3)
    assert usable(base)


def test_the_thread_of_an_interrupted_question_serves_no_other(base: KnowledgeBase) -> None:
    # Prolog may have kept what the interrupted question had left of its inferences.
    served: list[threading.Thread] = []

    def noted() -> bool:
        served.append(threading.current_thread())
        return True

    base.define("noted", 0, noted)
    with pytest.raises(EngineError, match="time limit"):
        list(base.query(f"noted, {ENDLESS}", limits=Limits(seconds=0.2, inferences=10**15)))
    for _ in range(6):
        assert list(base.query("noted"))
    assert served[0] not in served[1:]
    assert len(served) == 7


def test_only_prologs_own_time_counts(base: KnowledgeBase) -> None:
    answers = base.query("between(1, 3000, X)", limits=Limits(seconds=0.3))
    assert next(answers) == (1,)
    time.sleep(0.5)
    assert len(list(answers)) == 2999


def test_a_step_that_cannot_be_interrupted_holds_nobody_up(base: KnowledgeBase) -> None:
    begin = time.monotonic()
    with pytest.raises(EngineError, match="time limit"):
        list(base.query(STUCK, limits=Limits(seconds=0.2)))
    assert time.monotonic() - begin < allowed(0.2)
    assert usable(base)


def test_inferences_are_limited(base: KnowledgeBase) -> None:
    with pytest.raises(EngineError, match="limit of inferences"):
        list(base.query(ENDLESS, limits=Limits(seconds=60.0, inferences=100_000)))
    assert usable(base)


def test_memory_is_limited(base: KnowledgeBase) -> None:
    with pytest.raises(EngineError, match="limit of memory"):
        list(base.query("length(L, N), N < 0", limits=Limits(stack_mb=8)))
    assert usable(base)


@pytest.mark.parametrize("question", [ENDLESS, STUCK])
def test_ctrl_c_is_heeded(base: KnowledgeBase, question: str) -> None:
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        list(base.query(question, limits=UNLIMITED))
    assert time.monotonic() - begin < allowed(0.3)
    assert usable(base)


@pytest.mark.parametrize(
    "doing",
    [
        "next(base.query('between(1, inf, X)'))",
        "kept = [base.query('between(1, inf, X)') for _ in range(20)]; [next(k) for k in kept]",
        "threading.Thread(target=asking, daemon=True).start()",
        "base.load_scene('other', [('face', 'f2')])",
        "base.close(); base.close()",
    ],
)
@pytest.mark.slow
def test_the_interpreter_ends_cleanly(doing: str) -> None:
    run = python(
        "import threading, time\n"
        "from facetlog.errors import EngineError\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "base = KnowledgeBase()\n"
        "base.load_scene('s', [('face', 'f1')])\n"
        "def asking():\n"
        "    try:\n"
        "        list(base.query('between(1, inf, X), X < 0'))\n"
        "    except EngineError:\n"
        "        pass\n"
        f"{doing}\n"
        "time.sleep(0.1)\n"
        "print('done')\n"
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "done\n", "")


def test_a_forked_process_is_told_to_spawn() -> None:
    run = python(
        "import os, warnings\n"
        "warnings.simplefilter('ignore')\n"  # Python says from 3.12 on that it may not go well
        "from facetlog.errors import EngineError\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "base = KnowledgeBase()\n"
        "if os.fork() == 0:\n"
        "    try:\n"
        "        KnowledgeBase()\n"
        "    except EngineError as exc:\n"
        "        os.write(1, str(exc).encode())\n"
        "    os._exit(0)\n"
        "os.wait()\n"
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert "spawn" in run.stdout


def test_a_signal_that_ends_the_process_ends_it_at_once() -> None:
    code = (
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "base = KnowledgeBase()\n"
        "base.load_scene('s', [])\n"
        "print('asking', flush=True)\n"
        f"list(base.query({ENDLESS!r}))\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=ENVIRONMENT,
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"asking\n"
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=2) == -signal.SIGTERM


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ("SwiPrologNotFoundError('SWI-Prolog not found')", "apt install swi-prolog-nox"),
        ("Exception('swi-prolog >= 8.2.0 is required')", "is too old"),
        ("ImportError('no pyswip')", "pip install"),
        ("OSError('libgmp.so.10: cannot open shared object file')", "libgmp.so.10"),
        ("MemoryError()", "memory"),
        ("RuntimeError('other')", "RuntimeError: other"),
    ],
)
def test_what_keeps_prolog_from_starting_is_one_line_that_says_what_it_is(
    fault: str, says: str
) -> None:
    run = python(
        "class SwiPrologNotFoundError(Exception): pass\n"
        "def failing():\n"
        f"    raise {fault}\n"
        "from facetlog.kb.engine import engine\n"
        "engine._pyswip_core = failing\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "from facetlog.errors import EngineError\n"
        "try:\n"
        "    KnowledgeBase()\n"
        "except EngineError as exc:\n"
        "    print(exc, exc.exit_code)\n"
    )
    assert says in run.stdout, run.stderr
    assert ("SWI-Prolog is missing" in run.stdout) == fault.startswith("SwiPrologNotFound")
    assert run.stdout.endswith(" 3\n")
    assert run.stdout.count("\n") == 1


OPENED = """
from facetlog.kb.knowledge_base import KnowledgeBase
with KnowledgeBase() as base:
    print(len(base.models), ascii(list(base.query("X = '\\xe4'"))))
"""


@pytest.mark.parametrize(
    ("before", "environment"),
    [
        ("", {"LC_ALL": "C"}),
        ("", {"LC_ALL": "C", "PYTHONUTF8": "0"}),
        ("", {"LC_CTYPE": "POSIX", "LANG": "C"}),
        ("", {"SWI_HOME_DIR": os.sep}),  # where there is none SWI-Prolog ends the process
        ("import sys; sys.argv.append('a\\udcff.json')\n", {}),
        ("import os; os.mkdir('gone'); os.chdir('gone'); os.rmdir('../gone')\n", {}),
    ],
)
@pytest.mark.slow
def test_prolog_starts_and_reads_its_files_whatever_its_surroundings(
    before: str, environment: dict[str, str], tmp_path: Path
) -> None:
    run = subprocess.run(
        [sys.executable, "-c", before + OPENED],
        env={**ENVIRONMENT, **environment},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout == f"{len(BUILTIN_MODELS)} [(Atom(name='\\xe4'),)]\n"
    assert "Illegal multibyte" not in run.stderr


@pytest.mark.parametrize("seconds", [0.02, 0.1, 0.2])
def test_a_process_that_is_interrupted_at_the_start_ends_without_a_word(seconds: float) -> None:
    run = python(
        "import os, signal, threading\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        f"threading.Timer({seconds}, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "    KnowledgeBase()\n"
        "    threading.Event().wait(1.0)\n"
        "except KeyboardInterrupt:\n"
        "    pass\n"
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_a_process_that_ends_while_prolog_starts_ends_without_a_word() -> None:
    """On the main thread, when SWI-Prolog runs on another and loads its files."""
    run = python(
        "import sys, threading\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "threading.Thread(target=KnowledgeBase, daemon=True).start()\n"
        "while not hasattr(sys.modules.get('pyswip.core'), 'cleanupProlog'): pass\n"
        "running = sys.modules['pyswip.core'].PL_is_initialised\n"
        "while not running(None, None): pass\n"
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_a_process_ends_without_a_word_while_an_interrupted_question_lasts() -> None:
    run = python(
        "import time\n"
        "from facetlog.kb.engine import engine\n"
        "detach = engine.Engine.detach\n"
        "engine.Engine.detach = lambda self: (time.sleep(30.0), detach(self))\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "engine.Engine.stop = lambda self: print('stopped')\n"
        "answers = KnowledgeBase().query('between(1, inf, X)')\n"
        "next(answers)\n"
        "answers.close()\n"
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_collecting_a_base_waits_for_nothing(base: KnowledgeBase) -> None:
    threshold = gc.get_threshold()
    gc.set_threshold(1)
    try:
        for _ in range(5):
            other = KnowledgeBase()
            other.load_scene("s", [("face", "f1")])
            other.__dict__["cycle"] = other
            del other
            assert usable(base)
    finally:
        gc.set_threshold(*threshold)
