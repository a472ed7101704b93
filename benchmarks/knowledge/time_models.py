"""How long does it take to parse and check models, and to look again after an edit?

Files of the built-in models, over and over, each with a name and figures of its own. In models that
are `alike` many statements are the same, which are read once and copied; in `different` ones every
part, line, constant and definition has a name of its own, so that hardly a statement occurs twice.
CPU time of this process; the first file, which also makes the parser's table, is not counted, and
what was read is forgotten before each look. Not so of edits, whose first look is not counted: each
inserts a line, changes a word or a model's name, at places all over the file.
"""

import random
import re
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, median_and_spread
from benchmarks.knowledge.knowledge_base import exponent
from facetlog.grammar.analysis import Memory, analyse
from facetlog.grammar.fixing.fix import Edit, applied
from facetlog.grammar.language_server.find_symbols import occurrences
from facetlog.grammar.language_server.symbols import SymbolKind
from facetlog.grammar.library import BUILTIN
from facetlog.grammar.reading.parse import forget, parse
from facetlog.grammar.source import Source, Span

__all__ = ["NAME", "measure", "model_library"]

NAME = "time_models"
SIZES = (30, 100, 300, 1000)
REPEATS = 3
DIFFERENT_SIZES = (100, 1000)
STARTS = 5
EDITED = 25
"""Models of the file that is edited: 1,200 lines."""
EDITS = 40
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


def model_library(count: int, seed: int, *, different: bool = False) -> str:
    """The text of a file of so many models; `different` ones share no names but the vocabulary."""
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
    """Where the names end that a text gives itself."""
    return tuple(
        one.span.end
        for one in occurrences(analyse(path, text)).every
        if one.symbol.kind in _OWN and one.symbol.home is not None and one.symbol.home.path == path
    )


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


def _renamings(text: str, count: int) -> Iterator[str]:
    """The text with one model's name changed, at places all over it."""
    names = list(_NAMED.finditer(text))
    for number in range(count):
        end = names[(len(names) * number) // count].end()
        yield f"{text[:end]}{'x' * (1 + number % 2)}{text[end:]}"


def edit_times(count: int, seed: int) -> tuple[int, dict[str, list[float]]]:
    """Lines of a file, and the seconds that a look at it takes after edits of each kind."""
    text = model_library(count, seed)
    kinds = {
        "lines and words": _edits(text, EDITS, seed),
        "names of models": _renamings(text, EDITS),
    }
    path, memory = Path("library.model"), Memory()
    analyse(path, text, memory=memory)
    found: dict[str, list[float]] = {kind: [] for kind in kinds}
    for kind, texts in kinds.items():
        for edited in texts:
            start = time.process_time()
            analyse(path, edited, memory=memory)
            found[kind].append(time.process_time() - start)
    return text.count("\n"), found


def start_up(folder: Path) -> list[float]:
    """CPU seconds of `facetlog model check` on a file of one line, from its start to its end."""
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


def _checking_row(text: str, size: int, repeats: int) -> tuple[Row, float]:
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
    row: Row = {
        "models": size,
        "kB": round(len(text) / 1000),
        "s to parse": round(float(np.median(parsing)), 2),
        **{f"s to parse and check: {k}": v for k, v in median_and_spread(checking).items()},
        "warnings": len(analysis.faults),
    }
    return row, float(np.median(checking))


def measure(settings: Settings) -> Report:
    """All sizes; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    analyse(Path("first.model"), model_library(1, settings.first))
    rows: list[Row] = []
    checked: dict[int, float] = {}
    for size in SIZES:
        row, checked[size] = _checking_row(model_library(size, settings.first), size, repeats)
        rows.append({"statements": "alike", **row})
    for size in DIFFERENT_SIZES:
        text = model_library(size, settings.first, different=True)
        rows.append({"statements": "different", **_checking_row(text, size, repeats)[0]})
    lines, times = edit_times(EDITED, settings.first)
    edits: list[Row] = []
    for kind, some in times.items():
        spread = {k: round(1000 * v, 1) for k, v in _spread(some).items()}
        of_kind = {f"ms a look: {k}": v for k, v in spread.items()}
        edits.append({"edits of": kind, "lines": lines, "edits": EDITS, **of_kind})
    with TemporaryDirectory() as folder:
        apart = file_times(SIZES[-1], settings.first, Path(folder))
        start = float(np.median(start_up(Path(folder))))
    growth = exponent(SIZES, [checked[size] for size in SIZES])
    notes = (
        f"Grows with the number of models to the power {growth:.2f}.",
        f"{SIZES[-1]:,} models in files of their own: {apart:.2f} s.",
        f"`facetlog model check` of a file without models: {start:.2f} s, from start to end.",
        "Wanted: linear, 1,000 models in less than 4 s, a look after an edit in less than 50 ms.",
    )
    counts = {"repeats": repeats, "seed": settings.first}
    tables = Table("Parsing and checking", tuple(rows)), Table("After an edit", tuple(edits))
    return Report(NAME, tables, counts, notes)


def _spread(times: list[float]) -> dict[str, float]:
    """Median, quartiles and the longest."""
    low, middle, high = np.quantile(times, (0.25, 0.5, 0.75))
    ends = {"lower quartile": float(low), "upper quartile": float(high)}
    return {"median": float(middle), **ends, "worst": max(times)}
