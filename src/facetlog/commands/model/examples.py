"""`facetlog model test`: test models by their examples and by labelled scenes."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog import __version__
from facetlog.commands.model.check import checked
from facetlog.commands.model.fault_text import list_faults, plain
from facetlog.commands.model.files import Files, is_stdin, model_files
from facetlog.commands.model.watch import Ran, Watch, watched
from facetlog.commands.shared import NO, YES, Trust, command
from facetlog.errors import InputError
from facetlog.plurals import many
from facetlog.terminal import note

if TYPE_CHECKING:
    from rich.table import Table

    from facetlog.grammar.analysis import Analysis
    from facetlog.grammar.faults import Fault
    from facetlog.kb.coverage import ModelCoverage
    from facetlog.kb.examples import CaseResult

__all__ = ["examples_command"]

SCHEMA = "facetlog-model-test/1"

WIDEST = 200
"""Columns of a table: what does not fit a terminal wraps there."""


class Output(StrEnum):
    """Formats of the report."""

    TEXT = "text"
    JSON = "json"


@command
def examples_command(
    files: Files,
    coverage: Annotated[
        bool,
        typer.Option(
            "--coverage",
            help="Also show which lines decided verdicts, and the least change that turns each.",
        ),
    ] = False,
    scenes: Annotated[
        Path | None,
        typer.Option(
            "--scenes",
            metavar="CSV",
            help="Also test labelled scenes; first line of CSV: scene,thing,model,expected.",
        ),
    ] = None,
    trust: Trust = False,
    output: Annotated[Output, typer.Option("--output", help="Format: text or json.")] = (
        Output.TEXT
    ),
    watch: Watch = False,
) -> int:
    """Run the examples of models.

    Exit code 0: all is as expected, 1: something is not, or a file has faults, 2: one cannot be
    read.
    """
    run = partial(_run_tests, files, scenes, output, coverage=coverage, trust=trust)
    return watched(run, partial(_list_files, files, scenes), watch=watch)


def _list_files(arguments: list[str], scenes: Path | None) -> tuple[Path, ...]:
    return (*model_files(arguments), *(() if scenes is None else (scenes,)))


@dataclass(frozen=True, slots=True)
class Tested:
    """Results of a run, with the faults that kept files from being tested; `hints` name built-in
    models that hold wherever one of these does."""

    analyses: "tuple[Analysis, ...]"
    faults: "tuple[Fault, ...]"
    results: "tuple[CaseResult, ...]"
    hints: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing was wrong."""
        return not self.faults and all(result.passed for result in self.results)


def _run_tests(
    arguments: list[str], scenes: Path | None, output: Output, *, coverage: bool, trust: bool
) -> Ran:
    paths = model_files(arguments)
    if any(map(is_stdin, paths)):
        raise InputError("standard input cannot be tested: give a file, for its scenes' sake")
    tested, used = _test_files(paths, scenes, trust=trust)
    write = _format_json if output is Output.JSON else _format_text
    typer.echo(write(tested, coverage=coverage))
    for line in tested.hints:
        note(line)
    if any(fault.code == "unreadable" for fault in tested.faults):
        return Ran(InputError.exit_code, used)
    return Ran(YES if tested.passed else NO, used)


