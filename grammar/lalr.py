"""Tokens into syntax, by the table that Lark made of model.lark.

Lark cuts and parses a text token by token in calls that serve every grammar; a thousand models took
it three times as long as they may take. Layout has cut the text already, so this walks Lark's table
with those tokens: a word is a keyword where the table wants that keyword, otherwise a name.
What cannot be parsed here is given to Lark itself, which can say what was expected.
"""

from collections.abc import Callable, Sequence
from typing import Any

from lark import Lark
from lark.grammar import Rule, Terminal
from lark.lexer import PatternStr
from lark.parsers.lalr_analysis import Shift

from facetlog.grammar.layout import Token

__all__ = ["NotParsed", "TableParser"]

_PLAIN = {"word": "NAME", "number": "NUMBER", "string": "STRING"}


class NotParsed(Exception):  # noqa: N818  it is no error of the program
    """The tokens are no statement of the language."""


_Reduction = tuple[int, str, Callable[[list[Any]], Any] | None]
"""How many values become one, of what, and by which function; None hands the value on."""

_Row = dict[str, Any]
"""What to do with each terminal: the row of the next state, or a reduction; of a rule's name the
row of the state that follows it."""


class TableParser:
    """The LALR parser of a Lark grammar, for tokens that layout has cut."""

    def __init__(self, lark: Lark) -> None:
        inner = lark.parser.parser
        table, callbacks = inner._parse_table, inner.parser.callbacks
        reductions: dict[Rule, _Reduction] = {}
        rows: dict[int, _Row] = {state: {} for state in table.states}
        for state, row in table.states.items():
            for terminal, (action, argument) in row.items():
                name = str(terminal)  # Lark's own are tokens, which compare slowly
                if action is Shift:
                    rows[state][name] = rows[argument]
                else:
                    if argument not in reductions:
                        reductions[argument] = _reduction(argument, callbacks[argument])
                    rows[state][name] = reductions[argument]
        self._start = rows[table.start_states["start"]]
        self._end = rows[table.end_states["start"]]
        self._terminals: dict[str, tuple[str, ...]] = {}
        for known in lark.terminals:
            for text in _texts(known.pattern.to_regexp(), known.pattern):
                before = self._terminals.get(text, ())
                self._terminals[text] = (*before, str(known.name))

    def parse(self, tokens: Sequence[Token]) -> Any:
        """What the tokens become. Raises NotParsed if they are no statement.

        The innermost loop of all that reads models: without calls, without a look at numbers of
        states. 170,000 tokens of a thousand models make 270,000 reductions.
        """
        row = self._start
        rows, values = [row], []  # type: ignore[var-annotated]
        terminals, end = self._terminals, self._end
        for token in (*tokens, None):
            if token is None:
                name = "$END"
            else:
                # A keyword where one may stand.
                name = next((n for n in terminals.get(token.text, ()) if n in row), "")
                name = name or _PLAIN.get(token.kind, "")
            action = row.get(name)
            while action.__class__ is tuple:
                size, origin, make = action
                if size:
                    del rows[-size:]
                if make is not None:
                    if size:
                        some = values[-size:]
                        del values[-size:]
                        values.append(make(some))
                    else:
                        values.append(make([]))
                row = rows[-1][origin]
                rows.append(row)
                if row is end:
                    return values[-1]
                action = row.get(name)
            if action is None:
                raise NotParsed
            row = action
            rows.append(row)
            values.append(token)
        raise NotParsed


def _reduction(rule: Rule, make: Callable[[list[Any]], Any]) -> _Reduction:
    size, first = len(rule.expansion), next(iter(rule.expansion), None)
    # A `?rule` of one part is that part; parts named _x are put in, which Lark's function does.
    hands_on = (
        size == 1
        and rule.options.expand1
        and rule.alias is None
        and first is not None
        and not first.name.startswith("_")
        and not (isinstance(first, Terminal) and first.filter_out)
    )
    return size, str(rule.origin.name), None if hands_on else make


def _texts(regexp: str, pattern: object) -> tuple[str, ...]:
    """The texts of a terminal that is a fixed text, or one of some."""
    if isinstance(pattern, PatternStr):
        return (pattern.value,)
    choices = regexp.removeprefix("(?:").removesuffix(")").split("|")
    fixed = [choice.replace("\\", "") for choice in choices]
    return tuple(fixed) if all(len(text) <= 3 and not text[0].isalnum() for text in fixed) else ()
