"""Does a wrong meaning of a test stay unseen? Changes the clauses that judge, one place at a time,
and lets the oracle and the unit tests of tests/kb/meaning look at each change.

    python scripts/mutants.py [--only FILE …] [--sample N --seed SEED] [--processes N]

A mutant is killed when a way of judging says something else than the reference, or an error, or
nothing in the time of many cases, or a unit test fails; how many died of the time is printed. What
carries facts and verdicts to and fro means nothing, and is left to tests/kb/test_batch_judge.py.
The survivors are printed with their lines; the exit status is 1 if there are any that `EQUIVALENT`
does not name, or if one that it names is killed or does not exist.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from queue import Empty, SimpleQueue
from random import Random
from threading import Thread
from typing import IO, Any, cast

from equivalent_mutants import EQUIVALENT

from facetlog.kb.engine.engine import house

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests are no installed package
from tests.kb.meaning.cases import Case, random_case
from tests.kb.meaning.judging import HERE, close, differences, program, written

ROOT = house("kb") / "prolog"
# What tests mean, then the rules by which models are specialised.
FILES = (
    *(f"meaning/{name}.pl" for name in (
        "degrees", "say", "compare", "fading", "quantities", "model_test", "left_open", "static",
        "variables",
    )),
    *(f"batch/{name}.pl" for name in (
        "partial", "branches", "loops", "arithmetic", "first_answer", "body_code", "joins",
        "sources", "specialise", "target",
    )),
)  # fmt: skip
CASES = 60  # that each mutant is tried on
TESTS = 12  # of a case
UNITS = -1  # in the place of a case: the unit tests
SECONDS = 10.0  # for a case or the unit tests: a mutant that never ends is seen, too


@dataclass(frozen=True)
class Mutant:
    """One change of one place of a file."""

    file: str
    line: int
    start: int
    end: int
    new: str
    predicate: str

    def text(self) -> str:
        """Return the file with the change."""
        before = _text(self.file)
        return before[: self.start] + self.new + before[self.end :]

    def key(self) -> tuple[str, str, str]:
        """Return what EQUIVALENT names it by."""
        before, old, after = (
            _text(self.file)[start:end]
            for start, end in ((0, self.start), (self.start, self.end), (self.end, None))
        )
        first, last = before.rpartition("\n")[2].lstrip(), after.partition("\n")[0]
        return self.file, f"{first}‹{' '.join(old.split())}›{last}", " ".join(self.new.split())

    def __str__(self) -> str:
        _, place, new = self.key()
        return f"{self.file}:{self.line}: {place}  →  {new or '(left out)'}"


@cache
def _text(file: str) -> str:
    return (ROOT / file).read_text(encoding="utf-8")


class Program:
    """SWI-Prolog with the program, its unit tests and mutants.pl, which forks for each mutant."""

    def __init__(self, seconds: float = SECONDS) -> None:
        files = [*map(str, sorted(HERE.glob("*.plt"))), str(Path(__file__).with_suffix(".pl"))]
        goal = f"{program()},load_files({files}, [silent(true)]),serve_mutants"
        process = subprocess.Popen(
            ["swipl", "-q", "-g", goal, "-t", "halt"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # what a mutant says of itself
            text=True,
            start_new_session=True,
        )
        self._process = process.pid
        self._questions = cast(IO[str], process.stdin)
        self._answers: SimpleQueue[str] = SimpleQueue()
        self._mutant: int | None = None
        self.seconds = seconds
        Thread(target=self._read, args=(process.stdout,), daemon=True).start()

    def _read(self, answers: IO[str]) -> None:
        for line in answers:
            self._answers.put(line)

    def ask(self, question: str) -> Any:
        """Return the answer. Raise Empty if it takes too long or the mutant died, ValueError if it
        cannot be read.
        """
        self._questions.write(question)
        self._questions.flush()
        end = time.monotonic() + self.seconds
        while True:
            try:
                return json.loads(self._answers.get(timeout=1))
            except Empty:
                if time.monotonic() > end or not self._alive():
                    raise

    def _alive(self) -> bool:
        if self._mutant is None:
            return True
        try:
            os.kill(self._mutant, 0)
        except ProcessLookupError:
            return False
        return True

    def become(self, mutant: Mutant | None) -> None:
        """Become the mutant; without one, the program as it is. Raise as `ask`."""
        file = mutant.file if mutant else FILES[0]
        text = mutant.text() if mutant else _text(file)
        self._mutant = self.ask(f"mutant({str(ROOT / file)!r}, {json.dumps(text)}).\n")

    def done(self) -> None:
        """End the mutant, whatever it is at."""
        if self._mutant is not None:
            with suppress(ProcessLookupError):
                os.kill(self._mutant, signal.SIGKILL)
            # Before that it might still read what is meant for the next.
            while not self._answers.get(timeout=self.seconds).rstrip().endswith('"ended"'):
                pass
        self._mutant = None

    def close(self) -> None:
        """End all processes."""
        os.killpg(self._process, signal.SIGKILL)


class Killers:
    """Cases and unit tests, those first that killed a mutant last."""

    def __init__(self, cases: int) -> None:
        self._cases = [random_case(seed, TESTS) for seed in range(cases)]
        self._said: list[Any] = []
        self._order = [UNITS, *range(cases)]
        self.late = 0
        """How many were killed because they said nothing in time."""

    def learn(self, program: Program) -> None:
        """Note what the program says as it is. Raise SystemExit if a test fails already."""
        program.become(None)
        for case in self._cases:
            self._said.append(program.ask(written(case)))
            if differences(case, self._said[-1]):
                raise SystemExit("the program itself differs from the reference: run the tests")
        if not program.ask("units.\n"):
            raise SystemExit("a unit test fails of the program itself")
        program.done()

    def kill(self, program: Program, mutant: Mutant) -> bool:
        """Return whether one of them does. Raise Empty or ValueError for what cannot be loaded."""
        program.become(mutant)
        try:
            for killer in tuple(self._order):
                if self._killed(program, killer):
                    self._order.remove(killer)
                    self._order.insert(0, killer)
                    return True
            return False
        finally:
            program.done()

    def _killed(self, program: Program, killer: int) -> bool:
        try:
            if killer == UNITS:
                return not program.ask("units.\n")
            case, before = self._cases[killer], self._said[killer]
            said = program.ask(written(case))
            return not close(said, before) and _differs(case, said)
        except Empty:
            self.late += 1
            return True
        except ValueError:
            return True


def _differs(case: Case, said: Any) -> bool:
    try:
        return bool(differences(case, said))
    except (ValueError, TypeError, LookupError):
        return True  # it is no answer at all


def found_in(program: Program, file: str) -> list[Mutant]:
    """Return all single changes of the clauses of a file."""
    changes = program.ask(f"changes({str(ROOT / file)!r}).\n")
    return [
        Mutant(file, line, start, end, new, predicate)
        for line, start, end, new, predicate in sorted(changes, key=lambda one: one[:3])
    ]


def sample(mutants: Sequence[Mutant], count: int | None, seed: int) -> list[Mutant]:
    """So many of them in their order, each as likely as any other; all if there is no count."""
    if count is None or count >= len(mutants):
        return list(mutants)
    return [mutants[place] for place in sorted(Random(seed).sample(range(len(mutants)), count))]


class Worker:
    """A program of its own, with what killed its last mutants."""

    def __init__(self, cases: int, seconds: float) -> None:
        self._program = Program(seconds)
        self._killers = Killers(cases)
        self._killers.learn(self._program)

    @property
    def late(self) -> int:
        """How many mutants were killed because they said nothing in time, or died."""
        return self._killers.late

    def survivors(self, mutants: Sequence[Mutant]) -> list[Mutant]:
        """Those that nothing kills, printed as they are found."""
        left = []
        for mutant in mutants:
            if not self._kills(mutant):
                left.append(mutant)
                if mutant.key() not in EQUIVALENT:
                    print(f"survives: {mutant}", flush=True)
        return left

    def _kills(self, mutant: Mutant) -> bool:
        try:
            return self._killers.kill(self._program, mutant)
        except (Empty, ValueError):
            self._program.close()
            self._program = Program(self._program.seconds)
            return True

    def close(self) -> None:
        """End the program."""
        self._program.close()


def main() -> int:
    """Print the survivors of each file."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", action="append", help="a file, such as meaning/degrees.pl")
    parser.add_argument("--cases", type=int, default=CASES, help="that each mutant is tried on")
    parser.add_argument("--sample", type=int, help="so many mutants of each file, drawn at random")
    parser.add_argument("--seed", type=int, default=0, help="of the sample")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="for a case or the tests")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    count = options.processes
    finder = Program()
    right = True
    with ThreadPoolExecutor(count) as pool:
        workers = list(pool.map(Worker, [options.cases] * count, [options.seconds] * count))
        for file in options.only or FILES:
            every = found_in(finder, file)
            tried = sample(every, options.sample, options.seed)
            late = sum(worker.late for worker in workers)
            shares = [tried[first::count] for first in range(count)]
            left = [one for some in pool.map(Worker.survivors, workers, shares) for one in some]
            alive = {mutant.key() for mutant in left}
            wrong = {key for key in EQUIVALENT if key[0] == file} - alive
            wrong -= {mutant.key() for mutant in every} - {mutant.key() for mutant in tried}
            for key in sorted(wrong):
                print(f"named equivalent, but killed or not there: {key}")
            named = sum(mutant.key() in EQUIVALENT for mutant in left)
            late = sum(worker.late for worker in workers) - late
            print(
                f"{file}: {len(tried)} mutants, {len(left) - named} survive, {named} equivalent, "
                f"{late} killed by the time they took",
                flush=True,
            )
            right = right and not wrong and named == len(left)
    finder.close()
    for worker in workers:
        worker.close()
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())
