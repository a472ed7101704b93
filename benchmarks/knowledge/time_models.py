"""How long does it take to parse and check models?

Files of the built-in models, over and over, each with a name and figures of its own. In models that
are `alike` many statements are the same; in `different` ones every part, line, constant and
definition has a name of its own, so that hardly a statement occurs twice. CPU time of this process;
the first file, which also makes the parser's table, is not counted.
"""

import random
import re
import resource
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, compute_median_and_spread
from facetlog.grammar.analysis import analyse
from facetlog.grammar.faults import Edit, applied
from facetlog.grammar.language_server.symbols import SymbolKind, occurrences
from facetlog.grammar.library import BUILTIN
from facetlog.grammar.reading.parse import parse
from facetlog.grammar.source import Source, Span

NAME = "time_models"
SIZES = (30, 100, 300, 1000)
REPEATS = 3
DIFFERENT_SIZES = (100, 1000)
STARTS = 5
# An example's scene and a comment are no part of what is parsed and checked as a model.
_COMMENT = re.compile(r"^[ \t]*#.*\n", re.MULTILINE)
_SHARE = re.compile(r"\b(\d+) %")
_NAMED = re.compile(r"^model (\w+)", re.MULTILINE)
_OWN = (
    SymbolKind.PART,
    SymbolKind.CONSTANT,
    SymbolKind.DEFINITION,
    SymbolKind.LINE,
    SymbolKind.LOCAL,
)


def make_model_library(count: int, seed: int, *, different: bool = False) -> str:
    """Return the text of a file of so many models; `different` ones share no names but the
    vocabulary.
    """
    rng = random.Random(seed)
    texts = [
        (path, _COMMENT.sub("", path.read_text("utf-8")))
        for path in sorted(BUILTIN.glob("*.model"))
    ]
    places = [_own_names(path, text) if different else () for path, text in texts]

    def varied(number: int) -> str:
        text = texts[number % len(texts)][1]
        edits = [Edit(Span(end, end), f"_{number}") for end in places[number % len(texts)]]
        named = _NAMED.sub(lambda found: f"model {found[1]}_{number}", applied(text, edits))
        return _SHARE.sub(lambda found: f"{int(found[1]) + rng.randint(0, 3)} %", named)

    return "\n".join(map(varied, range(count)))


def _own_names(path: Path, text: str) -> tuple[int, ...]:
    """Return where the names end that a text gives itself."""
    return tuple(
        one.span.end
        for one in occurrences(analyse(path, text)).every
        if one.symbol.kind in _OWN and one.symbol.home is not None and one.symbol.home.path == path
    )


def time_start_up(folder: Path) -> list[float]:
    """Return CPU seconds of `facetlog model check` on a file of one line, from its start to its
    end.
    """
    path = folder / "empty.model"
    path.write_text("# nothing\n", encoding="utf-8")
    command = [sys.executable, "-m", "facetlog", "model", "check", str(path)]
    found = []
    for _ in range(STARTS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        found.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return found


def time_files(count: int, seed: int, folder: Path) -> float:
    """Return the seconds that it takes to check so many files of one model each."""
    texts = make_model_library(count, seed).split("\nmodel ")
    paths = []
    for number, text in enumerate(texts):
        path = folder / f"m{number}.model"
        path.write_text(text if number == 0 else f"model {text}", encoding="utf-8")
        paths.append(path)
    start = time.process_time()
    for path in paths:
        analyse(path)
    return time.process_time() - start


def _checking_row(text: str, size: int, repeats: int) -> tuple[Row, float]:
    parsing, checking = [], []
    for _ in range(repeats):
        start = time.process_time()
        parse(Source("library.model", text))
        parsing.append(time.process_time() - start)
        start = time.process_time()
        analysis = analyse(Path("library.model"), text)
        checking.append(time.process_time() - start)
    if len(analysis.models) < size or analysis.errors:
        raise RuntimeError(f"{len(analysis.models)} of {size} models: {analysis.errors[:1]}")
    row: Row = {
        "models": size,
        "kB": round(len(text) / 1000),
        "s to parse": round(float(np.median(parsing)), 2),
        **{f"s to parse and check: {k}": v for k, v in compute_median_and_spread(checking).items()},
        "warnings": len(analysis.faults),
    }
    return row, float(np.median(checking))


def measure(settings: Settings) -> Report:
    """Measure all sizes; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    analyse(Path("first.model"), make_model_library(1, settings.first))
    rows: list[Row] = []
    checked: dict[int, float] = {}
    for size in SIZES:
        row, checked[size] = _checking_row(make_model_library(size, settings.first), size, repeats)
        rows.append({"statements": "alike", **row})
    for size in DIFFERENT_SIZES:
        text = make_model_library(size, settings.first, different=True)
        rows.append({"statements": "different", **_checking_row(text, size, repeats)[0]})
    with TemporaryDirectory() as folder:
        apart = time_files(SIZES[-1], settings.first, Path(folder))
        start = float(np.median(time_start_up(Path(folder))))
    growth = np.polyfit(np.log(SIZES), np.log([checked[size] for size in SIZES]), 1)[0]
    notes = (
        f"Grows with the number of models to the power {growth:.2f}.",
        f"{SIZES[-1]:,} models in files of their own: {apart:.2f} s.",
        f"`facetlog model check` of a file without models: {start:.2f} s, from start to end.",
        "Wanted: linear, 1,000 models in less than 20 s.",
    )
    counts = {"repeats": repeats, "seed": settings.first}
    return Report(NAME, (Table("Parsing and checking", tuple(rows)),), counts, notes)
