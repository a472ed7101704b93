"""How does the cost of the box rule grow with the scene, if each face touches at most six others?

Rows of blocks, 100 to 10,000 faces. The question asks for three faces that adjoin one another at
right angles, as a join or by each_pair; the judge asks the whole box model, of the row as one thing
or of each block in turn. CPU time, each from a freshly loaded scene.
"""

import time
from collections.abc import Callable

import numpy as np

from benchmarks.common import Cell, Report, Row, Settings, Table, median_and_spread
from benchmarks.knowledge.block_scenes import FACES_PER_BLOCK, block_scene
from benchmarks.knowledge.knowledge_base import SQUARE_DEGREES, exponent
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase

__all__ = ["NAME", "measure"]

NAME = "time_growth"
FACES = (100, 300, 1000, 3000, 10_000)
CORNERS_PER_BLOCK = 8
REPEATS = 3

_NEAR = f"near(angle({{}}, {{}}), 90, {SQUARE_DEGREES})"
JOIN = (
    "adjoins(A, B, _), A @< B, adjoins(B, C, _), B @< C, adjoins(A, C, _), "
    f"holds({_NEAR.format('A', 'B')}), holds({_NEAR.format('B', 'C')}), "
    f"holds({_NEAR.format('A', 'C')})"
)
SEARCH = f"each_pair(X, Y, [A, B, C], all([adjoins(X, Y), {_NEAR.format('X', 'Y')}]))"


def _asked(goal: str) -> Callable[[KnowledgeBase, int], None]:
    def work(base: KnowledgeBase, blocks: int) -> None:
        found = sum(chunk.length for chunk in base.query(goal).chunks())
        if found != CORNERS_PER_BLOCK * blocks:
            raise RuntimeError(f"{found} corners of {blocks} blocks")

    return work


def _judged_together(base: KnowledgeBase, blocks: int) -> None:
    state = base.judge("s", "box", "t1").state
    if (state is State.HOLDS) != (blocks == 1):
        raise RuntimeError(f"a row of {blocks} blocks as a box: {state}")


def _judged_alone(base: KnowledgeBase, blocks: int) -> None:
    verdicts = [base.judge("s", "box", f"t{block}") for block in range(1, blocks + 1)]
    if any(verdict.state is not State.HOLDS for verdict in verdicts):
        raise RuntimeError("a block is no box")


# Each with whether the blocks are one thing: only then do they touch one another.
WORK: dict[str, tuple[bool, Callable[[KnowledgeBase, int], None]]] = {
    "question, a join": (True, _asked(JOIN)),
    "question, each_pair": (True, _asked(SEARCH)),
    "judge, all in one thing": (True, _judged_together),
    "judge, every block": (False, _judged_alone),
}


def measure(settings: Settings) -> Report:
    """All sizes; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    rows: list[Row] = []
    medians: dict[str, list[float]] = {name: [] for name in WORK}
    sizes = []
    for faces in FACES:
        blocks = -(-faces // FACES_PER_BLOCK)
        sizes.append(blocks * FACES_PER_BLOCK)
        scenes = {one: block_scene(blocks, one_thing=one) for one in (True, False)}
        for name, (one_thing, work) in WORK.items():
            times = []
            with KnowledgeBase() as base:
                for _ in range(repeats):
                    base.load_scene("s", scenes[one_thing])
                    start = time.process_time()
                    work(base, blocks)
                    times.append(1e3 * (time.process_time() - start))
            medians[name].append(float(np.median(times)))
            spread: dict[str, Cell] = {
                f"ms {key}": value for key, value in median_and_spread(times, digits=2).items()
            }
            rows.append({"faces": sizes[-1], "what": name, **spread})
    grown: list[Row] = [
        {"what": name, "exponent": round(exponent(sizes, costs), 2)}
        for name, costs in medians.items()
    ]
    notes = ("Wanted: an exponent of at most 1.2.",)
    tables = (Table("Exponent of the cost", tuple(grown)), Table("CPU time", tuple(rows)))
    return Report(NAME, tables, {"repeats": repeats}, notes)
