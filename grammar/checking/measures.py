"""Measures and words: whether each is known, and is given what it takes."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from facetlog.grammar import syntax as s
from facetlog.grammar.constants import combine_dimensions, constant, quantity
from facetlog.grammar.faults import Fault, Fix, make_respelling, said, suggest_unit
from facetlog.grammar.phrase_hints import SPOKEN_WORDS, find_word_of_other_kind
from facetlog.grammar.scope import Local, Scope, SetSymbol, Symbol
from facetlog.grammar.source import Source
from facetlog.grammar.traversal import Node, walk
from facetlog.grammar.units import UNITS, Dimension
from facetlog.grammar.vocabulary import PIECE, THING, Gives, Kind, Kinds, Word


@dataclass(frozen=True, slots=True)
class Condition:
    """The type of what holds or fails."""

    def __str__(self) -> str:
        return "a condition"


@dataclass(frozen=True, slots=True)
class Element:
    """The type of what is a face, an edge, a vertex or a thing."""

    kinds: Kinds
    model: str = ""

    def __str__(self) -> str:
        names = sorted(self.kinds)
        return " or ".join(("an " if n[0] in "aeiou" else "a ") + n for n in names)


CONDITION = Condition()
Type: TypeAlias = Condition | Element | Dimension

DIMENSIONS = {
    Gives.ANGLE: Dimension.ANGLE,
    Gives.LENGTH: Dimension.LENGTH,
    Gives.AREA: Dimension.AREA,
    Gives.RATIO: Dimension.NUMBER,
    Gives.COUNT: Dimension.NUMBER,
}

EVERY = frozenset(Kind)
"""Kinds of a definition's parameter whose kind nothing determines."""


def suggest_units(left: Dimension, right: Dimension) -> str:
    if Dimension.NUMBER not in (left, right):
        return ""
    other = left if right is Dimension.NUMBER else right
    example = {Dimension.LENGTH: "40 cm", Dimension.AREA: "2 m2", Dimension.ANGLE: "15 deg"}
    share = ", or a share: `50 % of ...`" if other is not Dimension.ANGLE else ""
    return f"write a unit: `{example[other]}`{share}"


Names = Mapping[str, Symbol]
"""What `each`, `there` and parameters bring."""


