"""What does a scene of a batch cost, from its JSON to the verdicts of all models?

Scenes of 12 to 60 faces, furniture of the builders in random sizes, are read, made into the facts
that the models ask for, and judged by one BatchJudge. CPU time.
One and two workers of `facetlog classify` are compared by wall clock and by CPU time, less what
they take to start. The number of seeds is that of the scenes.
"""

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, compute_median_and_spread
from facetlog.kb.batch_judge import BatchJudge
from facetlog.perception.facts.all_facts import fact_columns
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build
from facetlog.perception.surfaces.scene_file import read_scene, write_scene
from facetlog.perception.types import FloatArray

NAME = "time_batch"
SCENES = 48
REPEATS = 3  # of each scene; the least time counts, the others were disturbed
COPIES = 8  # of each scene, for the workers
LEAST_FACES, MOST_FACES = 12, 60
SPREAD = 0.7, 1.4  # of sizes, times what is usual


def built(
    count: int, first: int = 0, *, least: int = LEAST_FACES, most: int = MOST_FACES
) -> list[Scene]:
    """Return so many scenes of `least` to `most` faces, each of a builder in its turn, in sizes
    that follow from the seed.
    """
    found: list[Scene] = []
    names = sorted(BUILDERS)
    seed = first
    while len(found) < count:
        generator = np.random.default_rng(seed)
        builder = BUILDERS[names[seed % len(names)]]
        seed += 1
        sizes = {
            size.name: round(value) if size.kind == "count" else value
            for size in builder.parameters
            for value in [size.default * generator.uniform(*SPREAD)]
        }
        try:
            scene = build(builder.name, sizes)
        except ValueError:
            continue  # no such thing can be
        if least <= len(scene.faces) <= most:
            found.append(scene)
    return found


def _timed(judge: BatchJudge, paths: Sequence[Path]) -> list[tuple[float, float, float]]:
    """Return milliseconds to read each scene, to make facts of it, and to judge them."""
    kinds = {name for name, _ in judge.needed}
    times = np.full((REPEATS, len(paths), 3), np.inf)
    for repeat in times:
        for path, steps in zip(paths, repeat, strict=True):
            start = time.process_time()
            scene = read_scene(path)
            read = time.process_time()
            facts = fact_columns(scene, kinds)
            made = time.process_time()
            judge.judge_columns(facts)
            steps[:] = read - start, made - read, time.process_time() - made
    return [(read, facts, judged) for read, facts, judged in (1e3 * times.min(axis=0)).tolist()]


def _classified(paths: Sequence[Path], workers: int) -> FloatArray:
    """Return seconds by the clock, and of CPU time, that classify takes for these files (2,)."""
    start = np.array([time.perf_counter(), _children()])
    output = paths[0].parent / f"{workers}-{len(paths)}.jsonl"
    options = ("--workers", str(workers), "-o", str(output), "--overwrite")
    with tempfile.TemporaryDirectory() as kept:  # no facts of the run before
        subprocess.run(
            [
                sys.executable,
                "-m",
                "facetlog",
                "classify",
                *map(str, paths),
                *options,
                "--keep",
                kept,
            ],
            check=True,
            capture_output=True,
        )
    return np.array([time.perf_counter(), _children()]) - start


def _children() -> float:
    """Return CPU time, s, of processes that were started from here and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _workers(folder: Path, found: Sequence[Scene]) -> tuple[Row, ...]:
    paths = []
    for number, scene in enumerate(tuple(found) * COPIES):
        paths.append(folder / f"copy{number}.json")
        write_scene(scene, paths[-1])
    starts, rates, costs = [], [], []
    for workers in (1, 2):
        few = np.min([_classified(paths[:workers], workers) for _ in range(REPEATS)], axis=0)
        many = np.min([_classified(paths, workers) for _ in range(REPEATS)], axis=0)
        clock, processor = many - few
        starts.append(few[1])
        rates.append((len(paths) - workers) / clock)
        costs.append(1e3 * processor / (len(paths) - workers))
    return tuple(
        {
            "workers": workers,
            "start, CPU s": round(float(start), 2),
            "CPU ms a scene": round(float(cost), 1),
            "scenes a second": round(float(rate), 1),
            "times one": round(float(rate / rates[0]), 2),
        }
        for workers, start, rate, cost in zip((1, 2), starts, rates, costs, strict=True)
    )


def measure(settings: Settings) -> Report:
    """Measure each step of a scene, and workers."""
    count = settings.number(SCENES)
    found = built(count, settings.first)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        paths = [folder / f"{number}.json" for number in range(count)]
        for scene, path in zip(found, paths, strict=True):
            write_scene(scene, path)
        with BatchJudge() as judge:
            _timed(judge, paths)  # not counted: the first run fills caches
            steps = _timed(judge, paths)
        workers = _workers(folder, found)
    read, made, judged = zip(*steps, strict=True)
    every = [sum(step) for step in steps]
    parts = {"JSON to verdicts": every, "read": read, "facts": made, "judge": judged}
    return Report(
        NAME,
        (
            Table(
                "A scene, CPU ms",
                tuple(
                    {"what": k, **compute_median_and_spread(v, digits=1)} for k, v in parts.items()
                ),
            ),
            Table("Rates", ({"scenes a second and core": round(1e3 / float(np.mean(every)), 1)},)),
            Table("Workers of classify", workers),
        ),
        {"scenes": count, "repeats": REPEATS},
        ("Wanted: 500 scenes a second on two cores.",),
    )
