"""What the benchmarks of the knowledge base share: facts, times, processes of their own.

Native Prolog is the yardstick: the program `swipl`, and the same library inside Python.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from itertools import permutations
from pathlib import Path

import numpy as np

import facetlog
from benchmarks.common import Row, median_and_spread
from facetlog.kb.loading.encode import Fact

__all__ = [
    "SQUARE_DEGREES",
    "angle_facts",
    "cpu_ms",
    "exponent",
    "python_says",
    "random_planes",
    "rows_against",
    "swipl_says",
]

SQUARE_DEGREES = 15  # the box rule's tolerance
ANGLE_SD = 0.5  # degrees, as a plane from some ten vertices has it
PROCESS_SECONDS = 3600

# What runs in a Python of its own times with this.
TIMING = """
import json, time
def cpu_ms(work, repeats):
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(1e3 * (time.process_time() - start))
    return times
"""

# And what runs in Prolog: the goal once uncounted, then Repeats times.
PROLOG_TIMING = """
times(Repeats, Goal, Times) :-
    ignore(Goal),
    findall(Time,
            ( between(1, Repeats, _),
              garbage_collect,
              statistics(process_cputime, Start),
              ignore(Goal),
              statistics(process_cputime, End),
              Time is 1000*(End - Start) ),
            Times).
"""


def cpu_ms(
    work: Callable[[], object], repeats: int, *, before: Callable[[], object] | None = None
) -> list[float]:
    """CPU milliseconds of this process for each repeat; one more goes before them, uncounted.

    `before` is done before each repeat and not counted.
    """
    times = []
    for _ in range(repeats + 1):
        if before is not None:
            before()
        start = time.process_time()
        work()
        times.append(1e3 * (time.process_time() - start))
    return times[1:]


def rows_against(
    native: Sequence[float], measured: Sequence[tuple[str, Sequence[float]]]
) -> tuple[Row, ...]:
    """A row for each way of work, with the ratio of its median to that of the native one."""
    yardstick = float(np.median(native))
    return tuple(
        {
            "what": what,
            **{f"ms {key}": value for key, value in median_and_spread(times, digits=1).items()},
            "÷ native": round(float(np.median(times)) / yardstick, 2) if len(times) else None,
        }
        for what, times in measured
    )


def exponent(sizes: Sequence[float], costs: Sequence[float]) -> float:
    """k of cost ~ size^k, by least squares on the logarithms.

    >>> round(exponent([1, 10, 100], [2, 200, 20000]), 6)
    2.0
    """
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def swipl_says(program: str) -> object:
    """What `main` of the Prolog program prints as JSON, run by `swipl` in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.pl"
        path.write_text(PROLOG_TIMING + program, encoding="utf-8")
        command = ["swipl", "-q", "-g", "main", "-t", "halt", str(path)]
        return _said(command, os.environ.copy())


def python_says(code: str) -> object:
    """What the code, which may call cpu_ms, prints as JSON, run by a fresh Python."""
    source = str(Path(facetlog.__file__).parents[1])
    top = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join((source, top))
    return _said([sys.executable, "-c", TIMING + code], {**os.environ, "PYTHONPATH": path})


def _said(command: Sequence[str], environment: dict[str, str]) -> object:
    run = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=PROCESS_SECONDS,
        check=False,
        env=environment,
    )
    if run.returncode or not run.stdout.strip():
        raise RuntimeError(f"{command[0]} failed: {run.stderr.strip()[-2000:]}")
    said: object = json.loads(run.stdout.splitlines()[-1])
    return said


def angle_facts(count: int, seed: int = 0) -> list[Fact]:
    """So many facts of two names and two numbers, of 300 faces and as many others as it takes."""
    degrees = np.random.default_rng(seed).uniform(0, 180, count).tolist()
    return [("angle", f"f{i % 300}", f"f{i // 300}", x, ANGLE_SD) for i, x in enumerate(degrees)]


def random_planes(count: int, seed: int = 0) -> list[Fact]:
    """Measured faces of one thing in random directions, with the angles of all ordered pairs.

    Angles are rounded to thousandths of a degree, which clingo's whole numbers can tell.
    """
    normals = np.random.default_rng(seed).normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    degrees = np.degrees(np.arccos(np.clip(normals @ normals.T, -1, 1))).round(3)
    names = [f"f{i}" for i in range(count)]
    facts: list[Fact] = [("thing", "t1")]
    for name in names:
        facts += [("face", name), ("part_of", name, "t1"), ("evidence", name, "measured")]
    for i, j in permutations(range(count), 2):
        facts.append(("angle", names[i], names[j], float(degrees[i, j]), ANGLE_SD))
    return facts
