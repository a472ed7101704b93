"""What came of examples and labelled scenes, as text and as JSON."""

import json
from collections.abc import Iterable, Iterator, Mapping
from io import StringIO
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from facetlog import __version__
from facetlog.commands.model.fault_text import counted, faults_data, plain
from facetlog.kb.coverage import ModelCoverage, coverage
from facetlog.kb.explaining.margins import margin

if TYPE_CHECKING:
    from facetlog.commands.model.examples import Tested

__all__ = ["tested_json", "tested_text"]

SCHEMA = "facetlog-model-test/1"

WIDEST = 200
"""Columns of a table: what does not fit a terminal wraps there."""


def _lines_of_models(tested: "Tested") -> dict[str, Mapping[str, bool]]:
    """The labels of each model's lines, and whether they are only expected."""
    return {
        name: {label: owned.node.expect is not None for label, owned in model.lines}
        for analysis in tested.analyses
        for name, model in analysis.models.items()
    }


def _coverage(tested: "Tested") -> tuple[ModelCoverage, ...]:
    verdicts = [result.verdict for result in tested.results if result.verdict is not None]
    return coverage(verdicts, _lines_of_models(tested))


def tested_text(tested: "Tested", *, coverage: bool) -> str:
    """Faults, what is not as expected and why, with `coverage` its tables, then a summary."""
    lines: list[str] = []
    for fault in tested.faults:
        lines.extend(fault.lines())
    for result in tested.results:
        if not result.passed:
            lines.extend(result.lines())
    if coverage:
        for model in _coverage(tested):
            lines.extend(_coverage_lines(model))
        lines.extend(_margin_lines(tested))
    lines.append(_summary(tested))
    return "\n".join(map(plain, lines))


def _summary(tested: "Tested") -> str:
    passed = sum(result.passed for result in tested.results)
    failed = len(tested.results) - passed
    said = f"{counted(len(tested.results), 'example')}, {passed} passed, {failed} failed"
    if tested.faults:
        said += f"; {counted(len(tested.faults), 'fault')} kept files from being tested"
    return said


def _coverage_lines(model: ModelCoverage) -> Iterator[str]:
    yield ""
    states = f"{model.held} held, {model.failed} failed, {model.unknown} unknown"
    yield f"{model.model}: {counted(model.verdicts, 'verdict')}: {states}"
    table = Table("line", box=None, pad_edge=False)
    for column in ("held", "failed", "unknown", "alone decided"):
        table.add_column(column, justify="right")
    for line in model.lines:
        decided = "expected only" if line.expected else str(line.decided)
        table.add_row(line.label, str(line.held), str(line.failed), str(line.unknown), decided)
    yield from _rendered(table)
    if model.idle:
        yield f"never decided: {', '.join(model.idle)}"


def _margin_lines(tested: "Tested") -> Iterator[str]:
    table = Table("model", "example", "verdict", "would be", box=None, pad_edge=False)
    for result in tested.results:
        if result.verdict is None:
            continue
        found = margin(result.verdict)
        turns = "no one value turns it" if found is None else found.text()
        state = result.verdict.state.value
        table.add_row(result.case.model, result.case.title, state, turns)
    if table.row_count:
        yield ""
        yield from _rendered(table)
        yield ""


def _rendered(table: Table) -> Iterable[str]:
    text = StringIO()
    # Titles are an author's: nothing in them is markup.
    Console(file=text, width=WIDEST, markup=False, emoji=False, highlight=False).print(table)
    return (line.rstrip() for line in text.getvalue().splitlines())


def tested_json(tested: "Tested", *, coverage: bool) -> str:
    """The same as one JSON object."""
    passed = sum(result.passed for result in tested.results)
    cases = []
    for result in tested.results:
        found = margin(result.verdict) if coverage and result.verdict else None
        cases.append(
            {**result.to_json(), **({"margin": found and found.to_json()} if coverage else {})}
        )
    data: dict[str, object] = {
        "schema": SCHEMA,
        "facetlog": __version__,
        "passed": passed,
        "failed": len(tested.results) - passed,
        "faults": faults_data(tested.faults),
        "examples": cases,
    }
    if coverage:
        data["coverage"] = [model.to_json() for model in _coverage(tested)]
    return json.dumps(data, indent=1)
