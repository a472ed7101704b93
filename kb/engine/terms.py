"""Prolog terms as Python values, and their text, quoted and escaped.

Any name may be written, and no text can become a goal.
"""

import json
import math
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import TypeAlias

from facetlog.errors import EngineError

__all__ = [
    "Atom",
    "Failure",
    "Struct",
    "Term",
    "Var",
    "decode_reply",
    "decode_term",
    "decode_terms",
    "format_integer",
    "format_prolog_term",
]

TOO_DEEP = "the answer is nested too deeply"


@dataclass(frozen=True, slots=True)
class Atom:
    """A Prolog atom; a Python `str` is a Prolog string."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class Var:
    """A Prolog variable."""

    name: str


@dataclass(frozen=True, slots=True)
class Struct:
    """A compound term."""

    functor: str
    args: tuple["Term", ...]


@dataclass(frozen=True, slots=True)
class Failure:
    """Error that a request reports.

    `kind` is question, rules, limit, python or prolog; `place` says where, as that kind needs.
    """

    kind: str
    message: str
    place: tuple[object, ...] = ()


Term: TypeAlias = "Atom | Var | Struct | str | int | float | Fraction | tuple[Term, ...]"
"""A tuple is a proper list; a Fraction a rational number."""


def _escape_text(text: str, quote: str) -> str:
    # \x41\ is ISO's escape: it needs no fixed number of digits, and takes NUL. Beyond ASCII the
    # character itself is written: SWI-Prolog 9.0.4 refuses some escapes of high planes.
    if text.isascii() and text.isprintable() and quote not in text and "\\" not in text:
        return text
    return "".join(
        f"\\{c}"
        if c in (quote, "\\")
        else c
        if " " <= c <= "~" or c > "\xa0"
        else f"\\x{ord(c):x}\\"
        for c in text
    )


def format_integer(value: int) -> str:
    """Return the integer in decimal digits, however many there are."""
    # int() turns True, which is an int, into 1. Beyond some thousands of digits Python refuses to
    # write an int, but not a Decimal.
    return str(int(value)) if abs(value) < 1 << 4096 else f"{Decimal(value):f}"


def _number(value: float) -> str:
    if isinstance(value, int):
        return format_integer(value)
    if not math.isfinite(value):
        return "1.5NaN" if math.isnan(value) else "1.0Inf" if value > 0 else "-1.0Inf"
    text = repr(float(value))
    mantissa, e, exponent = text.partition("e")  # Prolog wants 1.0e-05, Python writes 1e-05
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}{e}{exponent}"


def format_prolog_term(term: Term) -> str:
    """Return the term in Prolog syntax, on one line.

    >>> format_prolog_term(Struct("near", (Struct("angle", (Atom("f1"), Var("X"))), 90, 15.0)))
    "'near'('angle'('f1',X),90,15.0)"
    """
    match term:
        case Atom(name):
            return f"'{_escape_text(name, chr(39))}'"
        case Var(name):
            if not (
                name.isascii() and name.isidentifier() and (name[0] == "_" or name[0].isupper())
            ):
                raise ValueError(f"{name!r} is no name of a Prolog variable")
            return name
        case str():
            return f'"{_escape_text(term, chr(34))}"'
        case Fraction(numerator=n, denominator=d):
            return f"{format_integer(n)}r{format_integer(d)}"
        case int() | float():
            return _number(term)
        case Struct(functor, args):
            inner = ",".join(map(format_prolog_term, args))
            return f"'{_escape_text(functor, chr(39))}'({inner})"
        case tuple():
            return f"[{','.join(map(format_prolog_term, term))}]"


def decode_term(node: object) -> Term:
    """Return the term that json.pl wrote, from its JSON as Python reads it."""
    match node:
        case bool():
            raise EngineError(f"Prolog's reply cannot be read: {node!r}")
        case int() | float():
            return node
        case list():
            return tuple(decode_term(item) for item in node)
        case {"a": str(name)}:
            return Atom(name)
        case {"s": str(text)} | {"x": str(text)}:
            return text
        case {"v": str(name)}:
            return Var(name)
        case {"i": str(digits)}:
            return int(digits, 16)
        case {"r": [str(numerator), str(denominator)]}:
            return Fraction(int(numerator, 16), int(denominator, 16))
        case {"n": str(text)}:
            return float(text)
        case {"f": str(functor), "t": list(args)}:
            return Struct(functor, tuple(decode_term(a) for a in args))
    raise EngineError(f"Prolog's reply cannot be read: {node!r}")


def decode_terms(text: str) -> list[Term]:
    """Return the terms of a list in JSON; EngineError for one that is nested deeper than Python
    reads."""
    try:
        return [decode_term(node) for node in json.loads(text)]
    except RecursionError:
        raise EngineError(TOO_DEEP) from None


def decode_reply(reply: str) -> "Term | Failure":
    """Return the result of a request as a term, or the failure that it reports.

    The reply is the JSON with which bridge.pl begins each reply.
    """
    try:
        match json.loads(reply):
            case ["ok", result]:
                return decode_term(result)
            case ["error", str(kind), str(message), list(place)]:
                return Failure(kind, message, tuple(place))
    except RecursionError:
        raise EngineError(TOO_DEEP) from None
    raise EngineError("Prolog's reply cannot be read")