def _test_files(
    paths: Iterable[Path], scenes: Path | None, *, trust: bool
) -> tuple[Tested, frozenset[Path]]:
    from facetlog.commands.model.fault_text import distinct
    from facetlog.commands.model.scenes import (
        make_example_facts,
        make_example_on_demand,
        read_labelled_facts,
        read_labelled_on_demand,
    )
    from facetlog.grammar.faults import Severity
    from facetlog.kb.examples import list_example_cases, run_cases
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.kb.labelled_scenes import read_labelled_cases
    from facetlog.kb.overlaps import Overlaps, list_stated_orders

    analyses: list[Analysis] = []
    faults: list[Fault] = []
    used: set[Path] = set()
    for path in paths:
        analysis, found = checked(path)
        used |= {*analysis.library.files, *analysis.library.words}
        errors = [fault for fault in found if fault.severity is Severity.ERROR]
        faults += errors
        if not errors and analysis.file.models:
            analyses.append(analysis)
    cases = [
        case
        for one in analyses
        for case in list_example_cases(one, make_example_facts, make_example_on_demand)
    ]
    with KnowledgeBase() as base:
        for analysis in analyses:
            base.load_rules(Path(analysis.file.source.name), trusted=trust)
        if scenes is not None:
            cases += read_labelled_cases(
                scenes, read_labelled_facts, known=base.models, on_demand=read_labelled_on_demand
            )
            used.add(scenes)
        overlaps = Overlaps(list_stated_orders(analyses))
        results = {result.case: result for result in run_cases(base, cases, overlaps)}
    used |= {Path(case.scene) for case in cases if Path(case.scene).is_file()}
    ordered = tuple(results[case] for case in cases)
    hints = tuple(overlaps.iter_lines())
    return Tested(tuple(analyses), distinct(faults), ordered, hints), frozenset(used)


def _list_lines(tested: Tested) -> dict[str, Mapping[str, bool]]:
    """Return the labels of each model's lines, and whether they are only expected."""
    return {
        name: {label: owned.node.expect is not None for label, owned in model.lines}
        for analysis in tested.analyses
        for name, model in analysis.models.items()
    }


def _find_coverage(tested: Tested) -> "tuple[ModelCoverage, ...]":
    from facetlog.kb.coverage import coverage

    verdicts = [result.verdict for result in tested.results if result.verdict is not None]
    return coverage(verdicts, _list_lines(tested))


def _format_text(tested: Tested, *, coverage: bool) -> str:
    """Format faults, what is not as expected and why, with `coverage` its tables, and a summary."""
    lines: list[str] = []
    for fault in tested.faults:
        lines.extend(fault.lines())
    for result in tested.results:
        if not result.passed:
            lines.extend(result.lines())
    if coverage:
        for model in _find_coverage(tested):
            lines.extend(_format_coverage(model))
        lines.extend(_format_margins(tested))
    lines.append(_summarize(tested))
    return "\n".join(map(plain, lines))


def _summarize(tested: Tested) -> str:
    passed = sum(result.passed for result in tested.results)
    failed = len(tested.results) - passed
    said = f"{many(len(tested.results), 'example')}, {passed} passed, {failed} failed"
    if tested.faults:
        said += f"; {many(len(tested.faults), 'fault')} kept files from being tested"
    return said


def _format_coverage(model: "ModelCoverage") -> Iterator[str]:
    yield ""
    states = f"{model.held} held, {model.failed} failed, {model.unknown} unknown"
    yield f"{model.model}: {many(model.verdicts, 'verdict')}: {states}"
    from rich.table import Table

    table = Table("line", box=None, pad_edge=False)
    for column in ("held", "failed", "unknown", "alone decided"):
        table.add_column(column, justify="right")
    for line in model.lines:
        decided = "expected only" if line.expected else str(line.decided)
        table.add_row(line.label, str(line.held), str(line.failed), str(line.unknown), decided)
    yield from _render_table(table)
    if model.idle:
        yield f"never decided: {', '.join(model.idle)}"


def _format_margins(tested: Tested) -> Iterator[str]:
    from rich.table import Table

    from facetlog.kb.explaining.margins import margin

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
        yield from _render_table(table)
        yield ""


def _render_table(table: "Table") -> Iterable[str]:
    from rich.console import Console

    text = StringIO()
    # Titles are an author's: nothing in them is markup.
    Console(file=text, width=WIDEST, markup=False, emoji=False, highlight=False).print(table)
    return (line.rstrip() for line in text.getvalue().splitlines())


def _format_json(tested: Tested, *, coverage: bool) -> str:
    """Format all results as one JSON object."""
    from facetlog.kb.explaining.margins import margin

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
        "faults": list_faults(tested.faults),
        "examples": cases,
    }
    if coverage:
        data["coverage"] = [model.to_json() for model in _find_coverage(tested)]
    return json.dumps(data, indent=1)
