"""Tokens into syntax, by the table that Lark made of model.lark.

Lark cuts and parses a text token by token in calls that serve every grammar; a thousand models took
it three times as long as they may take. Layout has cut the text already, so this walks Lark's table
with those tokens: a word is a keyword where the table wants that keyword, otherwise a name.
What cannot be parsed here is given to Lark itself, which can say what was expected.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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


@dataclass(frozen=True, slots=True)
class _Reduction:
    """How many values become one, of what, and by which function; None hands the value on."""

    size: int
    origin: str
    make: Callable[[list[Any]], Any] | None


Action = int | _Reduction
"""The next state, or a reduction."""


class TableParser:
    """The LALR parser of a Lark grammar, for tokens that layout has cut."""

    def __init__(self, lark: Lark) -> None:
        inner = lark.parser.parser
        table, callbacks = inner._parse_table, inner.parser.callbacks
        self._start = table.start_states["start"]
        self._end = table.end_states["start"]
        reductions: dict[Rule, _Reduction] = {}
        self._states: dict[int, dict[str, Action]] = {}
        for state, row in table.states.items():
            actions: dict[str, Action] = {}
            for terminal, (action, argument) in row.items():
                name = str(terminal)  # Lark's own are tokens, which compare slowly
                if action is Shift:
                    actions[name] = argument
                else:
                    if argument not in reductions:
                        reductions[argument] = _reduction(argument, callbacks[argument])
                    actions[name] = reductions[argument]
            self._states[state] = actions
        self._terminals: dict[str, tuple[str, ...]] = {}
        for known in lark.terminals:
            for text in _texts(known.pattern.to_regexp(), known.pattern):
                before = self._terminals.get(text, ())
                self._terminals[text] = (*before, str(known.name))

    def parse(self, tokens: Sequence[Token]) -> Any:
        """What the tokens become. Raises NotParsed if they are no statement."""
        states, values = [self._start], []  # type: ignore[var-annotated]
        table = self._states
        row = table[self._start]
        for token in tokens:
            name = self._terminal(token, row)
            action = row.get(name)
            while isinstance(action, _Reduction):
                row = self._reduce(action, states, values)
                action = row.get(name)
            if action is None:
                raise NotParsed
            states.append(action)
            values.append(token)
            row = table[action]
        while True:
            action = row.get("$END")
            if not isinstance(action, _Reduction):
                raise NotParsed
            row = self._reduce(action, states, values)
            if states[-1] == self._end:
                return values[-1]

    def _terminal(self, token: Token, row: dict[str, Action]) -> str:
        """What a token is in a state: a keyword where one may stand."""
        for name in self._terminals.get(token.text, ()):
            if name in row:
                return name
        return _PLAIN.get(token.kind, "")

    def _reduce(
        self, action: _Reduction, states: list[int], values: list[Any]
    ) -> dict[str, Action]:
        size = action.size
        if size:
            del states[-size:]
        if action.make is not None:
            some = values[-size:] if size else []
            if size:
                del values[-size:]
            values.append(action.make(some))
        state = self._states[states[-1]][action.origin]
        states.append(state)  # type: ignore[arg-type]
        return self._states[state]  # type: ignore[index]


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
    return _Reduction(size, str(rule.origin.name), None if hands_on else make)


def _texts(regexp: str, pattern: object) -> tuple[str, ...]:
    """The texts of a terminal that is a fixed text, or one of some."""
    if isinstance(pattern, PatternStr):
        return (pattern.value,)
    choices = regexp.removeprefix("(?:").removesuffix(")").split("|")
    fixed = [choice.replace("\\", "") for choice in choices]
    return tuple(fixed) if all(len(text) <= 3 and not text[0].isalnum() for text in fixed) else ()
