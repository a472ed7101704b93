"""Terms of Prolog as nested tuples (functor, arguments...), and their text."""

from __future__ import annotations

import math

__all__ = ["Term", "mentions", "prolog"]

Term = object


def prolog(term: Term) -> str:
    """Return the text of a term."""
    if isinstance(term, tuple):
        return f"'{term[0]}'({','.join(map(prolog, term[1:]))})"
    if isinstance(term, list):
        return f"[{','.join(map(prolog, term))}]"
    if isinstance(term, float) and math.isinf(term):
        return "1.0Inf" if term > 0 else "-1.0Inf"
    return repr(term) if isinstance(term, float) else str(term)


def mentions(term: Term, functor: str) -> bool:
    """Return whether a compound with this functor stands in the term."""
    if isinstance(term, tuple) and term[0] == functor:
        return True
    return isinstance(term, (tuple, list)) and any(mentions(part, functor) for part in term)
