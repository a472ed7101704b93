"""How long does it take to parse and check models, and to look again after an edit?

Files of the built-in models, over and over, each with a name and figures of its own. CPU time of
this process; the first file, which also makes the parser's table, is not counted, and what was read
is forgotten before each look. Not so of edits, whose first look is not counted: each inserts a line
or changes a word, at places all over the file.
"""

import random
import re
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, command, median_and_spread
from benchmarks.knowledge_base import exponent
from facetlog.grammar.analysis import Memory, analyse
from facetlog.grammar.library import BUILTIN
from facetlog.grammar.parse import forget, parse
from facetlog.grammar.source import Source

__all__ = ["NAME", "main", "measure", "model_library"]

NAME = "time_models"
SIZES = (30, 100, 300, 1000)
REPEATS = 3
EDITED = 25
"""Models of the file that is edited: 1,200 lines."""
EDITS = 40
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


def _edits(text: str, count: int, seed: int) -> Iterator[str]:
    """The text after each of some edits, at places all over it; every other moves what follows."""
    rng = random.Random(seed)
    lines = text.split("\n")
    said = [i for i, line in enumerate(lines) if " at least " in line]
    for number in range(count):
        at = said[(len(said) * number) // count]
        edited = list(lines)
        if number % 2:
            edited[at] = edited[at].replace(" at least ", " at most ", 1)
        else:
            edited.insert(at, f"  # a line more, number {rng.randint(0, 10**6)}")
        yield "\n".join(edited)


def edit_times(count: int, seed: int) -> tuple[int, list[float]]:
    """Lines of a file, and the seconds that a look at it takes after each of some edits."""
    text = model_library(EDITED, seed)
    path, memory = Path("library.model"), Memory()
    analyse(path, text, memory=memory)
    found = []
    for edited in _edits(text, count, seed):
        start = time.process_time()
        analyse(path, edited, memory=memory)
        found.append(time.process_time() - start)
    return text.count("\n"), found


def file_times(count: int, seed: int, folder: Path) -> float:
    """The seconds that it takes to check so many files of one model each."""
    texts = model_library(count, seed).split("\nmodel ")
    paths = []
    for number, text in enumerate(texts):
        path = folder / f"m{number}.model"
        path.write_text(text if number == 0 else f"model {text}", encoding="utf-8")
        paths.append(path)
    start = time.process_time()
    for path in paths:
        analyse(path)
    return time.process_time() - start


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
            forget()
            start = time.process_time()
            parse(Source("library.model", text))
            parsing.append(time.process_time() - start)
            forget()
            start = time.process_time()
            analysis = analyse(Path("library.model"), text)
            checking.append(time.process_time() - start)
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
    lines, times = edit_times(EDITS, settings.first)
    spread = {k: round(1000 * v, 1) for k, v in _spread(times).items()}
    edits: tuple[Row, ...] = (
        {"lines": lines, "edits": EDITS, **{f"ms a look: {k}": v for k, v in spread.items()}},
    )
    with TemporaryDirectory() as folder:
        apart = file_times(SIZES[-1], settings.first, Path(folder))
    growth = exponent(SIZES, checked)
    notes = (
        f"Grows with the number of models to the power {growth:.2f}.",
        f"{SIZES[-1]:,} models in files of their own: {apart:.2f} s.",
        "Wanted: linear, 1,000 models in less than 4 s, a look after an edit in less than 50 ms.",
        "Models made of one text share most statements, which are read once and copied.",
    )
    counts = {"repeats": repeats, "seed": settings.first}
    tables = Table("Parsing and checking", tuple(rows)), Table("After an edit", edits)
    return Report(NAME, tables, counts, notes)


def _spread(times: list[float]) -> dict[str, float]:
    """Median, quartiles and the longest."""
    low, middle, high = np.quantile(times, (0.25, 0.5, 0.75))
    ends = {"lower quartile": float(low), "upper quartile": float(high)}
    return {"median": float(middle), **ends, "worst": max(times)}


main = command(NAME, __doc__, measure)

if __name__ == "__main__":
    main(None)
