"""The common form of the benchmarks: settings in, a report of tables out, as text and as JSON.

A benchmark is a module with a docstring whose first paragraph is the question it answers, with
`NAME` and with `measure(settings) -> Report`; `python -m benchmarks NAME` runs it.
"""

import argparse
import hashlib
import os
import platform
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

SCHEMA = "facetlog-benchmark/1"
DATA_VARIABLE = "FACETLOG_DATA"
HASH_DIGITS = 12
# What the figures depend on: the folders whose last change names the code that was measured.
PROGRAM = ("src", "perception", "grammar", "kb", "rules", "robot")
LIBRARIES = ("numpy", "scipy", "opencv-python-headless", "filterpy", "shapely")

Cell: TypeAlias = str | int | float | bool | None
Row: TypeAlias = Mapping[str, Cell]


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of any benchmark: the first seed, and how many (None: as many as usual)."""

    count: int | None = None
    first: int = 0

    def number(self, usual: int) -> int:
        """Return how many seeds or repeats."""
        return usual if self.count is None else self.count

    def seeds(self, usual: int) -> range:
        """Return the seeds, the usual number of them or as many as were asked for."""
        return range(self.first, self.first + self.number(usual))


def make_settings_parser(program: str, description: str) -> argparse.ArgumentParser:
    """Return a parser of the arguments that all benchmarks share."""
    parser = argparse.ArgumentParser(prog=program, description=description)
    parser.add_argument("--seeds", type=_positive, help="number of seeds (else its own)")
    parser.add_argument("--first-seed", type=int, default=0, help="the first of them (else 0)")
    parser.add_argument("--json", action="store_true", help="one JSON object a benchmark")
    return parser


@dataclass(frozen=True, slots=True)
class Table:
    """Rows with the same keys; a cell that has no value is None."""

    title: str
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Report:
    """Results of a benchmark, or, in `skipped`, why there are none.

    `settings` are the numbers that the figures depend on; `notes` say how to read the tables.
    """

    name: str
    tables: tuple[Table, ...] = ()
    settings: Mapping[str, Cell] = field(default_factory=lambda: MappingProxyType({}))
    notes: tuple[str, ...] = ()
    skipped: str | None = None

    def to_json(self) -> dict[str, object]:
        """Return the report as plain data, with the schema's name and the machine."""
        return {
            "schema": SCHEMA,
            "benchmark": self.name,
            "code": get_code_version(),
            "machine": machine(),
            "settings": dict(self.settings),
            "tables": [
                {"title": t.title, "rows": [dict(row) for row in t.rows]} for t in self.tables
            ],
            "notes": list(self.notes),
            "skipped": self.skipped,
        }


def _positive(value: str) -> int:
    number = int(value)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{value} is not a positive number")
    return number


def text(report: Mapping[str, object]) -> Iterator[str]:
    """Yield the lines of a report (as JSON has it) for a terminal."""
    yield f"{report['benchmark']}  {_pairs(report['settings'])}".rstrip()
    if report["skipped"]:
        yield f"skipped: {report['skipped']}"
    tables = report["tables"]
    assert isinstance(tables, list)
    for table in tables:
        yield ""
        yield table["title"]
        heads = list(table["rows"][0]) if table["rows"] else []
        rows = [[shown(cell) for cell in row.values()] for row in table["rows"]]
        widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
        for cells in (heads, *rows):
            yield "  ".join(c.ljust(w) for c, w in zip(cells, widths, strict=True)).rstrip()
    notes = report["notes"]
    assert isinstance(notes, list)
    yield from ("", *notes)


def _pairs(values: object) -> str:
    assert isinstance(values, dict)
    return ", ".join(f"{key} {shown(value)}" for key, value in values.items())


def shown(cell: Cell) -> str:
    """Return a cell as text: four significant digits are more than any of the figures is sure of.

    >>> [shown(x) for x in (None, 0.123456, 20, 12345.6, True)]
    ['–', '0.1235', '20', '12346', 'yes']
    """
    match cell:
        case None:
            return "–"
        case bool():
            return "yes" if cell else "no"
        case float():
            return f"{cell:.0f}" if abs(cell) >= 1e4 else f"{cell:.4g}"
        case _:
            return str(cell)


def compute_median_and_spread(values: Iterable[float], digits: int = 3) -> dict[str, Cell]:
    """Return median, quartiles and worst (largest) of the values; None where there are none.

    >>> compute_median_and_spread([1.0, 2.0, 3.0, 10.0, 4.0])
    {'median': 3.0, 'quartiles': '2–4', 'worst': 10.0}
    """
    known = [v for v in values if not np.isnan(v)]
    if not known:
        return {"median": None, "quartiles": None, "worst": None}
    low, middle, high = (round(float(q), digits) for q in np.percentile(known, [25, 50, 75]))
    return {
        "median": middle,
        "quartiles": f"{shown(low)}–{shown(high)}",
        "worst": round(max(known), digits),
    }


def get_code_version() -> str | None:
    """Return the last commit that changed the program, with a + if files were changed since.

    None where there is no git repository.
    """
    git = shutil.which("git")
    root = Path(__file__).resolve().parents[1]
    if git is None or not (root / ".git").exists():
        return None

    def said(*arguments: str) -> str:
        command = [git, "-C", str(root), *arguments, "--", *PROGRAM]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    changed = said("status", "--porcelain", "--untracked-files=no")
    return said("log", "-1", "--format=%h") + ("+" if changed else "")


def machine() -> dict[str, Cell]:
    """Return the machine and the libraries, without names of hosts, users or folders."""
    pages = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return {
        "cores": os.cpu_count(),
        "processor": _processor(),
        "memory GB": round(pages / 2**30),
        "system": platform.system(),
        "Python": platform.python_version(),
        **{name: version(name) for name in LIBRARIES},
        "SWI-Prolog": _prolog_version(),
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.machine()


def _prolog_version() -> str | None:
    program = shutil.which("swipl")
    if program is None:
        return None
    said = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    return next((word for word in said.stdout.split() if word[0].isdigit()), None)


def find_data_set(*parts: str) -> Path | str:
    """Return the folder of third-party data, or the reason why a benchmark must do without it."""
    root = os.environ.get(DATA_VARIABLE)
    if not root:
        return f"{DATA_VARIABLE} is not set: it names the folder of third-party data"
    folder = Path(root).joinpath(*parts)
    if not folder.is_dir():
        return f"{DATA_VARIABLE} has no folder {'/'.join(parts)}"
    return folder


def hash_tree(folder: Path) -> str:
    """Return SHA-256 of the names and contents of all files below the folder, its first digits."""
    total = hashlib.sha256()
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        total.update(path.relative_to(folder).as_posix().encode())
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()[:HASH_DIGITS]
