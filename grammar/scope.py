"""Symbol tables: the names of a model and what they stand for."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from facetlog.grammar import syntax as s
from facetlog.grammar.library import Library
from facetlog.grammar.reading.layout import PIECE_WORDS
from facetlog.grammar.resolve import FlatModel, Owned
from facetlog.grammar.source import NOWHERE, Span
from facetlog.grammar.traversal import walk
from facetlog.grammar.vocabulary import HOLLOW, OPENING, PIECE, THING, Kind, Kinds, Word

THIS = "this"
"""The thing that a model is judged of."""

_KINDS = {
    "face": frozenset({Kind.FACE}),
    "edge": frozenset({Kind.EDGE}),
    "vertex": frozenset({Kind.VERTEX}),
    "element": frozenset({Kind.FACE, Kind.EDGE}),
}
_PLURALS = {"faces": "face", "edges": "edge", "vertices": "vertex", "elements": "element"}
_HOLES = {"opening": OPENING, "hollow": HOLLOW}
_PIECES = {f"{word}{plural}": word for word in PIECE_WORDS for plural in ("", "s")}


@dataclass(frozen=True, slots=True)
class PartSymbol:
    """A singular part: one element, or one object that a model recognises."""

    name: str
    kinds: Kinds
    model: str
    owned: Owned[s.Part]


@dataclass(frozen=True, slots=True)
class SetSymbol:
    """All elements, or objects, that satisfy a condition."""

    name: str
    kinds: Kinds
    model: str
    owned: Owned[s.Part]


@dataclass(frozen=True, slots=True)
class Local:
    """A local name: of `each`, of `there`, or a definition's parameter."""

    name: str
    kinds: Kinds
    model: str = ""


Symbol: TypeAlias = PartSymbol | SetSymbol | Local


@dataclass(frozen=True, slots=True)
class Scope:
    """The names in reach of a model. `roles` are the parts of the models that it may name."""

    model: FlatModel
    symbols: Mapping[str, Symbol]
    words: Mapping[str, Word]
    roles: Mapping[str, Mapping[str, Kinds]]
    lets: Mapping[str, Owned[s.Let]] = field(default_factory=dict)
    defines: Mapping[str, Owned[s.Define]] = field(default_factory=dict)

    @property
    def singular(self) -> tuple[PartSymbol, ...]:
        """The singular parts, in the order of the file."""
        return tuple(x for x in self.symbols.values() if isinstance(x, PartSymbol))

    @property
    def sets(self) -> tuple[SetSymbol, ...]:
        """The sets, in the order of the file."""
        return tuple(x for x in self.symbols.values() if isinstance(x, SetSymbol))

    @property
    def of_things(self) -> bool:
        """Whether the model is made of objects: it is judged at its first one."""
        return bool(self.singular) and self.singular[0].kinds == THING

    def where(self, symbol: "PartSymbol | SetSymbol") -> s.Expression | None:
        """Return the `where` condition of a part or set; None if it has none."""
        node = symbol.owned.node
        return self.demanded(node, next(n for n in node.names if n.text == symbol.name))

    def demanded(self, node: s.Part | s.Each | s.There, name: s.Name) -> s.Expression | None:
        """Return the condition on what a part, `each` or `there` calls by that name.

        That is its `where`, and before that, of a board, bar or block, that it is one.
        """
        where, kind = node.where, node.kind
        shape = _PIECES.get(kind.text) if kind is not None else None
        if kind is None or shape in (None, "piece", *_HOLES) or self._is_model(kind.text):
            return where
        subject = s.Reference(name, name.span)
        own = s.Property(subject, s.Name(str(shape), kind.span), False, kind.span)
        if where is None:
            return own
        conditions = where.conditions if isinstance(where, s.And) else (where,)
        return s.And((own, *conditions), Span(kind.span.start, where.span.end))

    def get_element_kinds(self, text: str) -> Kinds | None:
        """Return the kinds that `each` and `there is` go through by that word; objects are none."""
        return None if self._is_model(text) else (get_part_kind(text, {}) or (None,))[0]

    def _is_model(self, text: str) -> bool:
        return bool((get_part_kind(text, self.roles) or ("", ""))[1])


