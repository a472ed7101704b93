"""What does a scene of a batch cost, from its JSON to the verdicts of all models?

Scenes of 12 to 60 faces, furniture of the builders in random sizes, are read, made into the facts
that the models ask for, a dozen together as in a worker, and judged by one BatchJudge; the same
facts are read from a file of Prolog clauses and judged by the same code in a native `swipl`
process, in the same run. CPU time. One and two workers of `facetlog classify` are compared by the
clock and by CPU time, less what they take to start: where other programs keep the machine busy, the
second worker gains little by the clock, and CPU time tells what the workers cost each other. A
single scene tells what a start costs.
Resident memory is read after every tenth of a longer run; its growth is that of the second half,
when all that is made once has been made. The number of seeds asked for is that of the scenes.
"""

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.knowledge.knowledge_base import python_says, rows_against, swipl_says
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.engine.engine import house
from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.kb.loading.builtin_rules import builtin_rules
from facetlog.kb.loading.encode import Fact, declarations, fact_text
from facetlog.perception.facts.all_facts import fact_columns, scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build
from facetlog.perception.surfaces.scene_file import read_scene, write_scene
from facetlog.perception.types import FloatArray

__all__ = ["NAME", "built", "measure", "scenes"]

NAME = "time_batch"
SCENES = 48
REPEATS = 3  # of each scene; the least time counts, the others were disturbed
TOGETHER = 12  # scenes whose facts are made together
LONG_RUN = 20  # times all scenes, for the memory
TENTHS = 10
COPIES = 8  # of each scene, for the workers
LEAST_FACES, MOST_FACES = 12, 60
SPREAD = 0.7, 1.4  # of sizes, times what is usual

NATIVE = """
:- ['{bridge}'].
main :-
    term_string(Declarations, "{declarations}"),
    schema:declare_facts(Declarations),
    findall(Name-[Name],
            ( member(Name, {models}),
              atomic_list_concat(['{rules}/', Name, '.pl'], Path),
              facetlog_loader:load_builtin(Path, _),
              facetlog_named_models:name_models(native, [Name], Name) ),
            Models),
    facetlog_bridge:ask_base(native, all),
    facetlog_batch:open_batch(native, native_scene, Models, _),
    findall(Least,
            ( between(1, {count}, Number),
              format(atom(File), '{folder}/~d.pl', [Number]),
              times({repeats}, judged(File), Times),
              min_list(Times, Least) ),
            All),
    format("~w~n", [All]).

judged(File) :-
    setup_call_cleanup(open(File, read, Stream, [encoding(utf8)]),
                       facetlog_scene:add_facts(native_scene, Stream),
                       close(Stream)),
    facetlog_batch:brief_verdicts(native, 100_000_000, Verdicts),
    facetlog_batch:empty_batch(native),
    Verdicts \\== [].
"""

MEMORY = """
import os
from benchmarks.knowledge.time_batch import scenes
from facetlog.kb.batch_judge import BatchJudge
def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
found = scenes({count}, {first})
sizes = []
with BatchJudge() as judge:
    for tenth in range({tenths}):
        for _ in range({rounds}):
            for facts in found:
                judge.judge(facts)
        sizes.append(resident())
print(json.dumps(sizes))
"""


