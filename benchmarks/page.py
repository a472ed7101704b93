"""Pages made of the kept reports: headline figures, and all tables."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias, cast

from benchmarks.common import Cell, Row, shown

Reports: TypeAlias = Mapping[str, Mapping[str, object]]
"""Reports as JSON has them, by the name of their benchmark."""

TEMPLATE = Path(__file__).with_name("headlines.md")
# A row of the template: what | text with {columns} | benchmark; table; column = value; …
ROW = re.compile(r"^\| (.+) \| (.*\{.+) \| (\w+); (.+) \|$", re.MULTILINE)
CELL = re.compile(r"\{(.+?)(:%)?\}")


def make_headline_page(reports: Reports, template: str | None = None) -> str:
    """Return the page of headline figures.

    A figure is taken from the first row with the given values of the tables whose title begins as
    given; `{column:%}` is a share. Raise LookupError for one that the reports do not have.
    """

    def with_cells(match: re.Match[str]) -> str:
        what, text, name, place = match.groups()
        title, *values = place.split("; ")
        row = _find_row(reports[name], title, dict(value.split(" = ", 1) for value in values))
        text = CELL.sub(lambda cell: _format(row[cell[1]], is_share=bool(cell[2])), text)
        return f"| {what} | {text} | {name} |"

    return ROW.sub(with_cells, template or TEMPLATE.read_text(encoding="utf-8"))


def _find_row(report: Mapping[str, object], title: str, values: Mapping[str, str]) -> Row:
    for table in cast(Sequence[Mapping[str, object]], report["tables"]):
        if str(table["title"]).startswith(title):
            for row in cast(Sequence[Row], table["rows"]):
                if all(shown(row.get(column)) == value for column, value in values.items()):
                    return row
    raise LookupError(f"{report['benchmark']} has no row with {values} in a table {title!r}")


def _format(cell: Cell, *, is_share: bool) -> str:
    return f"{100 * cast(float, cell):.1f} %" if is_share else shown(cell)


def make_tables_page(reports: Reports, questions: Mapping[str, str]) -> str:
    """Return the page with all tables; `questions` are what each benchmark answers."""
    lines = ["# All tables of the benchmarks", ""]
    for name, report in reports.items():
        lines.extend(_section(questions.get(name, ""), report))
    return "\n".join(lines)


def _section(question: str, report: Mapping[str, object]) -> Iterator[str]:
    yield from (f"## {report['benchmark']}", "", question, "")
    for table in cast(Sequence[Mapping[str, object]], report["tables"]):
        rows = cast(Sequence[Row], table["rows"])
        yield from (f"**{table['title']}**", "", *_table(rows), "")
    settings = cast(Mapping[str, Cell], report["settings"])
    machine = cast(Mapping[str, Cell], report["machine"])
    yield from (*cast(Sequence[str], report["notes"]), "")
    yield f"Settings: {_pairs(settings)}. Machine: {_pairs(machine)}. Code: {report['code']}."
    yield ""


def _pairs(values: Mapping[str, Cell]) -> str:
    return ", ".join(f"{key} {shown(value)}" for key, value in values.items())


def _table(rows: Sequence[Row]) -> Iterator[str]:
    for cells in (rows[0], ["---"] * len(rows[0]), *(map(shown, row.values()) for row in rows)):
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"
