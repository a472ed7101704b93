"""Syntax trees as indented text."""

from collections.abc import Iterator
from dataclasses import fields
from enum import StrEnum

from facetlog.grammar import syntax as s
from facetlog.grammar.source import Source
from facetlog.grammar.traversal import Node

__all__ = ["outline"]


def outline(file: s.File) -> Iterator[str]:
    """The syntax tree of a file, a line for each node: what it is, its place, its plain values."""
    for node in (*file.statements, *file.models):
        yield from _outline(node, file.source, 0, "")


def _outline(node: Node, source: Source, depth: int, role: str) -> Iterator[str]:
    line, column = source.line_and_column(node.span.start)
    plain: list[str] = []
    inner: list[tuple[str, Node]] = []
    for field in fields(node):
        value = getattr(node, field.name)
        if field.name == "span" or value is None or value is False or value == ():
            continue
        many = value if isinstance(value, tuple) else (value,)
        if all(hasattr(one, "span") for one in many):
            inner.extend((field.name, one) for one in many)
        else:
            shown = value.value if isinstance(value, StrEnum) else value
            plain.append(f"{field.name}={shown!r}")
    head = f"{role}: " if role else ""
    values = f" {' '.join(plain)}" if plain else ""
    yield f"{'  ' * depth}{head}{type(node).__name__} {line}:{column}{values}"
    for name, one in inner:
        yield from _outline(one, source, depth + 1, name)
