"""`facetlog model format`: lay out model files."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.model.fault_text import plain
from facetlog.commands.model.files import Files, is_stdin, model_files, read_stdin
from facetlog.commands.model.watch import Ran, Watch, watched
from facetlog.commands.shared import NO, YES, command
from facetlog.errors import InputError
from facetlog.perception.atomic_write import write_atomically
from facetlog.plurals import many
from facetlog.terminal import error, fit_on_one_line, note

__all__ = ["format_command"]


@command
def format_command(
    files: Files,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; list the files that would change.")
    ] = False,
    diff: Annotated[
        bool, typer.Option("--diff", help="Write nothing; show the changes as a diff.")
    ] = False,
    watch: Watch = False,
) -> int:
    """Lay out model files; standard input goes to standard output.

    Exit code 0: done, 1: a file would change, or has faults and is left unchanged, 2: a file cannot
    be read or written.
    """
    if watch and not check:
        raise InputError("--watch needs --check: files that are being edited are not rewritten")
    run = partial(_format_all, files, check=check, diff=diff)
    return watched(run, partial(model_files, files), watch=watch)


def _format_all(arguments: list[str], *, check: bool, diff: bool) -> Ran:
    paths = model_files(arguments)
    codes = [_format_file(path, check=check, diff=diff) for path in paths]
    return Ran(max(codes), frozenset(paths))


def _format_file(path: Path, *, check: bool, diff: bool) -> int:
    """Lay out one file and return the exit code."""
    from facetlog.grammar.faults import Severity
    from facetlog.grammar.format import differences, formatted
    from facetlog.grammar.reading.parse import parse
    from facetlog.grammar.source import Source

    try:
        before = read_stdin() if is_stdin(path) else _read_model(path)
    except InputError as exc:
        error(str(exc))
        return exc.exit_code
    source = Source(str(path), before)
    faults = [fault for fault in parse(source).faults if fault.severity is Severity.ERROR]
    if faults:
        said = f"{many(len(faults), 'fault')}, the first at {faults[0].place}"
        note(f"{path} is left as it is: it has {said}: {faults[0].message}")
        if is_stdin(path) and not (check or diff):
            typer.echo(before, nl=False)
        return NO
    after = formatted(source)
    if diff:
        for line in differences(before, after, str(path)).splitlines():
            typer.echo(plain(line))
    if check and before != after:
        note(f"{path} is not in canonical layout") if diff else typer.echo(
            fit_on_one_line(str(path))
        )
    if check or diff:
        return YES if before == after else NO
    if is_stdin(path):
        typer.echo(after, nl=False)
    elif before != after:
        write_atomically(path, after.encode())
        note(f"{path} is reformatted")
    return YES


def _read_model(path: Path) -> str:
    from facetlog.grammar.library import read_text

    try:
        return read_text(path)
    except (OSError, ValueError) as exc:
        raise InputError(f"{path} cannot be read: {getattr(exc, 'strerror', None) or exc}") from exc
