"""Does memory grow in a long run: a million small questions, ten thousand scenes come and go?

Each in a process of its own, which reads its resident memory after every tenth of the work. The
number of seeds asked for is per cent of the work: 100 is all of it. Wall time.
"""

from typing import cast

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.knowledge.knowledge_base import python_says

__all__ = ["NAME", "measure"]

NAME = "time_long_run"
QUESTIONS, LOADS = 1_000_000, 10_000
PER_CENT = 100
TENTHS = 10
BLOCKS = 2  # of six faces, some 700 facts: a small scene

SET_UP = f"""
import gc, os, time
from benchmarks.knowledge.block_scenes import block_scene
from facetlog.kb.knowledge_base import KnowledgeBase
def resident():
    gc.collect()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
def run(count, work):
    sizes, start = [], time.perf_counter()
    for done in range(1, count + 1):
        work(done)
        if done % max(1, count // {TENTHS}) == 0:
            sizes.append(resident())
    print(json.dumps([time.perf_counter() - start, *sizes]))
facts = block_scene({BLOCKS})
base = KnowledgeBase()
"""

QUESTION = """
base.load_scene("s", facts)
faces = [fact[1] for fact in facts if fact[0] == "face"]
def work(number):
    face = faces[number % len(faces)]
    answers = list(base.query(f"angle({face}, B, Degrees, _), Degrees > 45"))
    assert answers
"""

# Every other scene takes the place of the one before, the others are dropped.
LOAD = """
def work(number):
    base.load_scene("s", facts)
    assert len(list(base.query("face(F)"))) == sum(fact[0] == "face" for fact in facts)
    if number % 2:
        base.drop_scene("s")
"""


def _row(what: str, code: str, count: int) -> Row:
    seconds, *sizes = cast(list[float], python_says(f"{SET_UP}{code}\nrun({count}, work)\n"))
    after_first, *rest = sizes
    return {
        "what": what,
        "count": count,
        "MB after a tenth": round(after_first, 1),
        "MB at the end": round(sizes[-1], 1),
        "greatest growth MB": round(max(rest, default=after_first) - after_first, 2),
        "a second": round(count / seconds),
    }


def measure(settings: Settings) -> Report:
    """Both runs."""
    share = settings.number(PER_CENT) / PER_CENT
    rows = (
        _row("small questions", QUESTION, max(TENTHS, round(QUESTIONS * share))),
        _row("scenes loaded and dropped", LOAD, max(TENTHS, round(LOADS * share))),
    )
    counts = {"per cent": settings.number(PER_CENT), "faces of the scene": 6 * BLOCKS}
    notes = ("Wanted: less than 5 MB of growth after the first tenth.",)
    return Report(NAME, (Table("Resident memory", rows),), counts, notes)
