"""Prolog terms as a reader writes them, and as JSON."""

import math
import re
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from facetlog.kb.engine.terms import Atom, Struct, Term, Var, format_prolog_term

# Names that need no quotation marks: words that begin with a small letter, symbols, and a few more.
_PLAIN = re.compile(r"[^\W\d_A-Z]\w*|[-+*/\\^<>=~:.?@#&$]+|\[\]|!|;|\{\}")

# Operators between their arguments, with SWI-Prolog's priority: an argument of the same or a higher
# one stands in brackets. Those of words are set apart by spaces.
_BETWEEN = {
    ":-": 1200, "->": 1050, ";": 1100, "=": 700, "<": 700, ">": 700, "=<": 700, ">=": 700,
    "==": 700, "=:=": 700, "=\\=": 700, "\\=": 700, "is": 700, ":": 200, "+": 500, "-": 500,
    "*": 400, "/": 400, "mod": 400, "**": 200, "^": 200,
}  # fmt: skip
_CHAINED = frozenset({"+", "-", "*", "/", "mod"})
ARGUMENT = 999


def visible(text: str) -> str:
    """Replace control characters, which would steer a terminal.

    >>> visible("a\\x1b[2J")
    'a�[2J'
    """
    return text if text.isprintable() else "".join(c if c.isprintable() else "�" for c in text)


def shown(term: Term) -> str:
    """Format a term exactly, with few quotation marks and operators between their arguments.

    >>> shown(Struct("-", (Atom("f1"), Struct("angle", (Atom("A b"), 90, 1.5)))))
    "f1-angle('A b', 90, 1.5)"
    """
    return _format_term(term, ARGUMENT)


def _format_term(term: Term, most: int) -> str:
    match term:
        case Atom(name):
            # Beside an operator, symbols would be read as one with it.
            word = name[:1].isalnum() and name not in _BETWEEN
            return _format_name(term) if word or most >= ARGUMENT else f"({_format_name(term)})"
        case Struct("[|]", (head, tail)):  # a list whose end is not known
            items = [head]
            while isinstance(tail, Struct) and tail.functor == "[|]" and len(tail.args) == 2:
                head, tail = tail.args
                items.append(head)
            return f"[{_join_terms(items)}|{_format_term(tail, ARGUMENT)}]"
        case Struct(functor, (left, right)) if functor in _BETWEEN:
            priority = _BETWEEN[functor]
            space = " " if priority >= 700 or functor.isalpha() else ""
            # A chain as a-b-c is one of differences: (a-b)-c.
            before = _format_term(left, priority if functor in _CHAINED else priority - 1)
            text = f"{before}{space}{functor}{space}{_format_term(right, priority - 1)}"
            return text if priority <= most else f"({text})"
        case Struct(functor, args):
            return f"{_format_name(Atom(functor))}({_join_terms(args)})"
        case tuple():
            return f"[{_join_terms(term)}]"
        case int() | float() if most < ARGUMENT and term < 0:
            return f"({format_prolog_term(term)})"
    return format_prolog_term(term)


def _join_terms(terms: Iterable[Term]) -> str:
    return ", ".join(_format_term(term, ARGUMENT) for term in terms)


def _format_name(atom: Atom) -> str:
    return atom.name if _PLAIN.fullmatch(atom.name) else format_prolog_term(atom)


def convert_term(term: Term) -> Any:
    """Convert a term to plain data: numbers and lists as such, atoms as text, all else as an
    object.

    >>> convert_term((Atom("f1"), 2, Struct("-", (Atom("a"), "text"))))
    ['f1', 2, {'functor': '-', 'args': ['a', {'string': 'text'}]}]
    """
    match term:
        case Atom(name):
            return name
        case str():
            return {"string": term}
        case Fraction(numerator=n, denominator=d):
            return {"rational": f"{n}/{d}"}
        case float() if not math.isfinite(term):
            return {"float": str(term)}  # JSON has no such numbers
        case int() | float():
            return term
        case Var(name):
            return {"variable": name}
        case Struct(functor, args):
            return {"functor": functor, "args": [convert_term(arg) for arg in args]}
        case tuple():
            return [convert_term(item) for item in term]
