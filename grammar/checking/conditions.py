"""Conditions: comparisons of one dimension, properties, and what `each` and `there` go through."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.measures import (
    CONDITION,
    EVERY,
    Element,
    MeasureChecker,
    Names,
    Type,
    suggest_units,
)
from facetlog.grammar.constants import constant
from facetlog.grammar.faults import (
    make_respelling,
    respell,
    said,
    suggest_unit,
    swap,
)
from facetlog.grammar.phrase_hints import SPOKEN_WORDS
from facetlog.grammar.reading.layout import PIECE_WORDS
from facetlog.grammar.scope import Local, PartSymbol, SetSymbol, get_part_kind
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import THING, Gives, Kinds

ELEMENTS = (
    "face",
    "faces",
    "edge",
    "edges",
    "element",
    "piece",
    "board",
    "bar",
    "block",
    "opening",
    "hollow",
)
"""What `there is` and `each` go through, as it is spelt."""

PART_WORDS = PIECE_WORDS | {"face", "edge", "element"}
"""Words that a part is declared with."""


@dataclass(slots=True)
class ConditionChecker(MeasureChecker):
    """Types of all expressions."""

    def condition(self, node: s.Expression, names: Names) -> None:
        """Report that a node is no condition."""
        found = self.type_of(node, names)
        if found is not None and found is not CONDITION:
            hint = "compare it: `at least`, `at most`, `between`, `= ... ± ...`"
            if isinstance(found, Element):
                hint = "say what is true of it: `top is level`"
            self.fault("not-condition", f"this is {found}, a condition is wanted", node, hint)

    def type_of(self, node: s.Expression, names: Names) -> Type | None:
        """Return the type of an expression; None if it has a fault, which is reported."""
        match node:
            case s.Quantity():
                return self._check_quantity(node)
            case s.Reference(name):
                return self._check_reference(name, names)
            case s.Member():
                return self._check_member(node, names)
            case s.Call(s.Name("count")):
                return self._count_of(node, names)
            case s.Call(name, arguments):
                return self._check_applied(name, arguments, node, names)
            case s.Arithmetic():
                return self._check_arithmetic(node, names)
            case s.Negative(operand):
                return self.measure(operand, names)
            case s.Share():
                return self._check_share(node, names)
            case s.Aggregate():
                return self._check_aggregate(node, names)
            case s.Comparison():
                self._check_comparison(node, names)
            case s.Property():
                self._check_property(node, names)
            case s.Relation():
                if not self._report_part(node):
                    self._check_condition_word(node.name, (node.left, node.right), node, names)
            case s.Not(condition):
                self.condition(condition, names)
            case s.And(conditions) | s.Or(conditions):
                for condition in conditions:
                    self.condition(condition, names)
            case s.Each():
                self._check_each(node, names)
            case s.EachOf():
                self._check_each_of(node, names)
            case s.There():
                self._check_there(node, names)
        return CONDITION

    def _report_part(self, node: s.Relation) -> bool:
        """Report three words that are no relation but a part, wrongly declared."""
        left, name = node.left, node.name
        if not isinstance(left, s.Reference) or left.name.text in self.scope.symbols:
            return False
        right = self.source.text[node.right.span.start : node.right.span.end]
        known = name.text in self.scope.words or name.text in self.scope.defines
        if left.name.text in PART_WORDS and not known:
            joined = f"{name}_{right}"
            hint = f"write `{left.name} {joined}`, or `{left.name} {name}, {right}` for two"
            fix = respell(name.span.to(node.right.span), joined, sure=False)
            self.fault("part", "the name of a part is one word", node, hint, (fix,))
            return True
        if left.name.text in ("a", "an", "the") and name.text in PART_WORDS:
            fix = respell(node.span, f"{name} {right}", sure=False)
            message = f"a part is declared without `{left.name}`"
            self.fault("part", message, node, f"write `{name} {right}`", (fix,))
            return True
        return False

    def check_count(self, count: s.Count) -> None:
        """Report a count that is no whole number, or upside down."""
        for number in (count.low, count.high):
            if number is not None and not number.text.isdigit():
                self.fault("count", f"`{number}` is no whole number", number)
                return
        if count.low and count.high and int(count.low.text) > int(count.high.text):
            fix = swap(self.source.text, count.low.span, count.high.span, sure=True)
            message = f"`{count.low}` is more than `{count.high}`"
            self.fault("count", message, count.low, fixes=(fix,))

    def _check_comparison(self, node: s.Comparison, names: Names) -> None:
        left = self.measure(node.measure, names)
        right = self.measure(node.limit, names)
        beside = node.limit, node.second, node.fading
        self._check_alike(left, right, node.limit, beside)
        exactly = node.comparator is s.Comparator.EQUAL and node.second is None
        if exactly and not (self._is_count(node.measure) or self._is_count(node.limit)):
            hint = "give a tolerance: `= ... ± ...`"
            self.fault("no-tolerance", "no measure is exactly so", node, hint)
        for extra, is_share in (
            (node.second, node.comparator is not s.Comparator.BETWEEN),
            (node.fading, True),
        ):
            if extra is None:
                continue
            found = self.measure(extra, names)
            value = constant(extra, self.scope.lets)
            if is_share and value is not None and value.percent:
                continue
            self._check_alike(left, found, extra, beside)

    def _is_count(self, node: s.Expression) -> bool:
        match node:
            case s.Call(name):
                word = self.scope.words.get(name.text)
                return name.text == "count" or (word is not None and word.gives is Gives.COUNT)
        return False

    def _check_alike(
        self,
        left: Dimension | None,
        right: Dimension | None,
        node: s.Expression,
        beside: Iterable[s.Expression | None],
    ) -> None:
        if left is None or right is None or left is right:
            return
        if right is Dimension.NUMBER:
            value = constant(node, self.scope.lets)
            if value is not None and value.value == 0 and not value.percent:
                return
        fixes = suggest_unit(node, left, beside) if right is Dimension.NUMBER else ()
        message = f"{left} is compared with {right}"
        self.fault("dimension", message, node, suggest_units(left, right), fixes)

    def _check_property(self, node: s.Property, names: Names) -> None:
        name = node.name.text
        if name in self.scope.defines or name in self.scope.words:
            self._check_condition_word(node.name, (node.subject,), node, names)
            return
        if name in self.scope.roles:
            found = self.type_of(node.subject, names)
            self.references.append((name, node.name))
            if isinstance(found, Element) and not found.kinds & THING:
                self.fault("kind", f"`{name}` is said of things, this is {found}", node.subject)
            return
        known = [w.name for w in self.scope.words.values() if w.is_condition]
        others = [*known, *self.scope.roles, *self.scope.defines]
        message = f"`{name}` is no property"
        self.unknown_statement(node.name, (node.subject,), message, others, names)

    def _check_condition_word(
        self, name: s.Name, subjects: tuple[s.Expression, ...], node: s.Expression, names: Names
    ) -> None:
        found = self._check_applied(name, subjects, node, names)
        if found is not None and found is not CONDITION:
            of = ", ".join(self.source.text[x.span.start : x.span.end] for x in subjects)
            hint = f"compare it: `{name}({of}) at least ...`"
            self.fault("not-condition", f"`{name}` is {found}, no condition", name, hint)

    def _check_unshadowed(self, new: Iterable[s.Name], names: Names) -> bool:
        free = True
        for name in new:
            if isinstance(self.scope.symbols.get(name.text), SetSymbol):
                free = False
                hint = f"write `each {name}: ...`; `there is` and `each pair` need other names"
                self.fault("each", f"`{name}` is a set already", name, hint)
            elif (
                name.text in names
                or name.text in self.scope.symbols
                or name.text in self.scope.lets
            ):
                free = False
                self.fault("taken", f"`{name}` is named already", name, "choose another name")
        return free

    def _check_each(self, node: s.Each, names: Names) -> None:
        if node.kind is None:
            found = self._find_symbol(node.name, names)
            if not isinstance(found, SetSymbol):
                if found is None:
                    sets = [x.name for x in self.scope.sets]
                    self.fault(
                        "unknown-name",
                        f"there is no set `{node.name}`",
                        node.name,
                        said(node.name.text, sets) or "write `each face x: ...`",
                        make_respelling(node.name, sets),
                    )
                else:
                    self.fault(
                        "set",
                        f"`{node.name}` is one part",
                        node.name,
                        "write `each x of a, b: ...`",
                    )
                return
            local = Local(found.name, found.kinds, found.model)
            self.condition(node.body, {**names, found.name: local})
            return
        kinds = self._find_element_kinds(node.kind)
        if not self._check_unshadowed((node.name,), names) or kinds is None:
            return
        inside = {**names, node.name.text: Local(node.name.text, kinds)}
        if node.where is not None:
            self.condition(node.where, inside)
        self.condition(node.body, inside)

    def _check_range(self, of: tuple[s.Name, ...], names: Names) -> Local | None:
        """Return the range of `of a, b, c` or `of SET`, without a name."""
        kinds: Kinds | None = None
        model = ""
        for name in of:
            found = self._find_symbol(name, names)
            if found is None:
                self._report_unknown(name, names)
                return None
            if isinstance(found, SetSymbol) and len(of) > 1:
                self.fault("set", f"`{name}` is a set and stands alone after `of`", name)
                return None
            if isinstance(found, PartSymbol | Local) and len(of) == 1:
                self.fault("set", f"`{name}` is one part", name, "name several, or a set")
                return None
            kinds = found.kinds if kinds is None else kinds | found.kinds
            model = found.model
        if len({n.text for n in of}) < len(of):
            self.fault("taken", "a part is named twice", of[-1])
        return Local("", kinds or EVERY, model)

    def _check_each_of(self, node: s.EachOf, names: Names) -> None:
        local = self._check_range(node.of, names)
        if local is None or not self._check_unshadowed(node.names, names):
            return
        if len({n.text for n in node.names}) < len(node.names):
            self.fault(
                "taken", "the two of a pair need two names", node.names[-1], "choose another name"
            )
            return
        inside = {n.text: replace(local, name=n.text) for n in node.names}
        self.condition(node.body, {**names, **inside})

    def _check_there(self, node: s.There, names: Names) -> None:
        if node.count is not None:
            self.check_count(node.count)
        if not self._check_unshadowed((node.name,), names):
            return
        named = get_part_kind(node.kind.text, self.scope.roles) if node.of else None
        kinds = named[0] if named is not None else self._find_element_kinds(node.kind)
        if kinds is None:
            return
        local = Local(node.name.text, kinds)
        if node.of:
            found = self._check_range(node.of, names)
            if found is None:
                return
            local = replace(found, name=node.name.text)
        where = self.scope.demanded(node, node.name)
        if where is not None:
            self.condition(where, {**names, node.name.text: local})

    def _find_element_kinds(self, kind: s.Name) -> Kinds | None:
        """Return the kinds that `each` and `there` range over; report an unknown one."""
        found = self.scope.get_element_kinds(kind.text)
        if found is None:
            self.fault(
                "unknown-kind",
                f"`{kind}` is no kind of part",
                kind,
                said(kind.text, ELEMENTS) or SPOKEN_WORDS.get(kind.text, ""),
                make_respelling(kind, ELEMENTS),
            )
        return found
