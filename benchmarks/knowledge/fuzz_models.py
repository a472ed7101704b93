"""Does any text give either clauses or faults, in bounded time and memory?

Built-in models mutated: characters, words, lines and whole pieces deleted, doubled, swapped,
replaced by words of the language, brackets, quotes, signs and letters of other scripts. Each file
is read, checked and, if it has no errors, compiled.
"""

import random
import time
import tracemalloc
from collections import Counter
from pathlib import Path

import numpy as np

from benchmarks.common import Report, Settings, Table
from facetlog.grammar.analysis import analyse
from facetlog.grammar.compile import compiled
from facetlog.grammar.library import BUILTIN

__all__ = ["NAME", "measure", "mutated"]

NAME = "fuzz_models"
FILES = 100_000
MOST_MUTATIONS = 6
EVERY = 500
"""Of so many files one is run with its memory traced, which takes several times as long."""

_WORDS = """
( ) " , : . = ± +/- % ° # \\ - * / 3 1e999 0 15 deg cm é 中 '' each pair of there is a no not
and or model like use let define face faces at least most between fading if known expect: example
holds because where size drop optional any number one this count lowest
"""
PIECES = (*_WORDS.split(), "\n", "\t", "\0", "")


def mutated(texts: tuple[str, ...], rng: random.Random) -> str:
    """One of the texts, mutated."""
    text = rng.choice(texts)
    for _ in range(rng.randint(1, MOST_MUTATIONS)):
        at = rng.randrange(len(text) + 1)
        to = min(len(text), at + int(rng.expovariate(0.1)))
        match rng.randrange(6):
            case 0:
                text = text[:at] + text[to:]
            case 1:
                text = text[:at] + text[at:to] * rng.randint(2, 4) + text[to:]
            case 2:
                text = text[:at] + rng.choice(PIECES) + text[at:]
            case 3:
                text = text[:at] + f" {rng.choice(PIECES)} " + text[to:]
            case 4:
                other = rng.choice(texts)
                start = rng.randrange(len(other))
                text = text[:at] + other[start : start + rng.randint(1, 80)] + text[to:]
            case _:
                lines = text.split("\n")
                line = rng.randrange(len(lines))
                lines.insert(rng.randrange(len(lines)), lines.pop(line))
                text = "\n".join(lines)
    return text


def measure(settings: Settings) -> Report:
    """So many files as seeds are asked for, else 100,000."""
    texts = tuple(p.read_text("utf-8") for p in sorted(BUILTIN.glob("*.model")))
    outcomes: Counter[str] = Counter()
    codes: Counter[str] = Counter()
    seconds, peaks = [], []
    analyse(Path("first.model"), texts[0])
    for seed in settings.seeds(FILES):
        text = mutated(texts, random.Random(seed))
        traced = seed % EVERY == 0
        if traced:
            tracemalloc.start()
        start = time.perf_counter()
        analysis = analyse(BUILTIN / "mutated.model", text)
        if analysis.errors:
            outcomes["faults"] += 1
            codes.update(f.code for f in analysis.errors)
            for fault in analysis.errors:
                list(fault.lines())
        else:
            compiled(analysis)
            outcomes["clauses"] += 1
        if traced:
            peaks.append(tracemalloc.get_traced_memory()[1] / 1e6)
            tracemalloc.stop()
        else:
            seconds.append(time.perf_counter() - start)
    row = {
        "files": sum(outcomes.values()),
        "with clauses": outcomes["clauses"],
        "with faults": outcomes["faults"],
        "exceptions": 0,
        "ms median": round(1e3 * float(np.median(seconds)), 1),
        "ms 99.9 %": round(1e3 * float(np.percentile(seconds, 99.9)), 1),
        "ms longest": round(1e3 * max(seconds), 1),
        "MB at most": round(max(peaks), 1) if peaks else None,
    }
    kinds = tuple({"fault": code, "times": times} for code, times in codes.most_common())
    notes = ("An exception ends the run: none is caught.", "Wanted: 100,000 files.")
    tables = (Table("Mutated files", (row,)), Table("Faults told", kinds))
    counts = {"files": row["files"], "seed": settings.first}
    return Report(NAME, tables, counts, notes)
