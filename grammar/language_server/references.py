"""Where a symbol stands, in all files that may know it."""

from collections.abc import Iterator
from pathlib import Path

from facetlog.grammar.language_server.project import Project
from facetlog.grammar.language_server.symbols import Occurrence, Symbol, SymbolKind

__all__ = ["references"]


def references(project: Project, symbol: Symbol, origin: Path) -> Iterator[tuple[Path, Occurrence]]:
    """All places of a symbol, file by file: first the one `origin`."""
    for path in _files(project, symbol, origin):
        for one in project.symbols(path).of(symbol):
            yield path, one


def _files(project: Project, symbol: Symbol, origin: Path) -> Iterator[Path]:
    yield origin
    if symbol.kind in (SymbolKind.LOCAL, SymbolKind.UNIT, SymbolKind.BUILDER):
        return
    others = list(project.files_that_say(symbol.name))
    if symbol.home is not None and symbol.home.path.suffix == ".model":
        # It may lie outside of the workspace.
        others.append(symbol.home.path)
    yield from (path for path in dict.fromkeys(others) if path != origin)
