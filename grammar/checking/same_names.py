"""Models of one name in several files, which cannot be loaded together."""

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.faults import Fault, Severity

__all__ = ["SameNames"]

_MODEL = re.compile(r"^[ \t]*model[ \t]+(\w+)", re.MULTILINE)


class SameNames:
    """Finds models that another of the given files defines, too; reads each file once."""

    def __init__(self, read: Callable[[Path], str], given: Iterable[Path]) -> None:
        self._read, self._given = read, tuple(given)
        self._names: dict[Path, frozenset[str]] = {}

    def faults(self, analysis: Analysis) -> Iterator[Fault]:
        """Warn of each model of a file whose name another file's model has."""
        apart = [other for other in self._given if other not in analysis.library.files]
        for model in analysis.file.models:
            found = next((other for other in apart if model.name.text in self._models(other)), None)
            if found is not None:
                yield _fault(analysis, model, found)

    def _models(self, path: Path) -> frozenset[str]:
        if path not in self._names:
            try:
                text = self._read(path)
            except (OSError, ValueError):  # its own check says so
                text = ""
            self._names[path] = frozenset(_MODEL.findall(text))
        return self._names[path]


def _fault(analysis: Analysis, model: s.Model, other: Path) -> Fault:
    message = f"`{model.name}` is a model of {other}, too"
    hint = "rename one of them: both cannot be loaded together"
    source, span = analysis.file.source, model.name.span
    return Fault("same-name", message, source, span, hint, Severity.WARNING)
