"""Checked models into Prolog: clauses that name the line that they were made from.

The clauses are those of models written in Prolog (docs/model-reference.md); the knowledge base
checks and loads them like any other rule file.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from facetlog.errors import RuleSyntaxError
from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.compiling.joins import write_candidate_clauses
from facetlog.grammar.compiling.lines import write_line_clauses
from facetlog.grammar.compiling.tests import Writer, WriterOf
from facetlog.grammar.compiling.writer import set_shapes
from facetlog.grammar.library import BUILTIN
from facetlog.grammar.resolve import FlatModel
from facetlog.grammar.scope import Scope
from facetlog.grammar.terms import Atom, Clause, Struct, Text
from facetlog.grammar.traversal import walk
from facetlog.plain_text import plain_text

_DIRECTIVE = re.compile(r"^:-[^.]*\.[ \t]*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Program:
    """The Prolog program of a model file.

    `needs` are the other model files, besides the built-in ones, whose models these ask about: they
    must be loaded too. `own_words` are the Prolog files with words of the user's own, whose clauses
    the text includes.
    """

    module: str
    models: tuple[str, ...]
    clauses: tuple[Clause, ...]
    needs: tuple[Path, ...]
    own_words: tuple[tuple[str, str], ...]

    @property
    def prolog(self) -> str:
        """The text of a rule file."""
        head = [f":- module({Atom(self.module)}, []).", ":- use_module(facetlog(vocabulary))."]
        pieces = ["\n".join(head)]
        last = ""
        for clause in self.clauses:
            kind = clause.head.functor
            if kind != last and last:
                pieces.append("")
            pieces.append(str(clause))
            last = kind
        for name, text in self.own_words:
            # Line for line, so that a fault names its place.
            heading = name.replace("\n", " ")
            pieces.append(f"\n% {heading}\n{_DIRECTIVE.sub('', text).rstrip()}")
        return plain_text("\n".join(pieces) + "\n")


def compiled(analysis: Analysis) -> Program:
    """Return the program of a file's models.

    Raise RuleSyntaxError, with all faults, if the file has errors.
    """
    if analysis.errors:
        text = "\n".join(
            f"{f.place}: {f.message}" + f"; {f.hint}" * bool(f.hint) for f in analysis.errors
        )
        raise RuleSyntaxError(text)
    clauses: list[Clause] = []
    for name in analysis.models:
        clauses += _compile_model(analysis.scopes[name])
    clauses = _group_by_predicate(clauses)
    path = Path(analysis.file.source.name)
    words = tuple((used.name, own.source.text) for used, own in analysis.library.words.items())
    module = path.stem if path.suffix == ".model" else "models"
    return Program(module, tuple(analysis.models), tuple(clauses), _find_needs(analysis), words)


def _group_by_predicate(clauses: list[Clause]) -> list[Clause]:
    """Return clauses with those of one predicate together, otherwise in the order of making."""
    order: dict[tuple[str, int], list[Clause]] = {}
    for clause in clauses:
        order.setdefault((clause.head.functor, len(clause.head.args)), []).append(clause)
    return [clause for some in order.values() for clause in some]


def _find_needs(analysis: Analysis) -> tuple[Path, ...]:
    """Return the files of the models that this file's models ask about, and that are not built
    in."""
    files = {
        model.name.text: path
        for path, file in analysis.library.files.items()
        for model in file.models
    }
    referred = {
        name for model in analysis.models for name in _iter_referred(analysis.scopes[model])
    }
    found = {files[name] for name in referred if name in files and name not in analysis.models}
    return tuple(sorted(path for path in found if path.parent != BUILTIN))


def _iter_referred(scope: Scope) -> Iterator[str]:
    for symbol in scope.symbols.values():
        if symbol.model:
            yield symbol.model
    for _, owned in scope.model.lines:
        for node in walk(owned.node):
            if isinstance(node, s.Property) and node.name.text in scope.roles:
                yield node.name.text


def _place(model: FlatModel, offset: int) -> str:
    source = model.source
    return f"{Path(source.name).name}:{source.get_line_and_column(offset)[0]}"


def _compile_model(scope: Scope) -> list[Clause]:
    model = scope.model
    name = Atom(model.name)
    shapes = set_shapes(scope)
    writer_of: WriterOf = partial(Writer, scope, shapes)
    doc = model.written.doc.value if model.written.doc else ""
    place = _place(model, model.written.name.span.start)
    roles = tuple(Atom(part.name) for part in scope.singular)
    clauses = [Clause(Struct("model", (name, Text(doc), roles)), (), place)]
    clauses += [
        Clause(Struct("specialises", (name, Atom(ancestor))), (), place)
        for ancestor in model.ancestors
    ]
    clauses += [
        Clause(Struct("rather_than", (name, Atom(other.text))), (), place)
        for other in model.written.rather_than
    ]
    first = model.parts[0]
    where = f"{Path(first.place[0]).name}:{first.place[1]}"
    clauses += write_candidate_clauses(scope, writer_of, where, "parts")
    clauses += write_line_clauses(scope, shapes, writer_of)
    return clauses
