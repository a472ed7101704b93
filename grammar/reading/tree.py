"""Trees into syntax: what each rule of model.lark becomes.

The parser calls these methods as it reduces, with what the parts of a rule have become; a part that
may be left out and is comes as None.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from lark import Token

from facetlog.grammar import syntax as s
from facetlog.grammar.source import NOWHERE, Span

Parts = list[Any]
Make = Callable[[object, Parts], Any]
"""A method of TreeToSyntax: what the parts of a rule become."""


def _span(parts: Parts) -> Span:
    given = [part for part in parts if part is not None]
    return Span(_end_of(given[0], 0), _end_of(given[-1], -1))


def _end_of(part: Any, side: int) -> int:
    if isinstance(part, tuple):
        return _end_of(part[side], side)
    if isinstance(part, Token):
        return (part.start_pos if side == 0 else part.end_pos) or 0
    return part.span[side]  # type: ignore[no-any-return]


def _name(token: Token) -> s.Name:
    return s.Name(str(token), _span([token]))


def _maybe_name(token: Token | None) -> s.Name | None:
    return None if token is None else _name(token)


def _text(token: Token | None) -> s.Text | None:
    return None if token is None else s.Text(str(token)[1:-1], _span([token]))


def _make_words(_: object, parts: Parts) -> s.Name:
    """Return several words that stand for one."""
    return s.Name(" ".join(parts), _span(parts))


def _make_first(_: object, parts: Parts) -> Any:
    return parts[0]


def _make_count(kind: s.CountKind) -> Make:
    def make(_: object, parts: Parts) -> s.Count:
        low, high = (_name(parts[0]), _name(parts[-1])) if parts else (None, None)
        return s.Count(kind, low, high, _span(parts) if parts else NOWHERE)

    return make


def _make_comparison(comparator: s.Comparator) -> Make:
    def make(_: object, parts: Parts) -> s.Comparison:
        measure, limit, *rest = parts
        if comparator is s.Comparator.BETWEEN:
            limit = _share_alike(limit, rest[0])
        if comparator in (s.Comparator.AT_LEAST, s.Comparator.AT_MOST):
            rest = [None, *rest]
        second, fading = (*rest, None, None)[:2]
        sharp = isinstance(fading, Token)
        width = None if sharp else fading
        return s.Comparison(comparator, measure, limit, second, width, _span(parts), sharp)

    return make


def _share_alike(low: s.Expression, high: s.Expression) -> s.Expression:
    """Return the lower limit of `between 20 % and 80 % of x`, whose `of x` belongs to both."""
    match low, high:
        case s.Quantity(_, unit), s.Share(s.Quantity(_, other), whole) if (
            unit is not None and other is not None and unit.text == other.text == "%"
        ):
            return s.Share(low, whole, low.span)
    return low


def _make_arithmetic(sign: str) -> Make:
    return lambda _, parts: s.Arithmetic(sign, parts[0], parts[1], _span(parts))


def _make_there(*, some: bool) -> Make:
    def make(_: object, parts: Parts) -> s.There:
        kind, name, of, where = parts[-1]
        count = parts[1] if len(parts) > 2 else None
        span = _span([parts[0], kind, name, of, where])
        return s.There(some, count, kind, _name(name), of or (), where, span)

    return make


def _make_outcome(outcome: s.Outcome) -> Make:
    def make(_: object, parts: Parts) -> tuple[s.Outcome, s.Quantity | None, tuple[s.Name, ...]]:
        if outcome is s.Outcome.HOLDS:
            return outcome, parts[0], ()
        return outcome, None, parts[0] or ()

    return make


class TreeToSyntax:
    """Makes the node of each rule, by its name or its alias."""

    # -------------------------------------------------------- statements

    start = where = because = fading = _make_first
    kind = member = how = _make_words

    def use(self, parts: Parts) -> s.Use:
        return s.Use(_text(parts[0]), _span(parts))  # type: ignore[arg-type]

    def ancestry(self, parts: Parts) -> s.Ancestry:
        return s.Ancestry(str(parts[0]))

    def model(self, parts: Parts) -> s.Model:
        name, ancestry, parent, others = parts
        span = _span([name, parent, others])
        return s.Model(_name(name), ancestry, _maybe_name(parent), others or (), None, (), span)

    def doc(self, parts: Parts) -> s.Text:
        return _text(parts[0])  # type: ignore[return-value]

    def let(self, parts: Parts) -> s.Let:
        name, value, doc = parts
        return s.Let(_name(name), value, _text(doc), _span(parts))

    def define(self, parts: Parts) -> s.Define:
        name, parameters, body, doc = parts
        return s.Define(_name(name), parameters, body, _text(doc), _span(parts))

    def drop(self, parts: Parts) -> s.Drop:
        return s.Drop(parts[0], _span(list(parts[0])))

    def part(self, parts: Parts) -> s.Part:
        optional, kind, names, where, reason = parts
        span = _span(parts)
        said = _text(reason)
        return s.Part(optional is not None, None, False, kind, names, where, said, span)

    def one_object(self, parts: Parts) -> s.Part:
        optional, kind, name, where, reason = parts
        return self.part([optional, _name(kind), (_name(name),), where, reason])

    def parts(self, parts: Parts) -> s.Part:
        optional, count, separate, kind, name, where, reason = parts
        return s.Part(
            optional is not None,
            count,
            separate is not None,
            kind,
            (_name(name),),
            where,
            _text(reason),
            _span([kind, name]),
        )

    count_at_least = _make_count(s.CountKind.AT_LEAST)
    count_at_most = _make_count(s.CountKind.AT_MOST)
    count_exactly = _make_count(s.CountKind.EXACTLY)
    count_between = _make_count(s.CountKind.BETWEEN)
    count_any = _make_count(s.CountKind.ANY)

    def strength(self, parts: Parts) -> str:
        return " ".join(parts)

    def expect(self, parts: Parts) -> str:
        return parts[0] or ""

    def if_known(self, _: Parts) -> bool:
        return True

    def line(self, parts: Parts) -> s.Line:
        label, expect, if_known, condition, reason = parts
        span = _span([label, condition, reason])
        return s.Line(
            _maybe_name(label),
            expect,
            if_known is not None,
            condition,
            _text(reason),
            span,
        )

    def size(self, parts: Parts) -> s.Size:
        names, *measures, longest_first = parts
        span = _span([names, *measures, longest_first])
        return s.Size(names, tuple(measures), longest_first is not None, span)

    def example(self, parts: Parts) -> s.Example:
        title, scene, (outcome, at_least, because) = parts
        span = _span([title, scene, at_least, because or None])
        text = _text(title)
        return s.Example(text, scene, outcome, at_least, because, span)  # type: ignore[arg-type]

    def scene_file(self, parts: Parts) -> s.SceneFile:
        path, *stated = parts
        given = tuple(p for p in stated if p is not None)
        return s.SceneFile(_text(path), given, _span(parts))  # type: ignore[arg-type]

    def stated(self, parts: Parts) -> s.Stated:
        name, value = parts
        return s.Stated(_name(name), s.Text(str(value), _span([value])), _span(parts))

    def stated_downwards(self, parts: Parts) -> s.Stated:
        name, axis = parts
        return s.Stated(_name(name), s.Text(f"-{axis}", _span([axis])), _span(parts))

    def stated_text(self, parts: Parts) -> s.Stated:
        name, value = parts
        return s.Stated(_name(name), _text(value), _span(parts))  # type: ignore[arg-type]

    def built(self, parts: Parts) -> s.SceneBuilt:
        return s.SceneBuilt(tuple(parts), _span(parts))

    def solid(self, parts: Parts) -> s.Solid:
        name, *settings = parts
        given = tuple(p for p in settings if p is not None)
        return s.Solid(_name(name), given, _span([name, *given]))

    def setting(self, parts: Parts) -> s.Setting:
        return s.Setting(_name(parts[0]), parts[1], _span(parts))

    holds = _make_outcome(s.Outcome.HOLDS)
    fails = _make_outcome(s.Outcome.FAILS)
    unknown = _make_outcome(s.Outcome.UNKNOWN)

    def names(self, parts: Parts) -> tuple[s.Name, ...]:
        return tuple(map(_name, parts))

    # -------------------------------------------------------- conditions

    def all(self, parts: Parts) -> s.Expression:
        if len(parts) == 1:
            return parts[0]  # type: ignore[no-any-return]
        return s.And(tuple(parts), _span(parts))

    def both(self, parts: Parts) -> s.Expression:
        return s.And(tuple(parts), _span(parts))

    def either(self, parts: Parts) -> s.Expression:
        first, second = parts
        # `a or b or c` is one choice of three.
        before = first.conditions if isinstance(first, s.Or) else (first,)
        return s.Or((*before, second), _span(parts))

    def negation(self, parts: Parts) -> s.Not:
        return s.Not(parts[1], _span(parts))

    def each_member(self, parts: Parts) -> s.Each:
        _, name, body = parts
        return s.Each(None, _name(name), None, body, _span(parts))

    def each_element(self, parts: Parts) -> s.Each:
        _, kind, name, where, body = parts
        return s.Each(kind, _name(name), where, body, _span(parts))

    def each_of(self, parts: Parts) -> s.EachOf:
        _, name, of, body = parts
        return s.EachOf((_name(name),), of, body, _span(parts))

    def each_pair(self, parts: Parts) -> s.EachOf:
        _, first, second, of, body = parts
        names = (_name(first), _name(second))
        return s.EachOf(names, of, body, _span(parts))

    def some_of(self, parts: Parts) -> Parts:
        return parts

    there_is = there_are = _make_there(some=True)
    there_is_no = _make_there(some=False)

    equal = _make_comparison(s.Comparator.EQUAL)
    at_least = _make_comparison(s.Comparator.AT_LEAST)
    at_most = _make_comparison(s.Comparator.AT_MOST)
    between = _make_comparison(s.Comparator.BETWEEN)
    about = _make_comparison(s.Comparator.ABOUT)

    def property(self, parts: Parts) -> s.Property:
        return s.Property(parts[0], _name(parts[1]), False, _span(parts))

    def property_not(self, parts: Parts) -> s.Property:
        return s.Property(parts[0], _name(parts[2]), True, _span(parts))

    def relation(self, parts: Parts) -> s.Relation:
        left, name, right = parts
        return s.Relation(left, _name(name), right, _span(parts))

    # ---------------------------------------------------------- measures

    plus = _make_arithmetic("+")
    minus = _make_arithmetic("-")
    times = _make_arithmetic("*")
    divided = _make_arithmetic("/")

    def share_of(self, parts: Parts) -> s.Share:
        return s.Share(parts[0], parts[1], _span(parts))

    def aggregate(self, parts: Parts) -> s.Expression:
        how, operand = parts
        return s.Aggregate(how.text, operand, _span(parts))

    def negative(self, parts: Parts) -> s.Negative:
        return s.Negative(parts[0], _span(parts))

    def bracket(self, parts: Parts) -> s.Expression:
        opening, inner, closing = parts
        return replace(inner, span=_span([opening, closing]))  # type: ignore[no-any-return]

    def quantity(self, parts: Parts) -> s.Quantity:
        number, unit = parts
        return s.Quantity(_name(number), _maybe_name(unit), _span(parts))

    def reference(self, parts: Parts) -> s.Reference:
        name = _name(parts[0])
        return s.Reference(name, name.span)

    def member_part(self, parts: Parts) -> s.Member:
        owner, part = map(_name, parts)
        return s.Member(owner, part, owner.span.to(part.span))

    def call(self, parts: Parts) -> s.Call:
        name, *arguments = parts
        given = tuple(a for a in arguments if a is not None)
        span = _span([name, *given])
        return s.Call(_name(name), given, Span(span.start, span.end + 1))
