"""`facetlog model test`: test models by their examples and by labelled scenes."""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
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
from facetlog.commands.shape_options import Scale, StatedOptions
from facetlog.commands.shared import NO, YES, AsJson, Trust, command
from facetlog.errors import InputError
from facetlog.plurals import many
from facetlog.terminal import note

if TYPE_CHECKING:
    from rich.table import Table

    from facetlog.commands.model.scenes import ExampleScenes
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
    stated: StatedOptions,
    scale: Scale = None,
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
            metavar="PATH",
            help="Also test labelled scenes and meshes: a table (first line: "
            "file,model,expected), or a folder with expected.csv or with files named MODEL+… "
            "(should hold) and MODEL-… (should fail).",
        ),
    ] = None,
    trust: Trust = False,
    output: Annotated[Output, typer.Option("--output", help="Format: text or json.")] = (
        Output.TEXT
    ),
    as_json: AsJson = False,
    watch: Watch = False,
) -> int:
    """Run the examples of models, and judge labelled scenes and meshes.

    A folder may hold models, labelled files as for --scenes, or both; beside arguments that name
    models one of labelled files names none. --up, --unit, --scale and
    --sensor state what labelled files do not. Exit code 0: all is as expected, 1: something is
    not, or a file has faults, 2: one cannot be read.
    """
    from facetlog.commands.model.scenes import ExampleScenes

    test = partial(_test_files, files, scenes, partial(ExampleScenes, stated, scale, trusted=trust))
    write = _format_json if as_json or output is Output.JSON else _format_text

    def run() -> Ran:
        tested, used = test()
        typer.echo(write(tested, coverage=coverage))
        for line in tested.hints:
            note(line)
        if any(fault.code == "unreadable" for fault in tested.faults):
            return Ran(InputError.exit_code, used)
        return Ran(YES if tested.passed else NO, used)

    return watched(run, partial(_list_files, files, scenes), watch=watch)


def _list_files(arguments: list[str], scenes: Path | None) -> tuple[Path, ...]:
    models, labelled = _split_arguments(arguments)
    return (*models, *labelled, *(() if scenes is None else (scenes,)))


def _split_arguments(arguments: list[str]) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Return the model files, and the folders of labelled files, that arguments name."""
    from facetlog.kb.labelled_scenes import is_labelled_folder
    from facetlog.perception.shapes.shape_options import SUFFIXES

    labelled = [argument for argument in arguments if is_labelled_folder(Path(argument), SUFFIXES)]
    # A folder of labelled files is one of models as well only where nothing else names any.
    named = [argument for argument in arguments if argument not in labelled] or [
        argument for argument in labelled if any(Path(argument).glob("**/*.model"))
    ]
    if not named:
        raise InputError(f"{labelled[0]}: the folder has no models: name them before it")
    return model_files(named), tuple(map(Path, dict.fromkeys(labelled)))


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

    @property
    def labelled(self) -> "tuple[CaseResult, ...]":
        """Results of labelled files."""
        return tuple(result for result in self.results if result.case.is_labelled)


def _test_files(
    arguments: list[str], table: Path | None, open_scenes: "Callable[[], ExampleScenes]"
) -> tuple[Tested, frozenset[Path]]:
    from facetlog.commands.model.fault_text import distinct
    from facetlog.grammar.faults import Severity
    from facetlog.kb.examples import list_example_cases, run_cases
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.kb.labelled_scenes import read_labelled_cases
    from facetlog.kb.overlaps import Overlaps, list_stated_orders
    from facetlog.perception.shapes.shape_options import SUFFIXES

    paths, labelled = _split_arguments(arguments)
    if any(map(is_stdin, paths)):
        raise InputError("standard input cannot be tested: give a file, for its scenes' sake")
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
    scenes = open_scenes()
    cases = [
        case
        for one in analyses
        for case in list_example_cases(one, scenes.make_facts, scenes.make_on_demand)
    ]
    with KnowledgeBase() as base:
        for analysis in analyses:
            base.load_rules(Path(analysis.file.source.name), trusted=scenes.trusted)
        for source in (*labelled, *(() if table is None else (table,))):
            cases += read_labelled_cases(
                source,
                scenes.read_facts,
                known=base.models,
                on_demand=scenes.read_on_demand,
                suffixes=SUFFIXES,
            )
            used.add(source)
        overlaps = Overlaps(list_stated_orders(analyses))
        results = {result.case: result for result in run_cases(base, cases, overlaps)}
    used |= {case.file for case in cases if case.file is not None and case.file.is_file()}
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
        if result.case.is_labelled:
            lines.append(result.line)
        elif not result.passed:
            lines.extend(result.lines())
    if tested.labelled:
        lines += ["", *_format_counts(tested), ""]
    if coverage:
        for model in _find_coverage(tested):
            lines.extend(_format_coverage(model))
        lines.extend(_format_margins(tested))
    lines.append(_summarize(tested))
    return "\n".join(map(plain, lines))


def _count_labelled(tested: Tested) -> dict[tuple[str, str], Counter[str]]:
    """Return how often each state came out, by the model and the state that was expected."""
    found: dict[tuple[str, str], Counter[str]] = {}
    for result in tested.labelled:
        case = result.case
        states = found.setdefault((case.model, case.expected.state.value), Counter())
        states[result.verdict.state.value if result.verdict else "error"] += 1
    return found


def _format_counts(tested: Tested) -> Iterable[str]:
    from rich.table import Table

    columns = ("holds", "fails", "unknown", "error")
    table = Table("model", "expected", "files", *columns, box=None, pad_edge=False)
    for (model, expected), states in _count_labelled(tested).items():
        counts = (str(states[column]) for column in columns)
        table.add_row(model, expected, str(states.total()), *counts)
    return _render_table(table)


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
    if tested.labelled:
        data["labelled"] = [
            {"model": model, "expected": expected, **states}
            for (model, expected), states in _count_labelled(tested).items()
        ]
    if coverage:
        data["coverage"] = [model.to_json() for model in _find_coverage(tested)]
    return json.dumps(data, indent=1)
