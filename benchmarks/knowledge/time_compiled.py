"""What does a compiled model cost beside the best hand-written one, on the same facts?

Box, table and chair from the model language, and as they were written in Prolog by hand. Asked is
`is_a(T, Model)` of every thing of a scene, each time of a freshly loaded one; both files are loaded
in the same way, and take turns. CPU time.
"""

import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.knowledge.block_scenes import block_scene
from facetlog.grammar.library import BUILTIN
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.exact_solids.builders import build

__all__ = ["NAME", "measure"]

NAME = "time_compiled"
REPEATS = 15
BY_HAND = Path(__file__).resolve().parents[2] / "tests" / "rules" / "by_hand"
MODELS = ("box", "table", "chair")


def scenes() -> dict[str, list[Fact]]:
    """The scenes by name."""
    found: dict[str, list[Fact]] = {
        "a block": list(block_scene(1, one_thing=True)),
        "10 blocks": list(block_scene(10, one_thing=False)),
        "a row of 10 blocks": list(block_scene(10, one_thing=True)),
        "50 blocks": list(block_scene(50, one_thing=False)),
    }
    for name in ("table", "chair", "shelf"):
        found[f"a {name}"] = [f.row for f in scene_facts(build(name, {}))]
    return found


def _asked(base: KnowledgeBase, model: str, facts: Iterable[Fact]) -> tuple[int, float]:
    base.load_scene("s", facts)
    start = time.process_time()
    held = sum(1 for _ in base.query(f"is_a(T, {model})"))
    return held, time.process_time() - start


def measure(settings: Settings) -> Report:
    """All models and scenes; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    rows: list[Row] = []
    for model in MODELS:
        with KnowledgeBase() as ours, KnowledgeBase() as peer:
            ours.load_rules(BUILTIN / f"{model}.model")
            peer.load_rules(BY_HAND / f"{model}.pl", trusted=True)
            for name, facts in scenes().items():
                times = {"compiled": list[float](), "by hand": list[float]()}
                held = set()
                for _ in range(repeats):
                    for way, base in (("compiled", ours), ("by hand", peer)):
                        number, spent = _asked(base, model, facts)
                        held.add(number)
                        times[way].append(1e3 * spent)
                if len(held) != 1:
                    raise RuntimeError(f"{model} of {name}: the two find {held}")
                compiled, by_hand = (float(np.median(t)) for t in times.values())
                rows.append(
                    {
                        "model": model,
                        "scene": name,
                        "hold": held.pop(),
                        "compiled, ms": round(compiled, 2),
                        "by hand, ms": round(by_hand, 2),
                        "÷": round(compiled / by_hand, 2),
                        "quartiles of ÷": _quartiles(*times.values()),
                    }
                )
    notes = ("Wanted: box at most 1.1 times the hand-written one.",)
    return Report(NAME, (Table("is_a", tuple(rows)),), {"repeats": repeats}, notes)


def _quartiles(ours: list[float], peer: list[float]) -> str:
    low, high = np.percentile(np.array(ours) / np.array(peer), [25, 75])
    return f"{low:.2f}–{high:.2f}"
