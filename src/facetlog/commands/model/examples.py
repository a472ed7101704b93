"""`facetlog model test`: the examples of models, and scenes with labels."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.check import checked
from facetlog.commands.model.files import Files, is_stdin, model_files
from facetlog.commands.model.watch import Ran, Watch, watched
from facetlog.commands.shared import NO, YES, Trust, command
from facetlog.errors import InputError

if TYPE_CHECKING:
    from facetlog.grammar.analysis import Analysis
    from facetlog.grammar.faults import Fault
    from facetlog.kb.examples import CaseResult

__all__ = ["examples_command"]


class Output(StrEnum):
    """How results are reported."""

    TEXT = "text"
    JSON = "json"


@command
def examples_command(
    files: Files,
    coverage: Annotated[
        bool,
        typer.Option(
            "--coverage",
            help="Which lines decided verdicts, and the least change that would turn each.",
        ),
    ] = False,
    scenes: Annotated[
        Path | None,
        typer.Option(
            "--scenes",
            metavar="CSV",
            help="More scenes, with labels: scene,thing,model,expected in the first line.",
        ),
    ] = None,
    trust: Trust = False,
    output: Annotated[Output, typer.Option("--output", help="For readers or for programs.")] = (
        Output.TEXT
    ),
    watch: Watch = False,
) -> int:
    """Runs the examples of models.

    Exit code 0: all is as expected, 1: something is not, or a file has faults, 2: one cannot be
    read.
    """
    run = partial(_test, files, scenes, output, coverage=coverage, trust=trust)
    return watched(run, partial(_named, files, scenes), watch=watch)


def _named(arguments: list[str], scenes: Path | None) -> tuple[Path, ...]:
    return (*model_files(arguments), *(() if scenes is None else (scenes,)))


@dataclass(frozen=True, slots=True)
class Tested:
    """What came of a run: faults that kept files from being tested, and the results of the rest."""

    analyses: "tuple[Analysis, ...]"
    faults: "tuple[Fault, ...]"
    results: "tuple[CaseResult, ...]"

    @property
    def passed(self) -> bool:
        """Whether nothing was wrong."""
        return not self.faults and all(result.passed for result in self.results)


def _test(
    arguments: list[str], scenes: Path | None, output: Output, *, coverage: bool, trust: bool
) -> Ran:
    from facetlog.commands.model.example_report import tested_json, tested_text

    paths = model_files(arguments)
    if any(map(is_stdin, paths)):
        raise InputError("standard input cannot be tested: give a file, for its scenes' sake")
    tested, used = _tested(paths, scenes, trust=trust)
    write = tested_json if output is Output.JSON else tested_text
    typer.echo(write(tested, coverage=coverage))
    if any(fault.code == "unreadable" for fault in tested.faults):
        return Ran(InputError.exit_code, used)
    return Ran(YES if tested.passed else NO, used)


def _tested(
    paths: Iterable[Path], scenes: Path | None, *, trust: bool
) -> tuple[Tested, frozenset[Path]]:
    from facetlog.commands.model.fault_text import distinct
    from facetlog.commands.model.scenes import (
        example_facts,
        example_on_demand,
        labelled_facts,
        labelled_on_demand,
    )
    from facetlog.grammar.faults import Severity
    from facetlog.kb.examples import example_cases, run_cases
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.kb.labelled_scenes import labelled_cases

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
        case for one in analyses for case in example_cases(one, example_facts, example_on_demand)
    ]
    with KnowledgeBase() as base:
        for analysis in analyses:
            base.load_rules(Path(analysis.file.source.name), trusted=trust)
        if scenes is not None:
            cases += labelled_cases(
                scenes, labelled_facts, known=base.models, on_demand=labelled_on_demand
            )
            used.add(scenes)
        results = {result.case: result for result in run_cases(base, cases)}
    used |= {Path(case.scene) for case in cases if Path(case.scene).is_file()}
    ordered = tuple(results[case] for case in cases)
    return Tested(tuple(analyses), distinct(faults), ordered), frozenset(used)
