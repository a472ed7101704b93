"""`facetlog model compile`: a model file in each of the forms that it goes through."""

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.check import analysed
from facetlog.commands.model.fault_text import plain
from facetlog.commands.model.files import model_files
from facetlog.commands.shared import NO, YES, command
from facetlog.errors import InputError
from facetlog.output_file import Overwrite, check_output_file
from facetlog.perception.atomic_write import write_whole

if TYPE_CHECKING:
    from facetlog.grammar.analysis import Analysis

__all__ = ["compile_command"]


class Emit(StrEnum):
    """The forms of a model file, in the order in which they are made."""

    TREE = "tree"
    AST = "ast"
    CLAUSES = "clauses"
    PROLOG = "prolog"


@command
def compile_command(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A model file; - reads standard input.")
    ],
    emit: Annotated[
        Emit,
        typer.Option(
            "--emit", help="Parse tree, syntax tree, clauses, or the whole Prolog rule file."
        ),
    ] = Emit.PROLOG,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Where to; standard output if not given."),
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Translates a model file into Prolog.

    Exit code 0: done, 1: the file has faults, which are listed; trees are shown as far as they go.
    """
    paths = model_files([file])
    if len(paths) != 1:
        raise InputError(f"{file} names {len(paths)} files: give one")
    analysis = analysed(paths[0])
    if any(fault.code == "unreadable" for fault in analysis.faults):
        raise InputError(f"{paths[0]}: {analysis.faults[0].message}")
    used = {*analysis.library.files, *analysis.library.words}
    if out is not None:
        check_output_file(out, "-o", used, overwrite=overwrite)
    faulty = bool(analysis.errors)
    for fault in analysis.faults:
        for line in fault.lines():
            typer.echo(plain(line), err=True)
    if faulty and emit in (Emit.CLAUSES, Emit.PROLOG):
        return NO
    text = _FORMS[emit](analysis)
    if out is None:
        typer.echo(text, nl=False)
    else:
        write_whole(out, text.encode())
    return NO if faulty else YES


def _tree(analysis: "Analysis") -> str:
    from facetlog.grammar.reading.parse import statement_trees

    return "".join(tree.pretty() for tree in statement_trees(analysis.file.source))


def _ast(analysis: "Analysis") -> str:
    from facetlog.commands.model.outline import outline

    return "".join(f"{line}\n" for line in outline(analysis.file))


def _clauses(analysis: "Analysis") -> str:
    from facetlog.grammar.compile import compiled

    return "".join(f"{clause}\n" for clause in compiled(analysis).clauses)


def _prolog(analysis: "Analysis") -> str:
    from facetlog.grammar.compile import compiled

    return compiled(analysis).prolog


_FORMS: dict[Emit, "Callable[[Analysis], str]"] = {
    Emit.TREE: _tree,
    Emit.AST: _ast,
    Emit.CLAUSES: _clauses,
    Emit.PROLOG: _prolog,
}
