"""What a knowledge base has loaded."""

from dataclasses import dataclass
from pathlib import Path

__all__ = ["LoadedScene", "RuleFile"]


@dataclass(frozen=True, slots=True)
class RuleFile:
    """A loaded file of rules: its Prolog module and the models that it defines.

    `warnings` are what looks like a slip of the pen, each with file, line and column.
    """

    path: Path
    module: str
    models: tuple[str, ...]
    trusted: bool = False
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LoadedScene:
    """A scene whose facts are in the knowledge base.

    `facts` is how many there are; `length_unit` is 'm', or None where the scale is not known.
    """

    name: str
    module: str
    facts: int
    length_unit: str | None
