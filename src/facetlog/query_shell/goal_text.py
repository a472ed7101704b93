"""Goals as text: their tokens, their calls, and where one ends.

This reads what a user is still typing, so nothing here is an error. What a goal means, and whether
it may be asked, the knowledge base decides.
"""

import re
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum

# A goal that a file spreads over more lines than this is taken for one whose bracket was forgotten.
MOST_LINES = 100

COMMAND = ":"


class TokenKind(StrEnum):
    """Kind of a piece of text."""

    COMMENT = "comment"
    OPEN = "open"  # a quotation or comment that does not end
    NUMBER = "number"
    TEXT = "text"
    NAME = "name"
    VARIABLE = "variable"
    END = "end"
    SYMBOL = "symbol"
    BRACKET = "bracket"
    OTHER = "other"


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of text from `start` to before `end`."""

    kind: TokenKind
    text: str
    start: int
    end: int

    @property
    def functor(self) -> str | None:
        """The name without quotation marks, if it can be a functor.

        >>> [token.functor for token in tokens("'it''s' X")]
        ["it's", None]
        """
        if self.kind is not TokenKind.NAME:
            return None
        return self.text[1:-1].replace("''", "'") if self.text.startswith("'") else self.text


@dataclass(frozen=True, slots=True)
class Call:
    """A term `functor(…)` and the tokens of each argument; `end` is None if it is not closed."""

    functor: str
    start: int
    end: int | None
    arguments: tuple[tuple[Token, ...], ...]


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal and the number of the line where it begins, from 1."""

    text: str
    line: int


# In the order of trial. The end of a goal is a full stop before white space; 0'c is a character.
_TOKEN = re.compile(
    r"""(?P<comment> %[^\n]* | /\*.*?\*/ )
    | (?P<open> /\*.* | '(?:[^'\\]|\\.|'')*\Z | "(?:[^"\\]|\\.|"")*\Z | `(?:[^`\\]|\\.)*\Z )
    | (?P<number> 0'(?:\\.|''|[^'\\]) | \d[\d_]*(?:\.\d+)?(?:[eE][+-]?\d+)? )
    | (?P<text> "(?:[^"\\]|\\.|"")*" | `(?:[^`\\]|\\.)*` )
    | (?P<name> '(?:[^'\\]|\\.|'')*' )
    | (?P<word> \w+ )
    | (?P<end> \.(?=\s|%|\Z) )
    | (?P<symbol> [-+*/\\^<>=~:.?@\#&$]+ | [;,|] )
    | (?P<bracket> [()\[\]{}] )
    | (?P<other> \S )""",
    re.VERBOSE | re.DOTALL,
)
_CLOSES = {")": "(", "]": "[", "}": "{"}


def tokens(text: str) -> tuple[Token, ...]:
    """Split a text into tokens, including comments.

    >>> [str(token.kind) for token in tokens("angle(f1, B) % all")][:3]
    ['name', 'bracket', 'name']
    """
    found = []
    for match in _TOKEN.finditer(text):
        group = match.lastgroup or "other"
        if group == "word":
            first = match.group()[0]
            group = "variable" if first == "_" or first.isupper() else "name"
        found.append(Token(TokenKind(group), match.group(), match.start(), match.end()))
    return tuple(found)


def variables(text: str) -> tuple[str, ...]:
    """Return the variables of a goal in the order of appearance, except those that begin with _."""
    names = (t.text for t in tokens(text) if t.kind is TokenKind.VARIABLE)
    return tuple(dict.fromkeys(name for name in names if not name.startswith("_")))


class _Open:
    """A bracket that is still open, and what has been read in it."""

    def __init__(self, bracket: Token, functor: str | None, start: int) -> None:
        self.bracket, self.functor, self.start = bracket, functor, start
        self.arguments: list[list[Token]] = [[]]

    def call(self, end: int | None) -> Call | None:
        if self.functor is None:
            return None
        return Call(self.functor, self.start, end, tuple(map(tuple, self.arguments)))


