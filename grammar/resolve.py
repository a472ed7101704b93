"""Models with what they inherit: the parts, lines and constants that hold for each."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Generic, TypeVar

from facetlog.grammar import syntax as s
from facetlog.grammar import traversal
from facetlog.grammar.faults import Fault, Fix, make_respelling, said
from facetlog.grammar.source import Source

Node = TypeVar("Node", covariant=True)


LONGEST_DESCENT = 20
"""Models that one may follow from, one from the other."""

ENOUGH = 500
"""Faults of one file, far more than are listed."""


@dataclass(frozen=True, slots=True)
class Owned(Generic[Node]):
    """A statement, the file it stands in, and the model that wrote it (empty: before the first)."""

    node: Node
    file: s.File
    model: str

    @property
    def source(self) -> Source:
        """The text that it stands in."""
        return self.file.source

    @property
    def place(self) -> tuple[str, int]:
        """Name of the file, and line from 1."""
        source = self.file.source
        return source.name, source.get_line_and_column(self.node.span.start)[0]  # type: ignore[attr-defined]


@dataclass(frozen=True, slots=True)
class FlatModel:
    """A model with all that it inherits, ancestors' statements first.

    `lines` have a label each, in the order in which they are explained. `ancestors` are the models
    that it is one of (`is`), the nearest first.
    """

    name: str
    written: s.Model
    file: s.File
    parts: tuple[Owned[s.Part], ...]
    lines: tuple[tuple[str, Owned[s.Line]], ...]
    sizes: tuple[Owned[s.Size], ...]
    lets: Mapping[str, Owned[s.Let]]
    defines: Mapping[str, Owned[s.Define]]
    ancestors: tuple[str, ...]

    @property
    def source(self) -> Source:
        """The text that it is written in."""
        return self.file.source


def line_label(owned: Owned[s.Line]) -> str:
    """Return the label of a line: its own, or its place.

    Two lines of one model never share it.
    """
    if owned.node.label is not None:
        return owned.node.label.text
    return f"line {owned.place[1]}"


def find_reachable(start: str, neighbours: Callable[[str], Iterable[str]]) -> set[str]:
    """Return all that is reached from a name in one step or more."""
    found: set[str] = set()
    waiting = list(neighbours(start))
    while waiting:
        one = waiting.pop()
        if one not in found:
            found.add(one)
            waiting.extend(neighbours(one))
    return found


def flatten_models(files: Iterable[s.File], faults: list[Fault]) -> dict[str, FlatModel]:
    """Return all models of some files by name, with what they inherit; the first of a name counts.

    What cannot be resolved is left out, with a fault.
    """
    return _Resolver(tuple(files), faults).all()


class _Resolver:
    def __init__(self, files: tuple[s.File, ...], faults: list[Fault]) -> None:
        self.faults = faults
        self.written: dict[str, tuple[s.Model, s.File]] = {}
        self.flat: dict[str, FlatModel] = {}
        self.depth: dict[str, int] = {}
        for file in files:
            for model in file.models:
                if model.name.text in self.written:
                    other = self.written[model.name.text][1].source
                    where = f"it is in {other.name} already" if other is not file.source else ""
                    self._fault(
                        "twice",
                        f"the model `{model.name}` is defined twice",
                        model.name,
                        file,
                        where,
                    )
                else:
                    self.written[model.name.text] = model, file

    def all(self) -> dict[str, FlatModel]:
        for name in self.written:
            for one in reversed(self._find_descent(name)):
                if one not in self.flat:
                    self._flatten(one)
        return self.flat

    def _fault(
        self,
        code: str,
        message: str,
        node: traversal.Node,
        file: s.File,
        hint: str = "",
        fixes: tuple[Fix, ...] = (),
    ) -> None:
        if len(self.faults) < ENOUGH:
            self.faults.append(Fault(code, message, file.source, node.span, hint, fixes=fixes))

    def _find_descent(self, name: str) -> list[str]:
        """Return the model, its parent, and so on, as far as they are known and no circle
        closes."""
        line: list[str] = []
        while name in self.written and name not in line and len(line) <= LONGEST_DESCENT:
            line.append(name)
            parent = self.written[name][0].parent
            if parent is None:
                break
            name = parent.text
        return line

    def _flatten(self, name: str) -> None:
        model, file = self.written[name]
        parent = self._find_parent(model, file)
        self.depth[name] = 0 if parent is None else self.depth[parent.name] + 1
        lets = {
            s_.name.text: Owned(s_, file, "") for s_ in file.statements if isinstance(s_, s.Let)
        }
        defines = {
            s_.name.text: Owned(s_, file, "") for s_ in file.statements if isinstance(s_, s.Define)
        }
        parts: list[Owned[s.Part]] = []
        lines: dict[str, Owned[s.Line]] = {}
        sizes: list[Owned[s.Size]] = []
        ancestors: tuple[str, ...] = ()
        strict = model.ancestry is s.Ancestry.IS
        if parent is not None:
            self._report_clashes(file, lets, parent.lets)
            self._report_clashes(file, defines, parent.defines)
            parts, sizes = list(parent.parts), list(parent.sizes)
            lines = dict(parent.lines)
            lets |= parent.lets
            defines |= parent.defines
            if strict:
                ancestors = (parent.name, *parent.ancestors)
        inherited = frozenset(lines), frozenset(n for n in lets if parent and n in parent.lets)
        self._check_others(model, file)
        own: set[str] = set()
        for statement in model.statements:
            match statement:
                case s.Part():
                    parts.append(Owned(statement, file, name))
                case s.Line():
                    self._add_line(Owned(statement, file, name), lines, inherited[0], own, strict)
                case s.Size():
                    # Sizes of one name take the inherited one's place.
                    names = {n.text for n in statement.names}
                    sizes = [z for z in sizes if not names & {n.text for n in z.node.names}]
                    sizes.append(Owned(statement, file, name))
                case s.Let() | s.Define():
                    self._add_named(statement, file, name, lets, defines, inherited[1], own, strict)
                case s.Drop():
                    self._drop(statement, file, lines, parent, strict)
                case _:
                    pass
        self.flat[name] = FlatModel(
            name,
            model,
            file,
            tuple(parts),
            tuple(lines.items()),
            tuple(sizes),
            MappingProxyType(lets),
            MappingProxyType(defines),
            ancestors,
        )

    def _report_clashes(
        self,
        file: s.File,
        own: Mapping[str, Owned[s.Let]] | Mapping[str, Owned[s.Define]],
        inherited: Mapping[str, Owned[s.Let]] | Mapping[str, Owned[s.Define]],
    ) -> None:
        """Report names of this file that inherited lines use for something else."""
        for name, owned in own.items():
            if name in inherited and inherited[name].node is not owned.node:
                message = f"`{name}` is something else in a model that one of this file follows"
                self._fault("taken", message, owned.node.name, file, "choose another name")

    def _find_parent(self, model: s.Model, file: s.File) -> FlatModel | None:
        if model.parent is None:
            return None
        found = self.flat.get(model.parent.text)
        if found is not None and self.depth[found.name] >= LONGEST_DESCENT:
            message = f"`{model.name}` follows from more than {LONGEST_DESCENT} models"
            self._fault("too-deep", message, model.parent, file)
            return None
        if found is None:
            if model.parent.text in self.written:
                # It was left out: it goes round in a circle, or its line is too long.
                if len(self._find_descent(model.parent.text)) > LONGEST_DESCENT:
                    message = f"`{model.name}` follows from more than {LONGEST_DESCENT} models"
                    self._fault("too-deep", message, model.parent, file)
                else:
                    message = f"`{model.name}` follows from itself"
                    self._fault("cycle", message, model.parent, file)
            else:
                self._report_no_model(model.parent, file)
        return found

    def _check_others(self, model: s.Model, file: s.File) -> None:
        """Report what is no model that this one's name can go before."""
        for other in model.rather_than:
            known = self.written.get(other.text)
            if other.text == model.name.text:
                self._fault("cycle", f"`{model.name}` cannot go before itself", other, file)
            elif known is None:
                self._report_no_model(other, file)
            elif model.name.text in find_reachable(other.text, self._find_next):
                message = f"`{other}` goes before `{model.name}`, too"
                self._fault("cycle", message, other, file, "one of them has to stand first")

    def _find_next(self, name: str) -> Iterator[str]:
        """Find the models whose names come right after a model's."""
        if name in self.written:
            model, _ = self.written[name]
            yield from (other.text for other in model.rather_than)
            if model.ancestry is s.Ancestry.IS and model.parent is not None:
                yield model.parent.text

    def _report_no_model(self, name: s.Name, file: s.File) -> None:
        hint = said(name.text, self.written) or "`use` the file that defines it"
        fixes = make_respelling(name, self.written)
        self._fault("unknown-model", f"there is no model `{name}`", name, file, hint, fixes)

    def _add_line(
        self,
        owned: Owned[s.Line],
        lines: dict[str, Owned[s.Line]],
        inherited: frozenset[str],
        own: set[str],
        strict: bool,
    ) -> None:
        label = line_label(owned)
        node = owned.node.label or owned.node
        if label in own:
            if owned.node.label is None:
                # Two lines of one line of text cannot be: the file was joined from others.
                label = f"{label} of {owned.model}"
            else:
                self._fault("twice", f"there are two lines `{label}`", node, owned.file)
                return
        elif label in inherited:
            if owned.node.label is None:
                label = f"{owned.model} {label}"
            elif strict:
                message = f"`{label}` is a line of the model that this one is"
                hint = "give it a label of its own, or write `like` to replace lines"
                self._fault("replaced", message, node, owned.file, hint)
                return
        own.add(label)
        lines[label] = owned

    def _add_named(
        self,
        statement: s.Let | s.Define,
        file: s.File,
        model: str,
        lets: dict[str, Owned[s.Let]],
        defines: dict[str, Owned[s.Define]],
        inherited: frozenset[str],
        own: set[str],
        strict: bool,
    ) -> None:
        name = statement.name.text
        key = f"let {name}"
        if key in own:
            self._fault("twice", f"`{name}` is defined twice", statement.name, file)
            return
        if strict and name in inherited:
            message = f"`{name}` is a constant of the model that this one is"
            hint = "write `like` to change it, or give the new one a name of its own"
            self._fault("replaced", message, statement.name, file, hint)
            return
        own.add(key)
        if isinstance(statement, s.Let):
            lets[name] = Owned(statement, file, model)
        else:
            defines[name] = Owned(statement, file, model)

    def _drop(
        self,
        statement: s.Drop,
        file: s.File,
        lines: dict[str, Owned[s.Line]],
        parent: FlatModel | None,
        strict: bool,
    ) -> None:
        if strict or parent is None:
            message = "`drop` leaves lines out of a model that this one is like"
            hint = "write `model ... like ...`" if strict else ""
            self._fault("drop", message, statement, file, hint)
            return
        for label in statement.labels:
            if lines.pop(label.text, None) is None:
                hint = said(label.text, lines)
                fixes = make_respelling(label, lines)
                self._fault("drop", f"there is no line `{label}`", label, file, hint, fixes)
