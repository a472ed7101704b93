"""The program's Prolog files, kept as one compiled file in the user's cache."""

import hashlib
import logging
import platform
import tempfile
from pathlib import Path
from typing import Protocol

from facetlog.cache_folder import CacheFolder
from facetlog.kb.engine.terms import Atom, format_prolog_term

__all__ = ["PROGRAM_CODE", "load_program"]

PROGRAM_CODE = ("rules/*.pl", "kb/prolog/**/*.pl", "kb/engine/*.pl")

_LOG = logging.getLogger(__name__)


class Runner(Protocol):
    """SWI-Prolog, as far as it is needed here."""

    def run(self, module: str, predicate: str, *files: Path) -> bool:
        """Return whether a predicate succeeds."""
        ...


def load_program(engine: Runner, version: tuple[int, ...], root: Path) -> bool:
    """Return whether bridge.pl and what it loads are loaded, compiled or from their text.

    SWI-Prolog ends the process on a damaged file: it sees none that was not checked.
    """
    bridge = root / "kb" / "prolog" / "bridge.pl"
    cache = CacheFolder()
    if cache.folder is not None:
        try:
            if _load_compiled(engine, cache, _compute_digest(version, root), bridge):
                return True
        except (OSError, ValueError) as exc:
            _LOG.info("the Prolog files are loaded from their text: %s", exc)
    return engine.run("user", "consult", bridge)


def _load_compiled(engine: Runner, cache: CacheFolder, digest: str, bridge: Path) -> bool:
    if not engine.run("user", "use_module", bridge.parents[1] / "engine" / "program.pl"):
        return False
    path = cache.place(f"{digest}.scene")
    content = cache.read(path)
    with tempfile.TemporaryDirectory(prefix="facetlog-") as folder:
        compiled = Path(folder) / "program.qlf"
        if path is not None and content is not None:
            compiled.write_bytes(content)
            cache.mark_used(path)
            return engine.run("facetlog_program", "load_program", compiled, bridge)
        source = compiled.with_suffix(".pl")
        load = f":- encoding(utf8).\n:- consult({format_prolog_term(Atom(str(bridge)))}).\n"
        source.write_text(load, encoding="utf-8")
        if not engine.run("facetlog_program", "save_program", source):
            return False
        cache.write(path, compiled.read_bytes())
        return True


def _compute_digest(version: tuple[int, ...], root: Path) -> str:
    """Return a digest of all that a compiled file follows from, as far as SWI-Prolog does not check
    it itself.
    """
    total = hashlib.sha256(repr((version, platform.machine(), str(root))).encode())
    for pattern in PROGRAM_CODE:
        for path in sorted(root.glob(pattern)):
            total.update(f"\n{path}\n".encode() + path.read_bytes())
    return total.hexdigest()
