"""How long does it take to parse and check models, and does it grow with their number?

Files of the built-in models, over and over, each with a name and figures of its own. CPU time of
this process; the first file, which also makes the parser's table, is not counted.
"""

import random
import re
import time
from pathlib import Path

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, command, median_and_spread
from benchmarks.knowledge_base import exponent
from facetlog.grammar.analysis import analyse
from facetlog.grammar.library import BUILTIN
from facetlog.grammar.parse import parse
from facetlog.grammar.source import Source

__all__ = ["NAME", "main", "measure", "model_library"]

NAME = "time_models"
SIZES = (30, 100, 300, 1000)
REPEATS = 3
# An example's scene and a comment are no part of what is parsed and checked as a model.
_COMMENT = re.compile(r"^[ \t]*#.*\n", re.MULTILINE)
_SHARE = re.compile(r"\b(\d+) %")
_NAMED = re.compile(r"^model (\w+)", re.MULTILINE)


def model_library(count: int, seed: int) -> str:
    """The text of a file of so many models, none like another."""
    rng = random.Random(seed)
    texts = [_COMMENT.sub("", p.read_text("utf-8")) for p in sorted(BUILTIN.glob("*.model"))]

    def varied(text: str, number: int) -> str:
        named = _NAMED.sub(lambda found: f"model {found[1]}_{number}", text)
        return _SHARE.sub(lambda found: f"{int(found[1]) + rng.randint(0, 3)} %", named)

    return "\n".join(varied(texts[i % len(texts)], i) for i in range(count))


def measure(settings: Settings) -> Report:
    """All sizes; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    analyse(Path("first.model"), model_library(1, settings.first))
    rows: list[Row] = []
    checked = []
    for size in SIZES:
        text = model_library(size, settings.first)
        parsing, checking = [], []
        for _ in range(repeats):
            start = time.process_time()
            parse(Source("library.model", text))
            read = time.process_time()
            analysis = analyse(Path("library.model"), text)
            checking.append(time.process_time() - read)
            parsing.append(read - start)
        if len(analysis.models) < size or analysis.errors:
            raise RuntimeError(f"{len(analysis.models)} of {size} models: {analysis.errors[:1]}")
        checked.append(float(np.median(checking)))
        rows.append(
            {
                "models": size,
                "kB": round(len(text) / 1000),
                "s to parse": round(float(np.median(parsing)), 2),
                **{f"s to parse and check: {k}": v for k, v in median_and_spread(checking).items()},
                "warnings": len(analysis.faults),
            }
        )
    growth = exponent(SIZES, checked)
    notes = (
        f"Grows with the number of models to the power {growth:.2f}.",
        "Wanted: linear, and 1,000 models in less than 3 s.",
    )
    counts = {"repeats": repeats, "seed": settings.first}
    return Report(NAME, (Table("Parsing and checking", tuple(rows)),), counts, notes)


main = command(NAME, __doc__, measure)

if __name__ == "__main__":
    main(None)
