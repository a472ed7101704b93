"""How long does it take to find all three faces at right angles, beside clingo on the same facts?

The box rule of the paper: three planes, each two of them at 90 ± 15 degrees, among n planes in
random directions. CPU time. Reading the facts is not counted on either side (the last column says
what it takes); clingo's time is that of grounding and solving, and numpy's that of finding them in
arrays of angles by a loop over the first face.
"""

import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.common import Cell, Report, Row, Settings, Table
from benchmarks.knowledge.knowledge_base import SQUARE_DEGREES, random_planes
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

__all__ = ["NAME", "measure"]

NAME = "time_box_rule"
SIZES = (10, 100, 300)
REPEATS = 3
CLINGO = "clingo"
MILLI = 1000  # clingo knows whole numbers only

SEARCH = f"each_pair(X, Y, [A, B, C], near(angle(X, Y), 90, {SQUARE_DEGREES}))"
JOIN = ", ".join(
    f"angle({a}, {b}, {d}, _), {a} @< {b}, abs({d} - 90) =< {SQUARE_DEGREES}"
    for a, b, d in (("A", "B", "D"), ("B", "C", "E"), ("A", "C", "F"))
)

_SQUARE = f"|{{}} - {90 * MILLI}| <= {SQUARE_DEGREES * MILLI}"
CLINGO_JOIN = (
    "box(A, B, C) :- "
    + ", ".join(
        f"angle({a}, {b}, {d}), {a} < {b}, {_SQUARE.format(d)}"
        for a, b, d in (("A", "B", "D"), ("B", "C", "E"), ("A", "C", "F"))
    )
    + "."
)
CLINGO_PAIRS = (
    f"square(A, B) :- angle(A, B, D), A < B, {_SQUARE.format('D')}. "
    "box(A, B, C) :- square(A, B), square(B, C), square(A, C)."
)


def clingo_times(facts: list[Fact], rule: str) -> tuple[int, float, float]:
    """Boxes, seconds to ground and solve, and seconds to read."""
    import clingo  # type: ignore[import-not-found,unused-ignore]

    # What clingo has sorted names like Prolog's; only the direction of a pair depends on it.
    lines = (
        f"angle({a},{b},{round(float(d) * MILLI)})."
        for a, b, d in (f[1:4] for f in facts if f[0] == "angle")
    )
    text = "\n".join(lines) + rule + " #show box/3."
    start = time.process_time()
    control: Any = clingo.Control(["--warn=none"])
    control.add("base", [], text)
    read = time.process_time()
    control.ground([("base", [])])
    counts: list[int] = []
    control.solve(on_model=lambda model: counts.append(len(model.symbols(shown=True))))
    return counts[0], time.process_time() - read, read - start


def ours(facts: list[Fact], goal: str, *, again: bool) -> tuple[int, float, float]:
    """Boxes, seconds to answer, the first time or when asked again, and seconds to load."""
    with KnowledgeBase() as base:
        start = time.process_time()
        base.load_scene("s", facts)
        loaded = time.process_time()

        def boxes() -> int:
            return sum(chunk.length for chunk in base.query(goal).chunks())

        if again:
            boxes()
        begin = time.process_time()
        return boxes(), time.process_time() - begin, loaded - start


def numpy_times(facts: list[Fact]) -> tuple[int, float, float]:
    """Boxes, seconds to find them in arrays that are there, and seconds to make these."""
    start = time.process_time()
    faces = sorted(str(fact[1]) for fact in facts if fact[0] == "face")
    place = {name: number for number, name in enumerate(faces)}
    rows = [fact[1:4] for fact in facts if fact[0] == "angle"]
    first = np.array([place[str(row[0])] for row in rows])
    second = np.array([place[str(row[1])] for row in rows])
    degrees = np.array([float(row[2]) for row in rows])
    made = time.process_time()
    square = (first < second) & (np.abs(degrees - 90) <= SQUARE_DEGREES)
    passing = np.zeros((len(faces), len(faces)), np.bool_)
    passing[first[square], second[square]] = True
    boxes = []
    for face in range(len(faces)):
        others = np.flatnonzero(passing[face])
        left, right = np.nonzero(passing[np.ix_(others, others)])
        boxes.append(np.stack([np.full(len(left), face), others[left], others[right]], axis=1))
    found = np.concatenate(boxes)
    return len(found), time.process_time() - made, made - start


Way = Callable[[list[Fact]], tuple[int, float, float]]
OURS: dict[str, Way] = {
    "each_pair, first time": lambda facts: ours(facts, SEARCH, again=False),
    "each_pair, asked again": lambda facts: ours(facts, SEARCH, again=True),
    "join of angles": lambda facts: ours(facts, JOIN, again=False),
}
NUMPY: dict[str, Way] = {"numpy on arrays": numpy_times}
PEER: dict[str, Way] = {
    "clingo, rule on angles": lambda facts: clingo_times(facts, CLINGO_JOIN),
    "clingo, pairs first": lambda facts: clingo_times(facts, CLINGO_PAIRS),
}


def _rows(size: int, ways: dict[str, Way], repeats: int, seed: int) -> Iterator[Row]:
    facts = random_planes(size, seed)
    measured = {name: np.array([way(facts) for _ in range(repeats)]) for name, way in ways.items()}
    counts = {int(n) for runs in measured.values() for n in runs[:, 0]}
    if len(counts) != 1:
        raise RuntimeError(f"the ways find different numbers of boxes: {counts}")
    medians = {name: 1e3 * np.median(runs[:, 1:], axis=0) for name, runs in measured.items()}
    peers = {name: medians[name][0] for name in (*PEER, *NUMPY) if name in medians}
    for name, (spent, load) in medians.items():
        low, high = 1e3 * np.percentile(measured[name][:, 1], [25, 75])
        ratios: dict[str, Cell] = {
            f"÷ {peer}": round(float(spent / other), 3) for peer, other in peers.items()
        }
        yield {
            "n": size,
            "way": name,
            "boxes": counts.copy().pop(),
            "ms median": round(float(spent), 2),
            "ms quartiles": f"{low:.4g}–{high:.4g}",
            **ratios,
            "ms to load": round(float(load), 1),
        }


def measure(settings: Settings) -> Report:
    """All sizes and ways; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    peer = PEER if find_spec(CLINGO) else {}
    ways = {**OURS, **NUMPY, **peer}
    rows = [row for n in SIZES for row in _rows(n, ways, repeats, settings.first)]
    notes = [
        "Wanted at n = 300: each_pair at most 2 times numpy on arrays and 0.1 times clingo with "
        "its pairs first; the join no slower than clingo."
    ]
    if not peer:
        notes.append("clingo is not installed (PyPI: clingo): no peer.")
    counts = {"repeats": repeats, "seed": settings.first}
    return Report(NAME, (Table("All boxes", tuple(rows)),), counts, tuple(notes))
