"""Python functions that questions may call as predicates."""

import json
import threading
from collections.abc import Callable, Iterable
from itertools import count, islice
from typing import TypeAlias

from facetlog.kb.engine.terms import Struct, Term, decode_term, format_prolog_term

__all__ = ["PythonPredicate", "called", "forget", "raised", "remember"]

PythonPredicate: TypeAlias = Callable[..., "bool | Iterable[tuple[Term, ...]] | None"]
"""Gets each argument as a term, a Var where it is unbound. Returns whether that holds (None: no),
or the solutions, each a tuple of all arguments."""

MOST_SOLUTIONS = 100_000
"""Solution limit of one call: they are all worked out before the question goes on."""

_functions: dict[int, PythonPredicate] = {}
_exceptions: dict[int, BaseException] = {}
_keys = count(1)
_lock = threading.Lock()


def remember(function: PythonPredicate) -> int:
    """Return the key by which Prolog calls the function from now on."""
    key = next(_keys)
    _functions[key] = function
    return key


def forget(key: int) -> None:
    """Forget the function, which Prolog calls no more."""
    _functions.pop(key, None)


def raised(key: int) -> BaseException | None:
    """Return the exception that a function raised, handed out once."""
    with _lock:
        return _exceptions.pop(key, None)


def called(request: str) -> str:
    """Return the solutions of a call as Prolog text; an exception is kept, and Prolog is given its
    key.

    `request` is JSON, a list of the function's key and its arguments. Never raises.
    """
    try:
        key, *nodes = json.loads(request)
        args = tuple(map(decode_term, nodes))
        found = _functions[key](*args)
        solutions: tuple[tuple[Term, ...], ...]
        if found is None or isinstance(found, bool):
            solutions = (args,) if found else ()
        else:
            solutions = tuple(tuple(row) for row in islice(found, MOST_SOLUTIONS + 1))
            if len(solutions) > MOST_SOLUTIONS:
                raise ValueError(f"a function may give {MOST_SOLUTIONS:,} solutions at most")
        if any(len(row) != len(args) for row in solutions):
            raise ValueError(f"a solution must have {len(args)} values, one for each argument")
        return format_prolog_term(Struct("solutions", (solutions,)))
    except BaseException as exc:
        number = next(_keys)
        with _lock:
            _exceptions[number] = exc
        return format_prolog_term(Struct("raised", (number, f"{type(exc).__name__}: {exc}")))