@dataclass(slots=True)
class MeasureChecker(ABC):
    """Types of measures and words; conditions.py adds those of conditions."""

    scope: Scope
    faults: list[Fault] = field(default_factory=list)
    defining: tuple[str, ...] = ()
    source: Source = field(init=False)
    references: list[tuple[str, s.Name]] = field(default_factory=list)
    known: dict[tuple[str, tuple[Type, ...]], Type | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.source = self.scope.model.source

    def fault(
        self, code: str, message: str, node: Node, hint: str = "", fixes: tuple[Fix, ...] = ()
    ) -> None:
        """Add a fault of the model's own text."""
        self.faults.append(Fault(code, message, self.source, node.span, hint, fixes=fixes))

    @abstractmethod
    def type_of(self, node: s.Expression, names: Names) -> Type | None:
        """Return the type of an expression; None if it has a fault, which is reported."""

    def measure(self, node: s.Expression, names: Names) -> Dimension | None:
        """Return the dimension of a measure; a fault if it is none."""
        found = self.type_of(node, names)
        if found is None or isinstance(found, Dimension):
            return found
        hint = "write what is measured of it: `length(top)`" if isinstance(found, Element) else ""
        self.fault("not-measure", f"this is {found}, a measure is wanted", node, hint)
        return None

    def _check_quantity(self, node: s.Quantity) -> Dimension | None:
        if node.unit is not None and node.unit.text not in UNITS:
            hint = said(node.unit.text, UNITS) or f"units are {', '.join(UNITS)}"
            fixes = make_respelling(node.unit, UNITS)
            self.fault("unknown-unit", f"`{node.unit}` is no unit", node.unit, hint, fixes)
            return None
        found = quantity(node)
        if found is None:
            self.fault("number", f"`{node.number}` is too large or too small", node.number)
            return None
        return found.dimension

    def _find_symbol(self, name: s.Name, names: Names) -> Symbol | None:
        return names.get(name.text) or self.scope.symbols.get(name.text)

    def _check_reference(self, name: s.Name, names: Names) -> Type | None:
        found = self._find_symbol(name, names)
        if isinstance(found, SetSymbol):
            self.fault(
                "set",
                f"`{name}` is several {found.owned.node.kind}",
                name,
                f"write `each {name}: ...`, `count({name})` or `lowest of ...({name})`",
            )
            return None
        if found is not None:
            return Element(found.kinds, found.model)
        if name.text in self.scope.lets:
            value = constant(self.scope.lets[name.text].node.value, self.scope.lets)
            return value.dimension if value else None
        self._report_unknown(name, names)
        return None

    def _report_unknown(self, name: s.Name, names: Names) -> None:
        word = self.scope.words.get(name.text)
        if word is not None:
            hint = SPOKEN_WORDS.get(word.name, f"`{word.signature}`")
            if word.is_condition and len(word.arguments) == 1:
                example = next(iter((*names, *(p.name for p in self.scope.singular))), "top")
                hint = f"write `{example} is {name}`"
            self.fault("word", f"`{name}` is a word, and needs something to be said of", name, hint)
            return
        if name.text in self.scope.defines:
            self.fault(
                "word",
                f"`{name}` is a definition, and needs its arguments",
                name,
                f"write `{name}(...)`",
            )
            return
        known = {*names, *self.scope.symbols, *self.scope.lets}
        unit = f"write a number before the unit: `15 {name}`" if name.text in UNITS else ""
        self.fault(
            "unknown-name",
            f"nothing here is called `{name}`",
            name,
            said(name.text, known) or unit or SPOKEN_WORDS.get(name.text, ""),
            make_respelling(name, known),
        )

    def _check_member(self, node: s.Member, names: Names) -> Type | None:
        owner = self._find_symbol(node.owner, names)
        if owner is None:
            self._report_unknown(node.owner, names)
            return None
        if isinstance(owner, SetSymbol):
            self._check_reference(node.owner, names)
            return None
        if not owner.model:
            if owner.kinds != EVERY:  # of a parameter it is not known yet
                self.fault("member", f"`{node.owner}` is no object of a model", node.owner)
            return None
        if isinstance(owner, Local) and owner.name not in self.scope.symbols:
            hint = "name the part of an object, or of a set's own name in `each`"
            self.fault("member", f"`{node.owner}` stands for several objects", node.owner, hint)
            return None
        roles = self.scope.roles[owner.model]
        if node.part.text not in roles:
            hint = said(node.part.text, roles) or f"it has {', '.join(roles) or 'none'}"
            message = f"`{owner.model}` has no part `{node.part}`"
            self.fault("member", message, node.part, hint, make_respelling(node.part, roles))
            return None
        return Element(roles[node.part.text])

    def _count_of(self, node: s.Call, names: Names) -> Type | None:
        match node.arguments:
            case (s.Reference(name),) if isinstance(self._find_symbol(name, names), SetSymbol):
                return Dimension.NUMBER
        hint = (
            f"one of {', '.join(x.name for x in self.scope.sets)}"
            if self.scope.sets
            else ("declare one: `any number of faces side where ...`")
        )
        self.fault("set", "`count` takes the name of a set", node, hint)
        return None

    def unknown_word(self, name: s.Name, message: str, known: Collection[str]) -> None:
        """Return the fault of an unknown name, with what to write instead or the nearest known
        name."""
        if name.text in SPOKEN_WORDS:
            self.fault("unknown-word", message, name, SPOKEN_WORDS[name.text])
        else:
            hint, fixes = said(name.text, known), make_respelling(name, known)
            self.fault("unknown-word", message, name, hint, fixes)

    def unknown_statement(
        self,
        name: s.Name,
        subjects: tuple[s.Expression, ...],
        message: str,
        known: Collection[str],
        names: Names,
    ) -> None:
        """Report the unknown word that a statement rests on: not what follows from it, as that a
        subject is another word of the same phrase, or a set."""
        named = {*names, *self.scope.symbols, *self.scope.lets}
        told = name
        for subject in subjects:
            if not isinstance(subject, s.Reference):
                self.type_of(subject, names)
            elif subject.name.text not in named:
                if make_respelling(subject.name, named):
                    self._report_unknown(subject.name, names)
                elif name.text not in SPOKEN_WORDS and subject.name.text in SPOKEN_WORDS:
                    told = subject.name
        if told is not name:
            message = f"nothing here is called `{told}`"
        self.unknown_word(told, message, known)

    def _check_applied(
        self,
        name: s.Name,
        arguments: tuple[s.Expression, ...],
        node: s.Expression,
        names: Names,
    ) -> Type | None:
        """Return a word or definition with its arguments: what it gives."""
        if name.text in self.scope.defines:
            return self._check_definition(name, arguments, node, names)
        word = self.scope.words.get(name.text)
        if word is None:
            known = {**self.scope.words, **self.scope.defines, "count": None}
            if isinstance(node, s.Call):
                for argument in arguments:
                    self.type_of(argument, names)
                self.unknown_word(name, f"`{name}` is no word of the vocabulary", known)
            else:
                message = f"`{name}` is no word of the vocabulary"
                self.unknown_statement(name, arguments, message, known, names)
            return None
        if not self._check_arity(word, name, arguments):
            return None
        for number, argument in enumerate(arguments):
            if word.number_last and number == len(arguments) - 1:
                self._check_dimension(word, argument, names)
                continue
            wanted = word.arguments[min(number, len(word.arguments) - 1)]
            if not self._check_kind(word, argument, wanted, names):
                return None  # of the others the same word would be said again
        if word.alike:
            self._check_same_kind(word, arguments[: len(word.arguments)], node, names)
        named = [a.name.text for a in arguments if isinstance(a, s.Reference)]
        if len(set(named)) < len(named) and word.source is None:
            self.fault("itself", f"`{name}` is said of one part and itself", node)
            return None
        return CONDITION if word.is_condition else DIMENSIONS[word.gives]

    def _check_arity(self, word: Word, name: s.Name, arguments: tuple[s.Expression, ...]) -> bool:
        # What several share takes two at least.
        wanted = len(word.arguments) + (word.number_last is not None) + word.many
        if len(arguments) == wanted or (word.many and len(arguments) >= wanted):
            return True
        more = " or more" if word.many else ""
        self.fault(
            "arity",
            f"`{name}` takes {wanted}{more}, not {len(arguments)}",
            name,
            f"`{word.signature}`",
        )
        return False

    def _check_dimension(self, word: Word, argument: s.Expression, names: Names) -> None:
        wanted = DIMENSIONS[word.number_last]  # type: ignore[index]
        found = self.measure(argument, names)
        if found is not None and found is not wanted:
            fixes = suggest_unit(argument, wanted, ()) if found is Dimension.NUMBER else ()
            message = f"this is {found}, `{word.name}` wants {wanted}"
            self.fault("dimension", message, argument, fixes=fixes)

    def _check_kind(self, word: Word, argument: s.Expression, wanted: Kinds, names: Names) -> bool:
        """Report an argument of another kind than the word wants; return whether it is none."""
        found = self.type_of(argument, names)
        if found is None:
            return True
        if not isinstance(found, Element):
            self.fault("kind", f"this is {found}, `{word.name}` wants {Element(wanted)}", argument)
        elif not found.kinds & wanted:
            hint = find_word_of_other_kind(word.name, str(found)) or f"`{word.signature}`"
            self.fault(
                "kind", f"this is {found}, `{word.name}` wants {Element(wanted)}", argument, hint
            )
        return isinstance(found, Element) and bool(found.kinds & wanted)

    def _check_same_kind(
        self, word: Word, arguments: tuple[s.Expression, ...], node: s.Expression, names: Names
    ) -> None:
        found = [t for a in arguments if isinstance(t := self.type_of(a, names), Element)]
        fit = [t for t in found if t.kinds & word.arguments[0]]
        if len(fit) == len(arguments) and not frozenset.intersection(*(t.kinds for t in fit)):
            message = f"`{word.name}` is said of two of one kind, not of {fit[0]} and {fit[1]}"
            self.fault("kind", message, node)

    def _check_definition(
        self,
        name: s.Name,
        arguments: tuple[s.Expression, ...],
        node: s.Expression,
        names: Names,
    ) -> Type | None:
        define = self.scope.defines[name.text].node
        if name.text in self.defining:
            self.fault("cycle", f"`{name}` is defined by itself", name)
            return None
        if len(arguments) != len(define.parameters):
            wanted = ", ".join(p.text for p in define.parameters)
            self.fault(
                "arity",
                f"`{name}` takes {len(define.parameters)}, not {len(arguments)}",
                name,
                f"`{name}({wanted})`",
            )
            return None
        given = [self.type_of(a, names) for a in arguments]
        if any(t is None for t in given):
            return None
        for argument, found in zip(arguments, given, strict=True):
            if not isinstance(found, Element):
                self.fault("kind", f"this is {found}, `{name}` takes parts", argument)
                return None
        elements = [t for t in given if isinstance(t, Element)]
        return self._check_body(name, define, tuple(elements), node)

    def _check_body(
        self, name: s.Name, define: s.Define, given: tuple[Element, ...], node: s.Expression
    ) -> Type | None:
        """Return the type of a definition for such arguments; faults are reported at the call."""
        key = name.text, given
        if key in self.known:
            return self.known[key]
        bound = {
            p.text: Local(p.text, e.kinds, e.model)
            for p, e in zip(define.parameters, given, strict=True)
        }
        inner = type(self)(
            self.scope,
            defining=(*self.defining, name.text),
            references=self.references,
            known=self.known,
        )
        found = inner.type_of(define.body, bound)
        own = self.scope.defines[name.text].file.source
        if inner.faults:
            fault = inner.faults[0]
            line = own.get_line_and_column(fault.span.start)[0]
            if own is not self.source or (fault.span, fault.code) not in {
                (f.span, f.code) for f in self.faults
            }:
                message = f"`{name}` cannot be said of this: {fault.message}"
                self.fault(fault.code, message, node, f"see line {line} of {own.name}")
            found = None
        self.known[key] = found
        return found

    def _check_arithmetic(self, node: s.Arithmetic, names: Names) -> Type | None:
        left, right = self.measure(node.left, names), self.measure(node.right, names)
        if left is None or right is None:
            return None
        found = combine_dimensions(node.sign, left, right)
        if found is None:
            said_of = {"+": "added to", "-": "taken from", "*": "multiplied by", "/": "divided by"}
            first, second = (right, left) if node.sign == "-" else (left, right)
            message = f"{first} cannot be {said_of[node.sign]} {second}"
            self.fault("dimension", message, node, suggest_units(left, right))
        return found

    def _check_share(self, node: s.Share, names: Names) -> Type | None:
        share = self._check_quantity(node.share)
        whole = self.measure(node.whole, names)
        if share is not None and share is not Dimension.NUMBER:
            self.fault(
                "dimension",
                f"{share} of something has no meaning",
                node.share,
                "write a share: `50 % of ...`",
            )
        return whole

    def _check_aggregate(self, node: s.Aggregate, names: Names) -> Type | None:
        sets = _find_sets(node.operand, self.scope, names)
        if len(sets) != 1:
            what = "names no set" if not sets else "names two sets"
            self.fault(
                "set",
                f"`{node.how} of` {what}",
                node,
                "write one value of its members: `lowest of elevation(leg)`",
            )
            return None
        inside = {**names, sets[0].name: Local(sets[0].name, sets[0].kinds, sets[0].model)}
        if node.how.endswith("gap"):
            found = self.type_of(node.operand, inside)
            if isinstance(found, Element) and found.kinds != THING:
                self.fault("kind", "gaps are between things", node.operand)
            return Dimension.LENGTH
        if node.how.endswith("spacing"):
            found = self.type_of(node.operand, inside)
            if found is not None and not (isinstance(found, Element) and found.kinds == PIECE):
                hint = f"write `{node.how} of {sets[0].name}`"
                self.fault("kind", "spacings are between pieces", node.operand, hint)
            return Dimension.LENGTH
        found = self.measure(node.operand, inside)
        if node.how != "order":
            return found
        if sets[0].kinds != PIECE:
            self.fault("kind", "only pieces stand in a row", node.operand)
        return Dimension.NUMBER


def _find_sets(node: s.Expression, scope: Scope, names: Names) -> tuple[SetSymbol, ...]:
    found: dict[str, SetSymbol] = {}
    for inner in walk(node):
        owner = inner.owner if isinstance(inner, s.Member) else getattr(inner, "name", None)
        if isinstance(inner, s.Reference | s.Member) and owner is not None:
            symbol = names.get(owner.text) or scope.symbols.get(owner.text)
            if isinstance(symbol, SetSymbol):
                found[symbol.name] = symbol
    return tuple(found.values())
