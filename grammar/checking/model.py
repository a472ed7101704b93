"""Models: names that are free, parts that can be, and every statement's expressions."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.conditions import ConditionChecker
from facetlog.grammar.checking.measures import EVERY
from facetlog.grammar.constants import constant
from facetlog.grammar.fading import FADING
from facetlog.grammar.faults import Fault, make_respelling, said
from facetlog.grammar.library import list_builtin_names
from facetlog.grammar.phrase_hints import SPOKEN_WORDS
from facetlog.grammar.reading.layout import PIECE_WORDS, STATEMENT_WORDS
from facetlog.grammar.resolve import Owned, find_reachable
from facetlog.grammar.scope import (
    THIS,
    Local,
    PartSymbol,
    Scope,
    SetSymbol,
    get_part_kind,
    names_in,
)
from facetlog.grammar.traversal import Node, children
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import EACH_HOLE, THING

LARGEST = 3000
"""Words of one condition, with those of the definitions that it names."""

DEEPEST = 80
"""Expressions within expressions, those of definitions counted where they are named."""

MOST_NESTED = 30
"""Definitions within definitions."""


_NUMBER = r"\s*[-+]?(\d+\.?\d*|\.\d+)\s*"
_VECTOR = f"{_NUMBER},{_NUMBER},{_NUMBER}"

STATED: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "up": (rf"-?[xyz]|auto|none|{_VECTOR}", '`up z`, `up -y` or `up "0,0,1"`'),
        "unit": (r"m|cm|mm|in|ft|none", "`unit m`, `cm`, `mm`, `in` or `ft`"),
        "scale": (r".*\S.*=.*\S.*", '`scale "height = 74 cm"`'),
        "sensor": (_VECTOR, '`sensor "0,-1,2"`'),
    }
)
"""Options for reading an example's file: a pattern for the value, and how it is written."""


@dataclass(slots=True)
class Extents:
    """Sizes and depths by a model's definitions."""

    defines: Mapping[str, Owned[s.Define]]
    known: dict[str, tuple[int, int]] = field(default_factory=dict)

    def find_oversize(self, node: s.Expression) -> str:
        """Say what is too much about an expression; empty if nothing is."""
        size, depth = self.of(node, ())
        if size > LARGEST:
            return f"it comes to more than {LARGEST} words, those of its definitions included"
        if depth > DEEPEST:
            return f"it is more than {DEEPEST} expressions deep, those of its definitions included"
        return ""

    def of(self, node: s.Expression, within: tuple[str, ...]) -> tuple[int, int]:
        """Return size and depth of an expression."""
        size, deepest = 0, 0
        waiting: list[tuple[Node, int]] = [(node, 1)]
        while waiting:
            one, depth = waiting.pop()
            size += 1
            if isinstance(one, s.Call | s.Property | s.Relation):
                more, deeper = self._measure_definition(one.name.text, within)
                size += more
                deepest = max(deepest, depth + deeper)
            deepest = max(deepest, depth)
            waiting.extend((child, depth + 1) for child in children(one))
        return size, deepest

    def _measure_definition(self, name: str, within: tuple[str, ...]) -> tuple[int, int]:
        if name not in self.defines or name in within:
            return 0, 0
        if name not in self.known:
            if len(within) >= MOST_NESTED:
                return 0, DEEPEST + 1
            size, depth = self.of(self.defines[name].node.body, (*within, name))
            self.known[name] = min(size, LARGEST + 1), min(depth, DEEPEST + 1)
        return self.known[name]


_IN_CONDITIONS = frozenset(
    """not each there and or is at between about of sum mean lowest highest smallest largest order
    if fading sharp where any exactly""".split()  # noqa: SIM905  a list of words is read more easily so
)
"""Words that would be taken for themselves wherever a part of such a name is meant."""

MOST_SINGULAR = 16
"""Singular parts of a model: what plays them is found by trying."""

MOST_PARTS = 60
"""Parts and sets of a model; more is no thing that a person describes."""