def _scan(text: str) -> tuple[list[Call], list[_Open]]:
    closed: list[Call] = []
    stack: list[_Open] = []
    before: Token | None = None
    for token in tokens(text):
        if token.kind is TokenKind.COMMENT:
            continue
        if token.text == "," and stack:
            stack[-1].arguments.append([])
        elif stack and stack[-1].bracket.text == _CLOSES.get(token.text):
            call = stack.pop().call(token.end)
            closed.extend([call] if call else [])
        for level in stack:
            if token.text != "," or level is not stack[-1]:
                level.arguments[-1].append(token)
        if token.kind is TokenKind.BRACKET and token.text in _CLOSES.values():
            named = token.text == "(" and before is not None and before.end == token.start
            functor = before.functor if named and before is not None else None
            stack.append(_Open(token, functor, before.start if before else token.start))
        before = token
    return closed, stack


def calls(text: str) -> tuple[Call, ...]:
    """Find all terms with arguments in a text, inner ones before those around them.

    >>> [(call.functor, len(call.arguments)) for call in calls("holds(near(angle(a, B), 90, 15))")]
    [('angle', 2), ('near', 3), ('holds', 1)]
    """
    closed, stack = _scan(text)
    unfinished = (level.call(None) for level in reversed(stack))
    return (*closed, *(call for call in unfinished if call is not None))


def find_call(text: str, place: int) -> tuple[str, int] | None:
    """Return the functor of the innermost call around a place, and which argument (from 0) is
    there.

    >>> find_call("angle(f1, ", 10)
    ('angle', 1)
    """
    _, stack = _scan(text[:place])
    for level in reversed(stack):
        if level.functor is not None:
            return level.functor, len(level.arguments) - 1
    return None


def is_complete(text: str) -> bool:
    """Return whether a goal may end here: nothing is open, and no operator waits for more.

    >>> is_complete("face(F)"), is_complete("face(F),"), is_complete("face(")
    (True, False, False)
    """
    said = [t for t in tokens(text) if t.kind is not TokenKind.COMMENT]
    if any(t.kind is TokenKind.OPEN for t in said):
        return False
    if not said or said[-1].kind is TokenKind.END:
        return True
    return said[-1].kind is not TokenKind.SYMBOL and not _scan(text)[1]


def split_goals(text: str) -> Iterator[tuple[str, int]]:
    """Split a text at full stops into goals, each with its place.

    >>> list(split_goals("face(F). edge(E, _, _)."))
    [('face(F)', 0), ('edge(E, _, _)', 9)]
    """
    said: list[Token] = []
    for token in tokens(text):
        if token.kind is TokenKind.END:
            if said:
                yield text[said[0].start : said[-1].end], said[0].start
            said = []
        elif token.kind is not TokenKind.COMMENT:
            said.append(token)
    if said:
        yield text[said[0].start : said[-1].end], said[0].start


def goals(lines: Iterable[str]) -> Iterator[Goal]:
    """Read the goals of a file, no further than each needs: one a line, or ended by a full stop.

    A line that begins with a colon is a command of the shell, whatever it holds. A goal that is not
    complete at the end of its line goes on in the next ones. If that leads to an empty line or the
    end of the file, its first line stands alone: a forgotten bracket costs one goal, not all that
    follow.
    """
    source = iter(lines)
    waiting: deque[str] = deque()
    number = 1
    while waiting or _pull(source, waiting):
        if waiting[0].lstrip().startswith(COMMAND):
            yield Goal(waiting.popleft().strip(), number)
            number += 1
            continue
        count = _count_lines(source, waiting)
        text = "".join(waiting.popleft() for _ in range(count))
        for goal, start in split_goals(text):
            yield Goal(goal, number + text.count("\n", 0, start))
        number += count


def _count_lines(source: Iterator[str], waiting: deque[str]) -> int:
    text = ""
    for count in range(1, MOST_LINES + 1):
        if len(waiting) < count and not _pull(source, waiting):
            return 1
        line = waiting[count - 1]
        text += line
        if is_complete(text):
            return count
        if not line.strip():
            return 1
    return 1


def _pull(source: Iterator[str], waiting: deque[str]) -> bool:
    line = next(source, None)
    if line is None:
        return False
    waiting.append(line if line.endswith("\n") else line + "\n")
    return True
