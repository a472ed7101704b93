"""`facetlog model check`: report all faults of model files, each with its place and the way out."""

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.files import Files, is_stdin, model_files, read_stdin
from facetlog.commands.model.watch import Ran, Watch, watched
from facetlog.commands.shared import NO, YES, command
from facetlog.errors import InputError
from facetlog.perception.atomic_write import write_atomically
from facetlog.plurals import many
from facetlog.terminal import note

if TYPE_CHECKING:
    from facetlog.grammar.analysis import Analysis
    from facetlog.grammar.faults import Fault
    from facetlog.grammar.syntax import File

__all__ = ["analysed", "check_command", "checked"]


class Output(StrEnum):
    """Formats of the report."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    JUNIT = "junit"


@command
def check_command(
    files: Files,
    output: Annotated[
        Output,
        typer.Option(
            "--output",
            help="Format: text, json, sarif (for code hosts) or junit (for build servers).",
        ),
    ] = Output.TEXT,
    warnings_as_errors: Annotated[
        bool, typer.Option("--warnings-as-errors", help="Exit with 1 for warnings, too.")
    ] = False,
    fix: Annotated[
        bool, typer.Option("--fix", help="First apply sure fixes to the files.")
    ] = False,
    limits: Annotated[
        bool,
        typer.Option("--limits", help="Also list each limit with the range over which it fades."),
    ] = False,
    watch: Watch = False,
) -> int:
    """Check model files and report all faults.

    Exit code 0: no errors, 1: there are some, 2: a file cannot be read.
    """
    if fix and watch:
        raise InputError("--fix without --watch: files that are being edited are not rewritten")
    if fix:
        _fix_files(model_files(files))
    if limits and output is not Output.TEXT:
        raise InputError(f"--limits is for readers: leave out --output {output.value}")
    run = partial(_check, files, output, warnings_as_errors=warnings_as_errors, limits=limits)
    return watched(run, partial(model_files, files), watch=watch)


def _check(arguments: list[str], output: Output, *, warnings_as_errors: bool, limits: bool) -> Ran:
    from facetlog.commands.model.fault_text import count_errors, distinct
    from facetlog.grammar.checking.same_names import SameNames
    from facetlog.grammar.library import read_text

    paths = model_files(arguments)
    same_names = SameNames(read_text, paths)
    used: set[Path] = set()
    read: dict[str, File] = {}
    found: list[Fault] = []
    shown: list[str] = []
    for path in paths:
        analysis, faults = checked(path)
        used |= {*analysis.library.files, *analysis.library.words}
        read |= {str(name): file for name, file in analysis.library.files.items()}
        found.extend((*faults, *same_names.faults(analysis)))
        if limits:
            shown += _list_limits(analysis)
    faults = distinct(found)
    typer.echo(_format_faults(output, paths, faults, read, warnings_as_errors=warnings_as_errors))
    for line in shown:
        typer.echo(line)
    if any(fault.code == "unreadable" for fault in faults):
        return Ran(InputError.exit_code, frozenset(used))
    bad = len(faults) if warnings_as_errors else count_errors(faults)
    return Ran(NO if bad else YES, frozenset(used))


def _fix_files(paths: Sequence[Path]) -> None:
    """Rewrite each file that has a sure fix, and report what was done.

    Raise InputError for standard input, and for a file that cannot be written.
    """
    from facetlog.grammar.fix_all import fixed

    if any(map(is_stdin, paths)):
        raise InputError("--fix needs files: what is read from standard input cannot be put right")
    for path in paths:
        before = analysed(path)
        if any(fault.code == "unreadable" for fault in before.faults):
            continue  # the check tells it
        found = fixed(before.file.source.text, partial(_find_faults, path))
        if found.text == before.file.source.text:
            continue
        write_atomically(path, found.text.encode())
        for one in found.done:
            note(f"{path}:{one.line}:{one.column}: {one.title} [{one.code}]")
        note(f"{path}: {many(len(found.done), 'fault')} put right")


def _find_faults(path: Path, text: str) -> "tuple[Fault, ...]":
    return checked(path, text)[1]


def _list_limits(analysis: "Analysis") -> Iterator[str]:
    from facetlog.commands.model.fault_text import plain
    from facetlog.grammar.limits import limits

    return (plain(str(limit)) for limit in limits(analysis))


def _format_faults(
    output: Output,
    paths: Sequence[Path],
    faults: "Sequence[Fault]",
    read: "Mapping[str, File]",
    *,
    warnings_as_errors: bool,
) -> str:
    """Format the faults for an output; what writes the others is not loaded."""
    match output:
        case Output.TEXT:
            from facetlog.commands.model.fault_text import format_faults_text

            return format_faults_text(paths, faults)
        case Output.JSON:
            from facetlog.commands.model.fault_text import format_faults_json

            return format_faults_json(paths, faults)
        case Output.SARIF:
            from facetlog.commands.model.fault_reports import format_faults_sarif

            return format_faults_sarif(paths, faults)
        case Output.JUNIT:
            from facetlog.commands.model.fault_reports import format_faults_junit

            return format_faults_junit(
                paths, faults, read=read, warnings_as_errors=warnings_as_errors
            )


def analysed(path: Path, text: str | None = None) -> "Analysis":
    """Analyse a model file or standard input; `text` replaces the file's own."""
    from facetlog.grammar.analysis import analyse

    return analyse(path, read_stdin() if is_stdin(path) else text)


def checked(path: Path, text: str | None = None) -> "tuple[Analysis, tuple[Fault, ...]]":
    """Analyse a model file; return its faults with those of the scenes that its examples build.

    `text` replaces the file's own.
    """
    from facetlog.grammar import syntax as s
    from facetlog.grammar.example_scenes import find_all_faults, list_examples

    analysis = analysed(path, text)
    faults = analysis.faults
    if any(isinstance(example.scene, s.SceneBuilt) for _, example in list_examples(analysis)):
        from facetlog.commands.model.scenes import list_builder_sizes

        faults = find_all_faults(analysis, list_builder_sizes())
    return analysis, faults