def built(
    count: int, first: int = 0, *, least: int = LEAST_FACES, most: int = MOST_FACES
) -> list[Scene]:
    """So many scenes of `least` to `most` faces, each of a builder in its turn, in sizes that
    follow from the seed.
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


def scenes(count: int, first: int = 0) -> list[list[Fact]]:
    """The facts of so many scenes."""
    return [[f.row for f in scene_facts(scene)] for scene in built(count, first)]


def _timed(judge: BatchJudge, paths: Sequence[Path]) -> list[tuple[float, float, float]]:
    """Milliseconds to read each scene, to make facts of it, and to judge them.

    Facts are made of all together: of that each has the same share.
    """
    kinds = {name for name, _ in judge.needed}
    times = np.full((REPEATS, len(paths), 3), np.inf)
    for repeat in times:
        scenes = []
        for path, steps in zip(paths, repeat, strict=True):
            start = time.process_time()
            scenes.append(read_scene(path))
            steps[0] = time.process_time() - start
        start = time.process_time()
        found = fact_columns(scenes, kinds)
        repeat[:, 1] = (time.process_time() - start) / len(paths)
        for facts, steps in zip(found, repeat, strict=True):
            start = time.process_time()
            judge.judge_columns(facts)
            steps[2] = time.process_time() - start
    return [(read, facts, judged) for read, facts, judged in (1e3 * times.min(axis=0)).tolist()]


def _classified(paths: Sequence[Path], workers: int) -> FloatArray:
    """Seconds by the clock, and of CPU time, that classify takes for these files (2,)."""
    start = np.array([time.perf_counter(), _children()])
    output = paths[0].parent / f"{workers}-{len(paths)}.jsonl"
    options = ("--workers", str(workers), "-o", str(output), "--overwrite")
    subprocess.run(
        [sys.executable, "-m", "facetlog", "classify", *map(str, paths), *options],
        check=True,
        capture_output=True,
    )
    return np.array([time.perf_counter(), _children()]) - start


def _children() -> float:
    """CPU time, s, of processes that were started from here and have ended."""
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


def _native(found: list[list[Fact]], judge: BatchJudge) -> list[float]:
    with tempfile.TemporaryDirectory() as folder:
        for number, facts in enumerate(found, 1):
            asked = [fact for fact in facts if (fact[0], len(fact) - 1) in judge.needed]
            text = "\n".join(map(fact_text, asked)) + "\n"
            (Path(folder) / f"{number}.pl").write_text(text, encoding="utf-8")
        program = NATIVE.format(
            bridge=house("kb") / "prolog" / "bridge.pl",
            rules=builtin_rules(),
            declarations=declarations().replace("\\", "\\\\").replace('"', '\\"'),
            models=f"[{','.join(BUILTIN_MODELS)}]",
            count=len(found),
            repeats=REPEATS,
            folder=folder,
        )
        return cast(list[float], swipl_says(program))


def measure(settings: Settings) -> Report:
    """Times of all scenes, the native peer's, workers and memory."""
    count = settings.number(SCENES)
    found = built(count, settings.first)
    facts = scenes(count, settings.first)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number, scene in enumerate(found):
            write_scene(scene, folder / f"{number}.json")
        with BatchJudge() as judge:
            for some in facts:
                judge.judge(some)  # uncounted
            paths = [folder / f"{number}.json" for number in range(count)]
            steps = [
                timed
                for first in range(0, count, TOGETHER)
                for timed in _timed(judge, paths[first : first + TOGETHER])
            ]
            native = _native(facts, judge)
        workers = _workers(folder, found)
    read, made, judged = (list(step) for step in zip(*steps, strict=True))
    every = [sum(step) for step in steps]
    peers = (
        ("swipl: read facts, judge", native),
        ("JSON to verdicts", every),
        ("of that: read", read),
        ("of that: facts", made),
        ("of that: judge", judged),
    )
    code = MEMORY.format(
        count=count, first=settings.first, tenths=TENTHS, rounds=max(1, LONG_RUN // TENTHS)
    )
    sizes = cast(list[float], python_says(code))
    a_tenth = count * max(1, LONG_RUN // TENTHS)
    half = TENTHS // 2
    slope = float(np.polyfit(np.arange(half) * a_tenth, sizes[-half:], 1)[0])
    memory: Row = {
        "scenes": a_tenth * TENTHS,
        "MB after a tenth": round(sizes[0], 1),
        "MB after half": round(sizes[-half], 1),
        "MB at the end": round(sizes[-1], 1),
        "MB more in 1,000 scenes": round(1e3 * slope, 2),
    }
    rates: Row = {
        "scenes a second and core": round(1e3 / float(np.mean(every)), 1),
        "native": round(1e3 / float(np.mean(native)), 1),
    }
    return Report(
        NAME,
        (
            Table("A scene", rows_against(native, peers)),
            Table("Rates", (rates,)),
            Table("Workers of classify", workers),
            Table("Resident memory", (memory,)),
        ),
        {"scenes": count, "repeats": REPEATS},
        ("Wanted: at most 2 times native; 500 scenes a second on two cores; flat memory.",),
    )
