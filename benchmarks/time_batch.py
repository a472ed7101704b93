"""What does a scene of a batch cost, from facts to the verdicts of all models?

Scenes of 12 to 60 faces, furniture of the builders in random sizes, through one BatchJudge, and
the same facts read from a file of Prolog clauses and judged by the same code in a native `swipl`
process, in the same run. CPU time; resident memory is read after every tenth of a longer run and
fitted by a line. The number of seeds asked for is that of the scenes.
"""

import tempfile
import time
from pathlib import Path
from typing import cast

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, command
from benchmarks.knowledge_base import python_says, rows_against, swipl_says
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.encode import Fact, fact_text
from facetlog.kb.engine import house
from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.kb.schema import declarations
from facetlog.perception.builders import BUILDERS, build
from facetlog.perception.facts import scene_facts

__all__ = ["NAME", "main", "measure", "scenes"]

NAME = "time_batch"
SCENES = 48
REPEATS = 3  # of each scene; the least time counts, the others were disturbed
LONG_RUN = 20  # times all scenes, for the memory
TENTHS = 10
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
              facetlog_loader:name_models(native, [Name], Name) ),
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
    facetlog_batch:brief_verdicts(native, Verdicts),
    facetlog_batch:empty_batch(native),
    Verdicts \\== [].
"""

MEMORY = """
import os
from benchmarks.time_batch import scenes
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


def scenes(count: int, first: int = 0) -> list[list[Fact]]:
    """So many scenes, each of a builder in its turn, in sizes that follow from the seed."""
    found: list[list[Fact]] = []
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
        if LEAST_FACES <= len(scene.faces) <= MOST_FACES:
            found.append([(f.functor, *f.args) for f in scene_facts(scene)])
    return found


def _timed(judge: BatchJudge, facts: list[Fact]) -> float:
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        judge.judge(facts)
        times.append(1e3 * (time.process_time() - start))
    return min(times)


def _native(found: list[list[Fact]], judge: BatchJudge) -> list[float]:
    with tempfile.TemporaryDirectory() as folder:
        for number, facts in enumerate(found, 1):
            asked = [fact for fact in facts if (fact[0], len(fact) - 1) in judge.asked]
            text = "\n".join(map(fact_text, asked)) + "\n"
            (Path(folder) / f"{number}.pl").write_text(text, encoding="utf-8")
        program = NATIVE.format(
            bridge=house("kb") / "prolog" / "bridge.pl",
            rules=house("rules"),
            declarations=declarations().replace("\\", "\\\\").replace('"', '\\"'),
            models=f"[{','.join(BUILTIN_MODELS)}]",
            count=len(found),
            repeats=REPEATS,
            folder=folder,
        )
        return cast(list[float], swipl_says(program))


def measure(settings: Settings) -> Report:
    """Times of all scenes, the native peer's, and memory."""
    count = settings.number(SCENES)
    found = scenes(count, settings.first)
    with BatchJudge() as judge:
        for facts in found:
            judge.judge(facts)  # uncounted
        ours = [_timed(judge, facts) for facts in found]
        native = _native(found, judge)
    rows = rows_against(native, (("swipl: read, judge", native), ("BatchJudge", ours)))
    code = MEMORY.format(
        count=count, first=settings.first, tenths=TENTHS, rounds=max(1, LONG_RUN // TENTHS)
    )
    sizes = cast(list[float], python_says(code))
    judged = count * max(1, LONG_RUN // TENTHS)
    slope = float(np.polyfit(np.arange(1, TENTHS + 1) * judged, sizes, 1)[0])
    memory: Row = {
        "scenes": judged * TENTHS,
        "MB after a tenth": round(sizes[0], 1),
        "MB at the end": round(sizes[-1], 1),
        "MB for 100,000 scenes": round(1e5 * slope, 1),
    }
    rates: Row = {
        "scenes a second and core": round(1e3 / float(np.mean(ours)), 1),
        "native": round(1e3 / float(np.mean(native)), 1),
    }
    return Report(
        NAME,
        (
            Table("A scene", rows),
            Table("Rates", (rates,)),
            Table("Resident memory", (memory,)),
        ),
        {"scenes": count, "repeats": REPEATS},
        ("Wanted: at most 2 times native; 500 scenes a second on two cores; flat memory.",),
    )


main = command(NAME, __doc__, measure)

if __name__ == "__main__":
    main(None)