@dataclass(frozen=True, slots=True)
class Checked:
    """Faults of a model, and the models that its conditions name, with the places."""

    faults: tuple[Fault, ...]
    references: tuple[tuple[str, s.Name], ...]


def check_model(scope: Scope) -> Checked:
    """Find the faults of names and dimensions of a model, in the order of its statements.

    Statements that it inherits are checked where they are written.
    """
    checker = _ModelChecker(scope)
    checker.model()
    return Checked(tuple(checker.faults), tuple(checker.references))


def check_file(scope: Scope) -> tuple[Fault, ...]:
    """Check the statements before the first model of a file."""
    checker = _ModelChecker(scope)
    checker.file()
    return tuple(checker.faults)


RESERVED_NAMES = frozenset({"none", "error"})
"""Names that result tables use for "no model holds" and for failed scenes."""


def _name_one_kind(owned: Owned[s.Part]) -> str:
    """Return a part of the kind of a set, as it is declared."""
    kind = str(owned.node.kind)
    return f"{_ONE_OF.get(kind, kind.removesuffix('s'))} first"


_ONE_OF = {"vertices": "vertex"}


@dataclass(slots=True)
class _ModelChecker(ConditionChecker):
    extents: Extents = field(init=False)

    def __post_init__(self) -> None:
        ConditionChecker.__post_init__(self)
        self.extents = Extents(self.scope.defines)

    def model(self) -> None:
        """Check a model's names, that there is something to judge, and its statements."""
        model = self.scope.model
        if model.name in RESERVED_NAMES:
            message = f"`{model.name}` is what results say of no model"
            self.fault("taken", message, model.written.name, "choose another name")
        self._check_names()
        if not model.parts:
            self.fault(
                "no-parts",
                f"`{model.name}` has no parts",
                model.written.name,
                "begin with `face top`, say",
            )
        elif all(owned.node.count is not None for owned in model.parts):
            self.fault(
                "no-parts",
                f"`{model.name}` has sets only",
                model.written.name,
                f"name one part that the others are found from: `{_name_one_kind(model.parts[0])}`",
            )
        if not model.lines and not any(map(self._is_decisive, self.scope.symbols.values())):
            self.fault(
                "no-lines",
                f"`{model.name}` has no condition to decide it",
                model.written.name,
                "add a line, or say of a part how it lies: `where …`",
            )
        self._check_set_circles()
        self.statements()

    def _is_decisive(self, symbol: object) -> bool:
        """Return whether a part's own statement is a condition: how it lies, what it is, how
        many.
        """
        if not isinstance(symbol, PartSymbol | SetSymbol) or symbol.owned.node.optional:
            return False
        if isinstance(symbol, SetSymbol):
            count = symbol.owned.node.count
            return count is not None and (count.least > 0 or count.most < math.inf)
        stated = self.scope.where(symbol) is not None
        return stated or bool(symbol.model) or symbol.kinds in EACH_HOLE

    def file(self) -> None:
        """Check the names and statements of what stands before the first model."""
        named: dict[str, s.Name] = {}
        for statement in self.scope.model.written.statements:
            if isinstance(statement, s.Let | s.Define):
                first = named.setdefault(statement.name.text, statement.name)
                if first is not statement.name:
                    self.fault("twice", f"`{first}` is defined twice", statement.name)
                if not _is_fading(statement):
                    self._check_free(statement.name)
        self.statements()

    def statements(self) -> None:
        """Check each statement that is written here."""
        for statement in self.scope.model.written.statements:
            match statement:
                case s.Part():
                    self._check_part(statement)
                case s.Line():
                    self._check_line(statement)
                case s.Let():
                    self._check_let(statement)
                case s.Define():
                    self._check_define(statement)
                case s.Size():
                    self._check_size(statement)
                case s.Example():
                    self._check_example(statement)
                case _:
                    pass

    def _check_names(self) -> None:
        """Report names of a model that are in use already."""
        self._check_free(self.scope.model.written.name)
        if len(self.scope.model.parts) > MOST_PARTS or len(self.scope.singular) > MOST_SINGULAR:
            hint = f"a model has {MOST_SINGULAR} singular parts and {MOST_PARTS} in all, at most"
            self.fault("too-many", "these are too many parts", self.scope.model.written.name, hint)
        taken: dict[str, tuple[str, s.Name]] = {}
        own = self.scope.model.name
        named: list[tuple[s.Name, str, bool]] = []
        for part in self.scope.model.parts:
            named += [(n, "a part", part.model == own) for n in part.node.names]
        for let in self.scope.lets.values():
            named.append((let.node.name, "a constant", let.model == own))
        for define in self.scope.defines.values():
            named.append((define.node.name, "a definition", define.model == own))
        # Inherited names come first: it is the new one that clashes.
        for name, what, is_own in sorted(named, key=lambda n: n[2]):
            before, first = taken.setdefault(name.text, (what, name))
            if not is_own:
                continue
            if first is not name:
                self.fault("taken", f"`{name}` is {before} already", name, "choose another name")
            elif name.text == THIS:
                self.fault("taken", "`this` is the thing itself", name, "choose another name")
            elif what != "a constant" or name.text != FADING:
                self._check_free(name)

    def _check_free(self, name: s.Name) -> None:
        """Report a name that is a word already."""
        whose = ""
        word = self.scope.words.get(name.text)
        if (word is not None and not word.yields) or name.text == "count":
            whose = "the vocabulary"
        elif name.text in STATEMENT_WORDS | _IN_CONDITIONS:
            whose = "the language"
        if whose:
            message = f"`{name}` is a word of {whose}"
            self.fault("taken", message, name, "choose another name")

    def _check_set_circles(self) -> None:
        """Report sets that are found by one another."""
        sets = {x.name: x for x in self.scope.sets}
        needs = {
            name: (names_in(x.owned.node.where, self.scope) & sets.keys()) - {name}
            for name, x in sets.items()
        }
        for name, symbol in sets.items():
            is_circle = name in find_reachable(name, lambda one: needs[one])
            if is_circle and symbol.owned.model == self.scope.model.name:
                by = ", ".join(f"`{other}`" for other in sorted(needs[name]))
                message = f"`{name}` is found by {by}, and that by `{name}`"
                where = symbol.owned.node.names[0]
                self.fault("cycle", message, where, "find one of them without the other")

    def _check_part(self, part: s.Part) -> None:
        kind = get_part_kind(part.kind.text, self.scope.roles)
        if kind is None:
            known = {"face", "edge", "vertex", "element", *PIECE_WORDS, *self.scope.roles}
            known |= list_builtin_names()
            self.fault(
                "unknown-kind",
                f"`{part.kind}` is no kind of part",
                part.kind,
                SPOKEN_WORDS.get(part.kind.text)
                or said(part.kind.text, known)
                or "a face, an edge, a vertex, an element, a piece, or a model that this file uses",
                make_respelling(part.kind, known),
            )
            return
        if kind[1]:
            self.references.append((kind[1], part.kind))
        if kind[0] == THING and not self.scope.of_things:
            self.fault(
                "mixed",
                f"`{self.scope.model.name}` is made of faces, not of objects",
                part.kind,
                "its first part must be an object: `one table board`",
            )
        elif kind[0] != THING and self.scope.of_things and part.count is None:
            self.fault(
                "mixed",
                f"`{self.scope.model.name}` is made of objects",
                part.kind,
                "faces belong to them: `board.top`",
            )
        if part.where is not None and part.count is None and len(part.names) > 1:
            self.fault(
                "where", "`where` is said of one part", part.names[1], "declare each by itself"
            )
            return
        if part.separate and kind[0] & THING:
            self.fault(
                "separate",
                "only faces and edges adjoin one another",
                part.kind,
                "leave out `separate`",
            )
        if part.count is not None:
            self.check_count(part.count)
        if part.where is not None and not self._check_extent(part.where, part.kind):
            name = part.names[0].text
            self.condition(part.where, {name: Local(name, *kind)})

    def _check_line(self, line: s.Line) -> None:
        if line.expect and line.expect.endswith("%"):
            weight = float(line.expect.split()[0])
            if weight > 100:
                self.fault("weight", f"a weight of {line.expect} is more than all", line.condition)
        if not self._check_extent(line.condition, line.condition):
            self.condition(line.condition, {})

    def _check_let(self, let: s.Let) -> None:
        before = len(self.faults)
        self.type_of(let.value, {})
        if len(self.faults) == before and constant(let.value, self.scope.lets) is None:
            self.fault(
                "not-constant",
                f"`{let.name}` is no constant",
                let.value,
                "use `define` for what depends on a part",
            )
        elif len(self.faults) == before and _is_fading(let):
            value = constant(let.value, self.scope.lets)
            if value is None or not value.percent or not 0 <= value.value <= 1:
                message = "a model's fading is a share of its limits, from 0 % to 100 %"
                self.fault("fading", message, let.value, "write `let fading = 10 %`")

    def _check_define(self, define: s.Define) -> None:
        names = [p.text for p in define.parameters]
        for parameter in define.parameters:
            if names.count(parameter.text) > 1:
                self.fault("taken", f"`{parameter}` is named twice", parameter)
                return
        self._check_unshadowed(define.parameters, {})
        unknown = {name: Local(name, EVERY) for name in names}
        if not self._check_extent(define.body, define.name):
            self.defining = (define.name.text,)
            self.type_of(define.body, unknown)
            self.defining = ()

    def _check_extent(self, node: s.Expression, where: Node) -> bool:
        """Report a condition that is too large or too deep; nothing else is then said of it."""
        why = self.extents.find_oversize(node)
        if why:
            self.fault("too-large", "this is too much for one condition", where, why)
        return bool(why)

    def _check_size(self, size: s.Size) -> None:
        if len(size.names) != len(size.measures):
            self.fault(
                "size", f"{len(size.names)} names for {len(size.measures)} measures", size.names[0]
            )
        for measure in size.measures:
            found = self.measure(measure, {})
            if found is not None and found is not Dimension.LENGTH:
                self.fault("dimension", f"a size is a length, this is {found}", measure)

    def _check_example(self, example: s.Example) -> None:
        labels = [label for label, _ in self.scope.model.lines]
        labels += [p.name for p in self.scope.singular]
        labels += [p.name for p in self.scope.sets]
        for label in example.because:
            if label.text not in labels:
                self.fault(
                    "unknown-line",
                    f"there is no line `{label}`",
                    label,
                    said(label.text, labels),
                    make_respelling(label, labels),
                )
        if isinstance(example.scene, s.SceneBuilt):
            for solid in example.scene.solids:
                for setting in solid.settings:
                    self._check_quantity(setting.quantity)
        else:
            self._check_stated(example.scene)
        if example.at_least is not None:
            found = self._check_quantity(example.at_least)
            if found is not None and found is not Dimension.NUMBER:
                self.fault("dimension", f"a degree is a share, this is {found}", example.at_least)

    def _check_stated(self, scene: s.SceneFile) -> None:
        given: set[str] = set()
        for stated in scene.stated:
            name, value = stated.name, stated.value
            pattern, written = STATED.get(name.text, ("", ""))
            if not pattern:
                message = f"`{name}` is no option for reading a file"
                hint = said(name.text, STATED) or f"there are {', '.join(STATED)}"
                self.fault("stated", message, name, hint, make_respelling(name, STATED))
            elif name.text in given:
                self.fault("twice", f"`{name}` is given twice", name)
            elif not re.fullmatch(pattern, value.value):
                message = f"`{value.value}` is no value of `{name}`"
                self.fault("stated", message, value, f"write {written}")
            given.add(name.text)


def _is_fading(statement: s.Let | s.Define) -> bool:
    """Return whether it says over which share of them limits fade: a constant of that very name."""
    return isinstance(statement, s.Let) and statement.name.text == FADING
