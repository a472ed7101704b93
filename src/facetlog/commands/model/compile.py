"""`facetlog model compile`: translate a model file, and show the forms in between."""

from collections.abc import Callable, Iterator
from dataclasses import fields
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.check import analysed
from facetlog.commands.model.fault_text import plain
from facetlog.commands.model.files import model_files
from facetlog.commands.shared import NO, YES, Overwrite, command
from facetlog.errors import InputError
from facetlog.output_file import check_output_file
from facetlog.perception.atomic_write import write_atomically

if TYPE_CHECKING:
    from facetlog.grammar.analysis import Analysis
    from facetlog.grammar.source import Source
    from facetlog.grammar.traversal import Node

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
        str, typer.Argument(metavar="FILE", help="Model file, or - for standard input.")
    ],
    emit: Annotated[
        Emit,
        typer.Option(
            "--emit",
            help="Output: parse tree, abstract syntax tree, clauses, or a whole Prolog rule file.",
        ),
    ] = Emit.PROLOG,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", metavar="FILE", help="File to write (default: standard output)."
        ),
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Translate a model file into Prolog.

    Exit code 0: done, 1: the file has faults, which are listed (trees are still printed).
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
        write_atomically(out, text.encode())
    return NO if faulty else YES


def _format_tree(analysis: "Analysis") -> str:
    from facetlog.grammar.reading.parse import iter_statement_trees

    return "".join(tree.pretty() for tree in iter_statement_trees(analysis.file.source))


def _format_ast(analysis: "Analysis") -> str:
    """Return a line for each node of the syntax tree: its kind, place and plain values."""
    file = analysis.file
    nodes = (*file.statements, *file.models)
    lines = (line for node in nodes for line in _list_nodes(node, file.source, 0, ""))
    return "".join(f"{line}\n" for line in lines)


def _list_nodes(node: "Node", source: "Source", depth: int, role: str) -> Iterator[str]:
    line, column = source.get_line_and_column(node.span.start)
    values: list[str] = []
    inner: list[tuple[str, Node]] = []
    for field in fields(node):
        value = getattr(node, field.name)
        if field.name == "span" or value is None or value is False or value == ():
            continue
        many = value if isinstance(value, tuple) else (value,)
        if all(hasattr(one, "span") for one in many):
            inner.extend((field.name, one) for one in many)
        else:
            shown = value.value if isinstance(value, StrEnum) else value
            values.append(f"{field.name}={shown!r}")
    head = f"{role}: " if role else ""
    shown_values = f" {' '.join(values)}" if values else ""
    yield f"{'  ' * depth}{head}{type(node).__name__} {line}:{column}{shown_values}"
    for name, one in inner:
        yield from _list_nodes(one, source, depth + 1, name)


def _format_clauses(analysis: "Analysis") -> str:
    from facetlog.grammar.compile import compiled

    return "".join(f"{clause}\n" for clause in compiled(analysis).clauses)


def _format_prolog(analysis: "Analysis") -> str:
    from facetlog.grammar.compile import compiled

    return compiled(analysis).prolog


_FORMS: dict[Emit, "Callable[[Analysis], str]"] = {
    Emit.TREE: _format_tree,
    Emit.AST: _format_ast,
    Emit.CLAUSES: _format_clauses,
    Emit.PROLOG: _format_prolog,
}