def get_part_kind(text: str, models: Mapping[str, object]) -> tuple[Kinds, str] | None:
    """Return the meaning of a part's kind: kinds of elements, or a model's name.

    >>> get_part_kind("vertices", {})
    (frozenset({vertex}), '')
    >>> get_part_kind("chairs", {"chair": ...})
    (frozenset({thing}), 'chair')
    >>> get_part_kind("bars", {})
    (frozenset({piece}), '')
    """
    word = _PLURALS.get(text, text)
    if word in _KINDS:
        return _KINDS[word], ""
    for name in (text, text.removesuffix("s"), text.removesuffix("es")):
        if name in models:
            return THING, name
    shape = _PIECES.get(text)
    return None if shape is None else (_HOLES.get(shape, PIECE), "")


def iter_conditions(node: s.Expression | None, scope: Scope) -> Iterator[s.Expression]:
    """Iterate over a condition, and the bodies of the definitions that it names, each once."""
    seen: set[str] = set()
    waiting: list[s.Expression] = [] if node is None else [node]
    while waiting:
        one = waiting.pop()
        yield one
        for inner in walk(one):
            if isinstance(inner, s.Name) and inner.text in scope.defines and inner.text not in seen:
                seen.add(inner.text)
                waiting.append(scope.defines[inner.text].node.body)


def names_in(node: s.Expression | None, scope: Scope) -> frozenset[str]:
    """Return all names in a condition, those in the definitions that it names too."""
    return frozenset(
        inner.text
        for one in iter_conditions(node, scope)
        for inner in walk(one)
        if isinstance(inner, s.Name)
    )


def get_model_roles(
    models: Mapping[str, FlatModel], library: Library
) -> dict[str, dict[str, Kinds]]:
    """Return the parts that `x.part` may name, for each model; those of Prolog files are faces."""
    roles: dict[str, dict[str, Kinds]] = {}
    for own in library.words.values():
        for name, parts in own.models.items():
            roles[name] = dict.fromkeys(parts, _KINDS["face"])
    for name, model in models.items():
        roles[name] = {
            part.text: kind[0]
            for owned in model.parts
            if owned.node.count is None
            and (kind := get_part_kind(owned.node.kind.text, models)) is not None
            for part in owned.node.names
        }
    return roles


def build_model_scope(
    model: FlatModel, words: Mapping[str, Word], roles: Mapping[str, Mapping[str, Kinds]]
) -> Scope:
    """Return the names of a model; of a name that is given twice the first counts."""
    symbols: dict[str, Symbol] = {THIS: Local(THIS, THING)}
    for owned in model.parts:
        # A kind that is not known is a fault once, and then may be anything.
        kind = get_part_kind(owned.node.kind.text, roles) or (frozenset(Kind), "")
        make = PartSymbol if owned.node.count is None else SetSymbol
        for name in owned.node.names:
            symbols.setdefault(name.text, make(name.text, *kind, owned))
    return Scope(model, symbols, words, roles, model.lets, model.defines)


def build_file_scope(
    file: s.File, words: Mapping[str, Word], roles: Mapping[str, Mapping[str, Kinds]]
) -> Scope:
    """Return the names in reach before the first model of a file: words, and one another."""
    lets = {x.name.text: Owned(x, file, "") for x in file.statements if isinstance(x, s.Let)}
    defines = {x.name.text: Owned(x, file, "") for x in file.statements if isinstance(x, s.Define)}
    written = s.Model(s.Name("", NOWHERE), None, None, (), None, file.statements, NOWHERE)
    none = FlatModel("", written, file, (), (), (), lets, defines, ())
    return build_model_scope(none, words, roles)
