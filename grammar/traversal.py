"""Traversal of the syntax tree: the nodes inside a node, and copies moved in the text."""

from dataclasses import Field, fields
from typing import Any, TypeAlias, get_args

from facetlog.grammar.source import Span
from facetlog.grammar.syntax import (
    Ancestry,
    Comparator,
    Count,
    CountKind,
    Expression,
    Model,
    Name,
    Outcome,
    SceneBuilt,
    SceneFile,
    Setting,
    Solid,
    Stated,
    Statement,
    Text,
)

Node: TypeAlias = (
    Name
    | Text
    | Count
    | Setting
    | Stated
    | Solid
    | SceneFile
    | SceneBuilt
    | Expression
    | Statement
    | Model
)
"""Any node of the tree."""

_LEAVES = frozenset({str, bool, float, type(None), Outcome, Ancestry, Comparator, CountKind})
"""Types of fields that hold no node."""

_FIELDS: dict[type, tuple[tuple[str, str], ...]] = {}


def children(node: object) -> "list[Node]":
    """Return the nodes directly inside a node, in the order of their fields."""
    found: list[Node] = []
    for name, holds in _get_fields(node.__class__):
        value = getattr(node, name)
        if holds == "many":
            found += value
        elif holds == "one" and value is not None:
            found.append(value)
    return found


def walk(node: object) -> "list[Node]":
    """Return a node and all nodes inside it, outer ones first."""
    found: list[Node] = []
    waiting = [node]
    while waiting:
        one = waiting.pop()
        found.append(one)  # type: ignore[arg-type]
        waiting += reversed(children(one))
    return found


def moved(node: Any, by: int) -> Any:
    """Return a copy of a node, with all inside it, so many letters further on in its text."""
    values = []
    for name, holds in _get_fields(node.__class__):
        value = getattr(node, name)
        # A node without a place, as a name that was left out, keeps none.
        if holds == "span" and value.end:
            value = Span(value.start + by, value.end + by)
        elif holds == "one" and value is not None:
            value = moved(value, by)
        elif holds == "many":
            value = tuple([moved(one, by) for one in value])
        values.append(value)
    return node.__class__(*values)


def _get_fields(kind: Any) -> tuple[tuple[str, str], ...]:
    """Return the fields of a kind of node, and what each holds.

    That is its `span`, a `leaf` without a place, `one` node or None, or `many` nodes.
    """
    found = _FIELDS.get(kind)
    if found is None:
        found = tuple((field.name, _get_holding(field)) for field in fields(kind))
        _FIELDS[kind] = found
    return found


def _get_holding(field: "Field[Any]") -> str:
    if field.name == "span":
        return "span"
    if str(field.type).strip("\"'").startswith("tuple"):
        return "many"
    kinds = get_args(field.type) or (field.type,)
    return "leaf" if field.name == "source" or _LEAVES.issuperset(kinds) else "one"
