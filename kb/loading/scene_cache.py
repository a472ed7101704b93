"""Cache of loaded scenes and models, as files of compiled clauses that load ten times as fast as
text: the facts of scenes, and models that were specialised for a batch.

SWI-Prolog ends the process on a damaged file of its own: it sees none that was not checked
(cache_folder.py).
"""

import hashlib
import json
import logging
import struct
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from facetlog.cache_folder import PART, CacheFolder
from facetlog.errors import EngineError
from facetlog.kb.engine.engine import house
from facetlog.kb.engine.terms import Atom, Struct, Term, format_prolog_term
from facetlog.perception.facts.fact_schema import FACT_SCHEMA

__all__ = ["Ask", "SceneCache", "compute_schema_hash"]

Ask = Callable[[str, str], Term]
"""Sends Prolog an operation and its text; raises EngineError where that fails."""

LOADING_CODE = (
    "loading/encode.py",
    "loading/fact_columns.py",
    "prolog/schema.pl",
    "prolog/scenes/*.pl",
)

# A file: the head, the compiled facts. The head is the number of facts, where in the compiled facts
# the module's name stands, and how many bytes it takes there.
_HEAD = struct.Struct(">QQQ")

# SWI-Prolog writes 7-bit numbers as one byte: the top bit, and the number doubled.
_LONGEST_NAME = 63
# The name stands behind the paths of file and build; a path has at most 4096 bytes.
_NAME_WITHIN = 3 * 4096

_LOG = logging.getLogger(__name__)


def compute_schema_hash() -> str:
    """Return a digest of all facts, their arguments and units."""
    declared = [
        (k.functor, [(a.name, a.kind.value) for a in k.arguments], k.meaning) for k in FACT_SCHEMA
    ]
    return hashlib.sha256(json.dumps(declared).encode()).hexdigest()


@cache
def compute_loading_code_hash() -> str:
    """Return a digest of the code that turns facts into the clauses of a scene."""
    total = hashlib.sha256()
    for pattern in LOADING_CODE:
        for path in sorted(house("kb").glob(pattern)):
            total.update(path.read_bytes())
    return total.hexdigest()


class SceneCache:
    """A folder of compiled scenes; each method that fails says so, and none of them raises."""

    def __init__(self, folder: Path | None = None, *, most_bytes: int | None = None) -> None:
        self._files = CacheFolder(folder, most_bytes=most_bytes)

    @property
    def folder(self) -> Path | None:
        """The folder; None if there is no cache."""
        return self._files.folder

    def path(self, content_key: str, identity: str, schema: str | None = None) -> Path | None:
        """Return the file of a scene; None if there is no cache.

        `content_key` says what the facts were made from and by what, `identity` is that of the
        Prolog (operation cache_identity).
        """
        schema = compute_schema_hash() if schema is None else schema
        parts = [content_key, identity, schema, compute_loading_code_hash()]
        digest = hashlib.sha256(json.dumps(parts).encode("ascii"))
        return self._files.place(f"{digest.hexdigest()}.scene")

    def load(
        self, path: Path | None, module: str, ask: Ask, operation: str = "load_saved_scene"
    ) -> int | None:
        """Return the number of facts loaded from the file into a fresh scene; None if it has none
        yet.

        Or, by another operation, of clauses into another module.
        """
        content = self._files.read(path)
        facts = None if content is None else _rename_module(content, module)
        if path is None or facts is None:
            return None
        count, compiled = facts
        try:
            with tempfile.NamedTemporaryFile(suffix=PART) as file:
                file.write(compiled)
                file.flush()
                request = Struct("load", (Atom(module), Atom(file.name), count))
                loaded = ask(operation, format_prolog_term(request)) == Atom("true")
        except (OSError, EngineError) as exc:
            _LOG.info("%s: cannot be loaded: %s", path, exc)
            return None
        if loaded:
            self._files.mark_used(path)
        return count if loaded else None

    def save(self, path: Path | None, module: str, ask: Ask, operation: str = "save_scene") -> bool:
        """Return whether the facts of a loaded scene were written to the file, or other clauses."""
        if path is None:
            return False
        try:
            with tempfile.TemporaryDirectory(prefix="facetlog-") as folder:
                compiled = Path(folder) / "scene.qlf"
                request = Struct("save", (Atom(module), Atom(str(compiled))))
                count = ask(operation, format_prolog_term(request))
                facts = compiled.read_bytes()
        except (OSError, EngineError) as exc:
            _LOG.info("%s: cannot be written: %s", path, exc)
            return False
        content = _encode_content(path, module, facts, count)
        return content is not None and self._files.write(path, content)


def _encode_module_name(module: str) -> bytes | None:
    """Return a module's name as SWI-Prolog writes it at the head of a compiled module."""
    if not module.isascii() or not 0 < len(module) <= _LONGEST_NAME:
        return None
    return b"M\x03" + bytes((0x80 | len(module) << 1,)) + module.encode("ascii")


def _encode_content(path: Path, module: str, facts: bytes, count: Term) -> bytes | None:
    """Return the content of a file, None if the compiled facts have another form than is known."""
    name = _encode_module_name(module)
    where = -1 if name is None else facts.find(name, 0, _NAME_WITHIN)
    if name is None or where < 0 or not isinstance(count, int):
        _LOG.info("%s: this SWI-Prolog compiles in another form", path)
        return None
    return _HEAD.pack(count, where, len(name)) + facts


def _rename_module(content: bytes, module: str) -> tuple[int, bytes] | None:
    """Return the number of facts and the compiled facts as those of another module, None if its
    name is too long.
    """
    name = _encode_module_name(module)
    if name is None:
        return None
    count, where, length = _HEAD.unpack_from(content)
    facts = memoryview(content)[_HEAD.size :]
    return count, b"".join((facts[:where], name, facts[where + length :]))
