"""Models for tests of lint: a sound one, and the faults of a changed one."""

from pathlib import Path

from facetlog.grammar.analysis import analyse
from facetlog.grammar.faults import Fault, Severity

__all__ = ["codes", "complete", "errors", "faults_in", "faults_of"]


def faults_of(text: str) -> tuple[Fault, ...]:
    """All faults of a text."""
    return analyse(Path("test.model"), text).faults


def complete(body: str, name: str = "thing_made_up", doc: str = "What it is.") -> str:
    """A model with some statements, a text and an example."""
    lines = "\n".join(f"  {line.strip()}" for line in body.strip().splitlines())
    return f'model {name}\n  "{doc}"\n{lines}\n  example "one" of cuboid() fails\n'


def faults_in(body: str) -> tuple[Fault, ...]:
    """The faults of one model with such statements."""
    return faults_of(complete(body))


def codes(body: str) -> list[str]:
    """Their codes."""
    return [f.code for f in faults_in(body)]


def errors(body: str) -> list[str]:
    """The codes of those that are errors."""
    return [f.code for f in faults_in(body) if f.severity is Severity.ERROR]
