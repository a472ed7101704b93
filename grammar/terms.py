"""Prolog terms and clauses as values, and their text.

Any name may be written: what is no plain atom is quoted, so no name of a model can become a goal or
collide with a word of Prolog's own.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from facetlog.plain_text import plain_text

WIDTH = 96
"""Columns of a line of Prolog text."""

_PLAIN = re.compile(r"[a-z][A-Za-z0-9_]*\Z")
_INFIX = {
    "*": 400, "/": 400, "+": 500, "-": 500, "==": 700, "\\==": 700, "@<": 700, "=": 700,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Atom:
    """A name."""

    name: str

    def __str__(self) -> str:
        if _PLAIN.match(self.name) or self.name == "[]":
            return self.name
        return f"'{_escape(self.name, chr(39))}'"


@dataclass(frozen=True, slots=True)
class Var:
    """A variable."""

    name: str

    def __str__(self) -> str:
        return self.name


ANYTHING = Var("_")


@dataclass(frozen=True, slots=True)
class Text:
    """A string."""

    value: str

    def __str__(self) -> str:
        return f'"{_escape(self.value, chr(34))}"'


@dataclass(frozen=True, slots=True)
class Struct:
    """A functor with its arguments."""

    functor: str
    args: tuple["Term", ...]

    def __str__(self) -> str:
        return _format_term(self, 1200)


Term: TypeAlias = Atom | Var | Text | Struct | int | float | tuple["Term", ...]
"""A tuple is a list."""


@dataclass(frozen=True, slots=True)
class Clause:
    """A head and the goals of its body, with the place and text of what it was made from."""

    head: Struct
    body: tuple[Term, ...] = ()
    place: str = ""
    says: str = ""

    def __str__(self) -> str:
        """Return the clause as text; a variable that stands once is written _."""
        seen = [v for term in (self.head, *self.body) for v in variables(term)]
        once = {v for v in seen if seen.count(v) == 1}
        head = _drop_single(self.head, once)
        lines = []
        if self.place:
            lines.append(f"% {self.place}  {self.says}".rstrip().replace("\n", " "))
        lead = _lay_out(head, 0)
        if not self.body:
            return "\n".join([*lines, f"{lead}."])
        goals = [_lay_out(_drop_single(goal, once), 4) for goal in self.body]
        lines.append(f"{lead} :-")
        lines.append(",\n".join(f"    {goal}" for goal in goals) + ".")
        return "\n".join(lines)


def variables(term: Term) -> Iterator[Var]:
    """Iterate over the variables of a term, as often as they stand in it."""
    match term:
        case Var():
            if term is not ANYTHING:
                yield term
        case Struct(_, args):
            for arg in args:
                yield from variables(arg)
        case tuple():
            for part in term:
                yield from variables(part)


def _drop_single(term: Term, once: set[Var]) -> Term:
    match term:
        case Var():
            return ANYTHING if term in once else term
        case Struct(functor, args):
            return Struct(functor, tuple(_drop_single(arg, once) for arg in args))
        case tuple():
            return tuple(_drop_single(part, once) for part in term)
        case _:
            return term


def _escape(text: str, quote: str) -> str:
    pieces = []
    for letter in plain_text(text):
        if letter in ("\\", quote):
            pieces.append("\\" + letter)
        elif letter == "\n":
            pieces.append("\\n")
        elif not letter.isprintable():
            pieces.append(f"\\x{ord(letter):x}\\")
        else:
            pieces.append(letter)
    return "".join(pieces)


def _format_number(value: float) -> str:
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    text = repr(value)
    if "e" in text:
        # Prolog wants a point before the exponent.
        mantissa, exponent = text.split("e")
        text = f"{mantissa if '.' in mantissa else mantissa + '.0'}e{exponent}"
    return text


def _format_term(term: Term, priority: int = 999) -> str:
    match term:
        case Struct(functor, (left, right)) if functor in _INFIX:
            own = _INFIX[functor]
            plain = isinstance(left, Var) or (isinstance(left, Struct) and left.functor == "-")
            gap = "" if own <= 400 or (functor == "-" and plain) else " "
            text = f"{_format_term(left, own)}{gap}{functor}{gap}{_format_term(right, own - 1)}"
            return f"({text})" if own > priority else text
        case Struct("-", (operand,)):
            return f"-({_format_term(operand)})"
        case Struct("\\+", (goal,)):
            return f"\\+ {_format_term(goal, 900)}"
        case Struct("[|]", (first, rest)):
            return f"[{_format_term(first)}|{_format_term(rest)}]"
        case Struct("==", (right,)):
            return f"==({_format_term(right)})"
        case Struct(",", goals):
            return f"( {', '.join(map(_format_term, goals))} )"
        case Struct("->;", (test, then, otherwise)):
            return f"( {_format_term(test)} -> {_format_term(then)} ; {_format_term(otherwise)} )"
        case Struct(functor, args):
            return f"{Atom(functor)}({', '.join(map(_format_term, args))})"
        case tuple():
            return f"[{', '.join(map(_format_term, term))}]"
        case int() | float():
            return (
                f"({_format_number(term)})" if term < 0 and priority < 999 else _format_number(term)
            )
        case _:
            return str(term)


def _lay_out(term: Term, column: int) -> str:
    """Return the text of a term, broken after commas where a line would be too long."""
    text = _format_term(term)
    if column + len(text) <= WIDTH:
        return text
    match term:
        case Struct("->;", (test, then, otherwise)):
            pad = " " * column
            return (
                f"(   {_lay_out(test, column + 4)}\n{pad}->  {_lay_out(then, column + 4)}\n"
                f"{pad};   {_lay_out(otherwise, column + 4)}\n{pad})"
            )
        case Struct(",", goals):
            return _break_lines("( ", goals, " )", column)
        case Struct("\\+", (goal,)):
            return f"\\+ {_lay_out(goal, column + 3)}"
        case Struct(functor, args) if functor not in _INFIX and functor != "-":
            return _break_lines(f"{Atom(functor)}(", args, ")", column)
        case tuple():
            return _break_lines("[", term, "]", column)
        case _:
            return text


def _break_lines(opening: str, parts: tuple[Term, ...], closing: str, column: int) -> str:
    """Return arguments in as few lines as hold them, under one another."""
    inside = column + len(opening)
    lines = [""]
    for number, part in enumerate(parts):
        last = number == len(parts) - 1
        text = _lay_out(part, inside) + ("" if last else ",")
        head = text.split("\n", 1)[0]
        if lines[-1] and inside + len(lines[-1].split("\n")[-1]) + 1 + len(head) > WIDTH:
            lines.append(text)
        elif lines[-1]:
            if "\n" in text:
                lines.append(text)
            else:
                lines[-1] += f" {text}"
        else:
            lines[-1] = text
    return opening + ("\n" + " " * inside).join(lines) + closing
