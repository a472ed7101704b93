"""Tokens into syntax, by the table that Lark made of model.lark.

Lark cuts and parses a text token by token in calls that serve every grammar; a thousand models took
it three times as long as they may take. Layout has cut the text already, so this walks Lark's table
with those tokens: a word is a keyword where the table wants that keyword, otherwise a name.
What cannot be parsed here is given to Lark itself, which can say what was expected.
"""

from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Any

from lark import Lark
from lark.grammar import Rule, Terminal
from lark.lexer import PatternStr
from lark.parsers.lalr_analysis import Shift

from facetlog.grammar.reading.layout import Token

__all__ = ["NotParsed", "TableParser"]

# Keys of a row that are no token's text, for none begins with a blank.
_KINDS = {"word": " NAME", "piece": " PIECE", "number": " NUMBER", "string": " STRING"}
_END = " $END"


class NotParsed(Exception):  # noqa: N818  it is no error of the program
    """The tokens are no statement of the language."""


Make = Callable[[list[Any]], Any]
"""What the values of a rule's parts become."""

_Reduction = tuple[int, str, Make | None]
"""How many values become one, the key of the rule, and the maker; None hands the one value on."""

_Row = dict[Hashable, Any]
"""What a state does with a token: the row of the next state or a reduction, by the token's text or
its kind; of a rule the row that follows it. Besides, where reductions that only hand on lead, by
the row that they begin in (its id) and the token's key: entered when that is first met."""


_Pick = tuple[int | None, bool]
"""A part by its number, or None for one that was left out; whether its own parts stand for it."""


class TableParser:
    """The LALR parser of a Lark grammar, for tokens that layout has cut.

    `rules` has a method for each rule, by its name or its alias, which takes the list of what its
    parts have become. Parts named _x stand for their own parts.
    """

    def __init__(self, lark: Lark, rules: object) -> None:
        table = lark.parser.parser._parse_table
        texts: dict[str, tuple[str, ...]] = {
            str(known.name): _texts(known.pattern.to_regexp(), known.pattern)
            for known in lark.terminals
        }
        reductions: dict[Rule, _Reduction] = {}
        rows: dict[int, _Row] = {state: {} for state in table.states}
        for state, row in table.states.items():
            for symbol, (action, argument) in row.items():
                if action is Shift:
                    found: Any = rows[argument]
                else:
                    if argument not in reductions:
                        reductions[argument] = _reduction(argument, rules)
                    found = reductions[argument]
                for key in _keys(str(symbol), texts):
                    rows[state].setdefault(key, found)
        self._start = rows[table.start_states["start"]]
        self._end = rows[table.end_states["start"]]

    def parse(self, tokens: Sequence[Token]) -> Any:
        """What the tokens become. Raises NotParsed if they are no statement.

        The innermost loop of all that reads models: without calls, without a look at numbers of
        states. 170,000 tokens of a thousand models make 270,000 reductions, most of which hand on.
        """
        row = self._start
        rows, values = [row], []  # type: ignore[var-annotated]
        end = self._end
        for token in (*tokens, None):
            if token is None:
                key = _END
            else:
                key = token[1]
                if key not in row:  # no keyword here
                    key = _KINDS.get(token[0], "")
            action = row.get(key)
            while action.__class__ is tuple:
                size, origin, make = action
                if make is None:
                    under = rows[-2]
                    way = id(row), key
                    found = under.get(way)
                    if found is None:
                        found = under[way] = _handed_on(under, origin, key)
                    row, action = found
                    rows[-1] = row
                    continue
                if size:
                    del rows[-size:]
                    some = values[-size:]
                    del values[-size:]
                    values.append(make(some))
                else:
                    values.append(make([]))
                row = rows[-1][origin]
                rows.append(row)
                if row is end:
                    return values[-1]
                action = row.get(key)
            if action is None:
                raise NotParsed
            row = action
            rows.append(row)
            values.append(token)
        raise NotParsed


def _keys(symbol: str, texts: dict[str, tuple[str, ...]]) -> tuple[str, ...]:
    """How the tokens of a terminal, or a rule, are found in a row."""
    return texts.get(symbol) or (f" {symbol}",)


def _handed_on(under: _Row, origin: str, key: str) -> tuple[_Row, Any]:
    """The row above another after reductions that only hand on, and what is to be done there."""
    while True:
        row = under[origin]
        action = row.get(key)
        if action.__class__ is not tuple or action[2] is not None:
            return row, action
        origin = action[1]


# ------------------------------------------------------------------ reductions


def _reduction(rule: Rule, rules: object) -> _Reduction:
    name = str(rule.origin.name)
    picks = tuple(_picks(rule))
    size = len(rule.expansion)
    whole = picks == tuple((i, False) for i in range(size))
    # A `?rule` of one part is that part.
    alone = rule.options.expand1 and rule.alias is None
    if name.startswith("_"):
        method: Make | None = None
    elif alone and whole and size == 1:
        return size, f" {name}", None
    else:
        # What always is one part needs no method.
        method = getattr(rules, str(rule.alias or name), *((None,) if alone else ()))
    return size, f" {name}", _make(method, None if whole else picks, alone=alone)


def _picks(rule: Rule) -> Iterator[_Pick]:
    """The parts of a rule that count."""
    symbols = iter(enumerate(rule.expansion))
    for left_out in rule.options.empty_indices or (False,) * len(rule.expansion):
        if left_out:
            yield None, False
            continue
        i, symbol = next(symbols)
        if rule.options.keep_all_tokens or not (isinstance(symbol, Terminal) and symbol.filter_out):
            yield i, not symbol.is_term and symbol.name.startswith("_")


def _make(method: Make | None, picks: tuple[_Pick, ...] | None, *, alone: bool) -> Make:
    """A method of the parts that are picked (None: all), or these parts themselves."""
    if picks is None:
        return method or list

    def make(values: list[Any]) -> Any:
        parts: list[Any] = []
        for i, inner in picks:
            if i is None:
                parts.append(None)
            elif inner:
                parts += values[i]
            else:
                parts.append(values[i])
        if alone and len(parts) == 1:
            return parts[0]
        return parts if method is None else method(parts)

    return make


def _texts(regexp: str, pattern: object) -> tuple[str, ...]:
    """The texts of a terminal that is a fixed text, or one of some."""
    if isinstance(pattern, PatternStr):
        return (pattern.value,)
    choices = regexp.removeprefix("(?:").removesuffix(")").split("|")
    fixed = [choice.replace("\\", "") for choice in choices]
    return tuple(fixed) if all(len(text) <= 3 and not text[0].isalnum() for text in fixed) else ()
