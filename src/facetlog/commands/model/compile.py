"""`facetlog model compile`: a model file in each of the forms that it goes through."""

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.check import analysed
from facetlog.commands.model.fault_text import plain
from facetlog.commands.model.files import model_files
from facetlog.commands.model.in_place import write_text
from facetlog.commands.shared import NO, YES, command
from facetlog.errors import InputError

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
    if out is not None and out.resolve() in {path.resolve() for path in used}:
        raise InputError(f"{out} is what it is compiled from: give another name with -o")
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
        write_text(out, text)
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
