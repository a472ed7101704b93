"""Tests of numbers and names on arrays, which say what Prolog would say of each row."""

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np

from facetlog.kb.arrays.plan_terms import (
    Argument,
    Compare,
    Constant,
    Expression,
    Operation,
    Order,
    Variable,
)
from facetlog.kb.arrays.values import Kind, Mask, Names, NotOnArraysError, Values
from facetlog.kb.engine.columns import EXACT
from facetlog.kb.engine.terms import Atom

__all__ = ["passing"]

_Numbers: TypeAlias = Any  # a float, or an array of them

_COMPARISONS: dict[str, Callable[[_Numbers, _Numbers], Any]] = {
    "<": np.less,
    "=<": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "=:=": np.equal,
    "=\\=": np.not_equal,
    "@<": np.less,
    "@=<": np.less_equal,
    "@>": np.greater,
    "@>=": np.greater_equal,
    "==": np.equal,
    "\\==": np.not_equal,
}

_OPERATIONS: dict[tuple[str, int], Callable[..., _Numbers]] = {
    ("+", 2): np.add,
    ("-", 2): np.subtract,
    ("*", 2): np.multiply,
    ("/", 2): np.divide,
    ("-", 1): np.negative,
    ("abs", 1): np.abs,
}


def passing(test: Compare | Order, values: Mapping[int, Values], length: int, names: Names) -> Mask:
    """Of which rows the test holds; NotOnArraysError where Prolog may say something else."""
    if isinstance(test, Compare):
        left, _ = _number(test.left, values)
        right, _ = _number(test.right, values)
    else:
        left, right = _name(test.left, values, names), _name(test.right, values, names)
        if test.functor.startswith("@"):
            left, right = names.ranks[left], names.ranks[right]
    return np.broadcast_to(_COMPARISONS[test.functor](left, right), (length,))


def _name(argument: Argument, values: Mapping[int, Values], names: Names) -> Any:
    if isinstance(argument, Variable):
        found = values[argument.number]
        if found.kind is not Kind.NAME:
            raise NotOnArraysError
        return found.data
    if not isinstance(argument.value, Atom):
        raise NotOnArraysError
    return names.place(argument.value.name)


def _number(expression: Expression, values: Mapping[int, Values]) -> tuple[_Numbers, bool]:
    """What it comes to, and whether Prolog may have it as an integer.

    Doubles are the same here and there. Integers are exact here as long as a double holds them.
    """
    match expression:
        case Constant(int() | float() as value):
            return float(value), isinstance(value, int)
        case Variable(number):
            found = values[number]
            return found.exact_floats(), found.kind is Kind.INTEGER
        case Operation(functor, operands):
            parts = [_number(operand, values) for operand in operands]
            whole = all(integer for _, integer in parts)
            with np.errstate(all="ignore"):
                result = _OPERATIONS[functor, len(parts)](*(part for part, _ in parts))
            # Of integers an array has no longer ones; what is not finite is an error of Prolog's.
            if not (np.abs(result) <= EXACT if whole else np.isfinite(result)).all():
                raise NotOnArraysError
            return result, whole
    raise NotOnArraysError
