"""Trees into syntax: what each rule of model.lark becomes.

The parser calls these methods as it reduces, with what the parts of a rule have become; a part that
may be left out and is comes as None.
"""

from dataclasses import replace
from typing import Any

from lark import Token

from facetlog.grammar import syntax as s
from facetlog.grammar.source import NOWHERE, Span

Parts = list[Any]


class TreeToSyntax:
    """What each rule becomes, by its name or its alias."""

    # ------------------------------------------------------------ places

    def _span(self, parts: Parts) -> Span:
        first = next(part for part in parts if part is not None)
        last = next(part for part in reversed(parts) if part is not None)
        return Span(self._start(first), self._end(last))

    def _start(self, part: Any) -> int:
        if isinstance(part, Token):
            return part.start_pos or 0
        return self._start(part[0]) if isinstance(part, tuple) else part.span.start

    def _end(self, part: Any) -> int:
        if isinstance(part, Token):
            return part.end_pos or 0
        return self._end(part[-1]) if isinstance(part, tuple) else part.span.end

    def _name(self, token: Token) -> s.Name:
        return s.Name(str(token), self._span([token]))

    def _maybe_name(self, token: Token | None) -> s.Name | None:
        return None if token is None else self._name(token)

    def _text(self, token: Token | None) -> s.Text | None:
        if token is None:
            return None
        return s.Text(str(token)[1:-1], self._span([token]))

    def _words(self, parts: Parts) -> s.Name:
        """Several words that stand for one."""
        return s.Name(" ".join(parts), self._span(parts))

    # -------------------------------------------------------- statements

    def start(self, parts: Parts) -> object:
        return parts[0]

    def use(self, parts: Parts) -> s.Use:
        return s.Use(self._text(parts[0]), self._span(parts))  # type: ignore[arg-type]

    def ancestry(self, parts: Parts) -> s.Ancestry:
        return s.Ancestry(str(parts[0]))

    def model(self, parts: Parts) -> s.Model:
        name, ancestry, parent, others = parts
        span = self._span([name, parent, others])
        return s.Model(
            self._name(name), ancestry, self._maybe_name(parent), others or (), None, (), span
        )

    def doc(self, parts: Parts) -> s.Text:
        return self._text(parts[0])  # type: ignore[return-value]

    def let(self, parts: Parts) -> s.Let:
        name, value, doc = parts
        return s.Let(self._name(name), value, self._text(doc), self._span(parts))

    def define(self, parts: Parts) -> s.Define:
        name, parameters, body, doc = parts
        return s.Define(self._name(name), parameters, body, self._text(doc), self._span(parts))

    def drop(self, parts: Parts) -> s.Drop:
        return s.Drop(parts[0], self._span(list(parts[0])))

    def kind(self, parts: Parts) -> s.Name:
        return self._words(parts)

    def member(self, parts: Parts) -> s.Name:
        return self._words(parts)

    def where(self, parts: Parts) -> s.Expression:
        return parts[0]  # type: ignore[no-any-return]

    def part(self, parts: Parts) -> s.Part:
        optional, kind, names, where, reason = parts
        span = self._span(parts)
        said = self._text(reason)
        return s.Part(optional is not None, None, False, kind, names, where, said, span)

    def one_object(self, parts: Parts) -> s.Part:
        optional, kind, name, where, reason = parts
        return self.part([optional, self._name(kind), (self._name(name),), where, reason])

    def parts(self, parts: Parts) -> s.Part:
        optional, count, separate, kind, name, where, reason = parts
        return s.Part(
            optional is not None,
            count,
            separate is not None,
            kind,
            (self._name(name),),
            where,
            self._text(reason),
            self._span([kind, name]),
        )

    def _count(self, kind: s.CountKind, parts: Parts) -> s.Count:
        low = self._name(parts[0]) if parts else None
        high = self._name(parts[-1]) if parts else None
        span = self._span(parts) if parts else NOWHERE
        return s.Count(kind, low, high, span)

    def count_at_least(self, parts: Parts) -> s.Count:
        return self._count(s.CountKind.AT_LEAST, parts)

    def count_at_most(self, parts: Parts) -> s.Count:
        return self._count(s.CountKind.AT_MOST, parts)

    def count_exactly(self, parts: Parts) -> s.Count:
        return self._count(s.CountKind.EXACTLY, parts)

    def count_between(self, parts: Parts) -> s.Count:
        return self._count(s.CountKind.BETWEEN, parts)

    def count_any(self, parts: Parts) -> s.Count:
        return self._count(s.CountKind.ANY, parts)

    def strength(self, parts: Parts) -> str:
        return " ".join(parts)

    def expect(self, parts: Parts) -> str:
        return parts[0] or ""

    def if_known(self, _: Parts) -> bool:
        return True

    def line(self, parts: Parts) -> s.Line:
        label, expect, if_known, condition, reason = parts
        span = self._span([label, condition, reason])
        return s.Line(
            self._maybe_name(label),
            expect,
            if_known is not None,
            condition,
            self._text(reason),
            span,
        )

    def size(self, parts: Parts) -> s.Size:
        names, *measures, longest_first = parts
        span = self._span([names, *measures, longest_first])
        return s.Size(names, tuple(measures), longest_first is not None, span)

    def example(self, parts: Parts) -> s.Example:
        title, scene, (outcome, at_least, because) = parts
        span = self._span([title, scene, at_least, because or None])
        text = self._text(title)
        return s.Example(text, scene, outcome, at_least, because, span)  # type: ignore[arg-type]

    def scene_file(self, parts: Parts) -> s.SceneFile:
        return s.SceneFile(self._text(parts[0]), self._span(parts))  # type: ignore[arg-type]

    def built(self, parts: Parts) -> s.SceneBuilt:
        name, *settings = parts
        given = tuple(p for p in settings if p is not None)
        return s.SceneBuilt(self._name(name), given, self._span([name, *given]))

    def setting(self, parts: Parts) -> s.Setting:
        return s.Setting(self._name(parts[0]), parts[1], self._span(parts))

    def holds(self, parts: Parts) -> tuple[s.Outcome, object, tuple[s.Name, ...]]:
        return s.Outcome.HOLDS, parts[0], ()

    def fails(self, parts: Parts) -> tuple[s.Outcome, object, tuple[s.Name, ...]]:
        return s.Outcome.FAILS, None, parts[0] or ()

    def unknown(self, parts: Parts) -> tuple[s.Outcome, object, tuple[s.Name, ...]]:
        return s.Outcome.UNKNOWN, None, parts[0] or ()

    def because(self, parts: Parts) -> tuple[s.Name, ...]:
        return parts[0]  # type: ignore[no-any-return]

    def names(self, parts: Parts) -> tuple[s.Name, ...]:
        return tuple(map(self._name, parts))

    # -------------------------------------------------------- conditions

    def all(self, parts: Parts) -> s.Expression:
        if len(parts) == 1:
            return parts[0]  # type: ignore[no-any-return]
        return s.And(tuple(parts), self._span(parts))

    def both(self, parts: Parts) -> s.Expression:
        return s.And(tuple(parts), self._span(parts))

    def either(self, parts: Parts) -> s.Expression:
        first, second = parts
        # `a or b or c` is one choice of three.
        before = first.conditions if isinstance(first, s.Or) else (first,)
        return s.Or((*before, second), self._span(parts))

    def negation(self, parts: Parts) -> s.Not:
        return s.Not(parts[1], self._span(parts))

    def each_member(self, parts: Parts) -> s.Each:
        _, name, body = parts
        return s.Each(None, self._name(name), None, body, self._span(parts))

    def each_element(self, parts: Parts) -> s.Each:
        _, kind, name, where, body = parts
        return s.Each(kind, self._name(name), where, body, self._span(parts))

    def each_of(self, parts: Parts) -> s.EachOf:
        _, name, of, body = parts
        return s.EachOf((self._name(name),), of, body, self._span(parts))

    def each_pair(self, parts: Parts) -> s.EachOf:
        _, first, second, of, body = parts
        names = (self._name(first), self._name(second))
        return s.EachOf(names, of, body, self._span(parts))

    def some_of(self, parts: Parts) -> Parts:
        return parts

    def there_is(self, parts: Parts) -> s.There:
        return self._there(True, None, parts)

    def there_is_no(self, parts: Parts) -> s.There:
        return self._there(False, None, parts)

    def there_are(self, parts: Parts) -> s.There:
        return self._there(True, parts[1], parts)

    def _there(self, some: bool, count: s.Count | None, parts: Parts) -> s.There:
        kind, name, of, where = parts[-1]
        span = self._span([parts[0], kind, name, of, where])
        return s.There(some, count, kind, self._name(name), of or (), where, span)

    def _compared(self, comparator: s.Comparator, parts: Parts) -> s.Comparison:
        measure, limit, *rest = parts
        second, fading = (None, None, *rest)[-2:]
        sharp = isinstance(fading, Token)
        width = None if sharp else fading
        return s.Comparison(comparator, measure, limit, second, width, self._span(parts), sharp)

    def equal(self, parts: Parts) -> s.Comparison:
        return self._compared(s.Comparator.EQUAL, parts)

    def at_least(self, parts: Parts) -> s.Comparison:
        measure, limit, fading = parts
        return self._compared(s.Comparator.AT_LEAST, [measure, limit, None, fading])

    def at_most(self, parts: Parts) -> s.Comparison:
        measure, limit, fading = parts
        return self._compared(s.Comparator.AT_MOST, [measure, limit, None, fading])

    def between(self, parts: Parts) -> s.Comparison:
        return self._compared(s.Comparator.BETWEEN, parts)

    def about(self, parts: Parts) -> s.Comparison:
        return self._compared(s.Comparator.ABOUT, [*parts, None, None])

    def fading(self, parts: Parts) -> s.Expression | Token:
        return parts[0]  # type: ignore[no-any-return]

    def property(self, parts: Parts) -> s.Property:
        return s.Property(parts[0], self._name(parts[1]), False, self._span(parts))

    def property_not(self, parts: Parts) -> s.Property:
        return s.Property(parts[0], self._name(parts[2]), True, self._span(parts))

    def relation(self, parts: Parts) -> s.Relation:
        left, name, right = parts
        return s.Relation(left, self._name(name), right, self._span(parts))

    # ---------------------------------------------------------- measures

    def _arithmetic(self, sign: str, parts: Parts) -> s.Arithmetic:
        return s.Arithmetic(sign, parts[0], parts[1], self._span(parts))

    def plus(self, parts: Parts) -> s.Arithmetic:
        return self._arithmetic("+", parts)

    def minus(self, parts: Parts) -> s.Arithmetic:
        return self._arithmetic("-", parts)

    def times(self, parts: Parts) -> s.Arithmetic:
        return self._arithmetic("*", parts)

    def divided(self, parts: Parts) -> s.Arithmetic:
        return self._arithmetic("/", parts)

    def share_of(self, parts: Parts) -> s.Share:
        return s.Share(parts[0], parts[1], self._span(parts))

    def how(self, parts: Parts) -> s.Name:
        return self._words(parts)

    def aggregate(self, parts: Parts) -> s.Expression:
        how, operand = parts
        return s.Aggregate(how.text, operand, self._span(parts))

    def negative(self, parts: Parts) -> s.Negative:
        return s.Negative(parts[0], self._span(parts))

    def bracket(self, parts: Parts) -> s.Expression:
        opening, inner, closing = parts
        return replace(inner, span=self._span([opening, closing]))  # type: ignore[no-any-return]

    def quantity(self, parts: Parts) -> s.Quantity:
        number, unit = parts
        return s.Quantity(self._name(number), self._maybe_name(unit), self._span(parts))

    def reference(self, parts: Parts) -> s.Reference:
        name = self._name(parts[0])
        return s.Reference(name, name.span)

    def member_part(self, parts: Parts) -> s.Member:
        owner, part = map(self._name, parts)
        return s.Member(owner, part, owner.span.to(part.span))

    def call(self, parts: Parts) -> s.Call:
        name, *arguments = parts
        given = tuple(a for a in arguments if a is not None)
        span = self._span([name, *given])
        return s.Call(self._name(name), given, Span(span.start, span.end + 1))
