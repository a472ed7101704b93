"""docs/benchmarks.md: the reports that are kept, as a page to read."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import cast

from benchmarks.common import Cell, shown
from benchmarks.wanted import wanted_rows
from benchmarks.wanted_of_the_judge import BEFORE, WANTED_OF_THE_JUDGE

__all__ = ["benchmarks_page"]

HEAD = """\
# Benchmarks

Made by `python -m benchmarks --write`; do not edit. `make bench` runs all of them, and each part
names the command that repeats it alone (from the top of the repository, with the project's
Python). Seeds are fixed, so that all but times come out again on the same libraries. The reports
as JSON are in benchmarks/results.
"""
EYES = """\
## The eyes: what is wanted and what is measured

From the reports below, each of the code that it names.
"""
JUDGE = """\
## The judge: what is wanted, what it was, and what is measured

Before is what was measured when the meaning of a test was written six times, on a machine of the
same kind.
"""
MACHINE_FIRST = ("cores", "processor", "memory GB", "system")

Plain = Mapping[str, object]


def benchmarks_page(reports: Iterable[tuple[str, Plain]]) -> str:
    """The page, from the question and the report (as JSON has it) of each benchmark."""
    lines = [HEAD]
    kept = tuple(reports)
    by_name = {str(report["benchmark"]): report for _, report in kept}
    rows = wanted_rows(by_name)
    if rows:
        lines.extend((EYES, *_table(rows), ""))
    judged = wanted_rows(by_name, WANTED_OF_THE_JUDGE, BEFORE)
    if judged:
        lines.extend((JUDGE, *_table(judged), ""))
    for question, report in kept:
        lines.extend(_section(question, report))
    return "\n".join(lines)


def _section(question: str, report: Plain) -> Iterator[str]:
    name = report["benchmark"]
    yield f"## {name}"
    yield ""
    yield " ".join(question.split())
    yield ""
    yield f"    python -m benchmarks {name}"
    yield ""
    settings = cast(Mapping[str, Cell], report["settings"])
    if settings:
        yield "Settings: " + ", ".join(f"{k} {shown(v)}" for k, v in settings.items()) + "."
        yield ""
    for table in cast(list[Plain], report["tables"]):
        yield f"**{table['title']}**"
        yield ""
        yield from _table(cast(list[Mapping[str, Cell]], table["rows"]))
        yield ""
    notes = cast(list[str], report["notes"])
    if notes:
        yield " ".join(notes)
        yield ""
    code = f" Code: commit {report['code']}." if report["code"] else ""
    yield f"Machine: {_machine(cast(Mapping[str, Cell], report['machine']))}.{code}"
    yield ""


def _table(rows: Sequence[Mapping[str, Cell]]) -> Iterator[str]:
    yield f"| {' | '.join(rows[0])} |"
    yield f"| {' | '.join('---' for _ in rows[0])} |"
    for row in rows:
        yield f"| {' | '.join(shown(cell).replace('|', chr(92) + '|') for cell in row.values())} |"


def _machine(machine: Mapping[str, Cell]) -> str:
    cores, processor, memory, system = (machine[key] for key in MACHINE_FIRST)
    rest = (f"{key} {value}" for key, value in machine.items() if key not in MACHINE_FIRST)
    return f"{cores} cores, {processor}, {memory} GB, {system}, {', '.join(rest)}"
