"""What does a reason cost: a proof beside the plain question, and the five nearest misses?

The plain question asks the conditions of the box model of three given faces, and is answered by yes
or no; the proof of the same conditions comes back as data, with the values and margins of each.
Near misses are those of the table model in a scene of 60 faces that is one thing. CPU time.
"""

from collections.abc import Callable

from benchmarks.common import Report, Row, Settings, Table, median_and_spread
from benchmarks.knowledge.block_scenes import FACES_PER_BLOCK, Layout, block_scene
from benchmarks.knowledge.knowledge_base import cpu_ms, rows_against
from facetlog.kb.knowledge_base import KnowledgeBase

__all__ = ["NAME", "measure"]

NAME = "time_reasons"
REPEATS = 20
BLOCKS = 10  # of six faces
MISSES = 5

PARTS = {"a": "f1", "b": "f3", "c": "f5"}
_FACES = f"[{', '.join(PARTS.values())}]"
# The conditions of rules/box.pl, tolerances as there.
PLAIN = ", ".join(
    f"holds({test})"
    for test in (
        f"each(_X, {_FACES}, measured(_X))",
        f"each_pair(_X, _Y, {_FACES}, adjoins(_X, _Y))",
        f"share_corner({_FACES})",
        f"each_pair(_X, _Y, {_FACES}, near(angle(_X, _Y), 90, 15))",
        f"each_pair(_X, _Y, {_FACES}, convex(_X, _Y))",
        f"each(_X, {_FACES}, at_least(share(_X), 0.80))",
        f"each(_X, {_FACES}, at_least(fill(_X), 0.80))",
        f"each(_X, {_FACES}, at_most(protrusion(_X), 0.05*thing_length(t1)))",
    )
)


def measure(settings: Settings) -> Report:
    """Proofs and near misses; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    with KnowledgeBase() as base:
        base.load_scene("blocks", block_scene(BLOCKS, one_thing=False))

        def plain() -> None:
            if len(list(base.query(PLAIN))) != 1:
                raise RuntimeError("the faces are no box")

        ways: list[tuple[str, Callable[[], object]]] = [
            ("the plain question", plain),
            ("its proof (why, three faces given)", lambda: base.why("blocks", "box", parts=PARTS)),
            ("the best of a thing, with its proof", lambda: base.judge("blocks", "box", "t1")),
        ]
        measured = [(what, cpu_ms(work, repeats)) for what, work in ways]
        proofs = tuple(
            {("÷ plain" if key == "÷ native" else key): value for key, value in row.items()}
            for row in rows_against(measured[0][1], measured)
        )
        base.load_scene("blocks", block_scene(BLOCKS, Layout.GRID, seed=settings.first))

        def misses() -> None:
            found = base.why_not("blocks", "table", thing="t1", count=MISSES)
            if len(found) != MISSES:
                raise RuntimeError(f"{len(found)} near misses")

        near: Row = {
            "faces": BLOCKS * FACES_PER_BLOCK,
            "misses": MISSES,
            **{
                f"ms {key}": value
                for key, value in median_and_spread(cpu_ms(misses, repeats), digits=1).items()
            },
        }
    tables = (Table("A proof of the box model", proofs), Table("Near misses of a table", (near,)))
    notes = ("Wanted: a proof at most 15 times the plain question, near misses within 300 ms.",)
    return Report(NAME, tables, {"repeats": repeats, "seed": settings.first}, notes)
