"""Cache of loaded scenes and models, as files of compiled clauses that load ten times as fast as
text: the facts of scenes, and models that were specialised for a batch.

A file is only ever a copy of what can be made again: whatever is wrong with it, the folder or the
disk, the facts are loaded the long way, and a new file is written. SWI-Prolog ends the process on a
damaged file of its own, so each has a SHA-256 over all of it, checked before Prolog sees it.
"""

import hashlib
import json
import logging
import os
import stat
import struct
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from facetlog.errors import EngineError
from facetlog.kb.engine.engine import house
from facetlog.kb.engine.terms import Atom, Struct, Term, format_prolog_term
from facetlog.perception.facts.fact_schema import FACT_SCHEMA

__all__ = [
    "Ask",
    "SceneCache",
    "cache_folder",
    "compute_schema_hash",
    "get_default_folder",
    "replace_file",
]

Ask = Callable[[str, str], Term]
"""Sends Prolog an operation and its text; raises EngineError where that fails."""

MOST_BYTES = 512 << 20
"""Size limit of the folder: some 15 million facts of 34 bytes, hundreds of scenes."""

MOST_SCENE_BYTES = MOST_BYTES // 4
"""One scene must not push out all others."""

STALE_SECONDS = 3600.0
"""A half-written file of this age has nobody left who writes it."""

LOADING_CODE = (
    "loading/encode.py",
    "loading/fact_columns.py",
    "prolog/schema.pl",
    "prolog/scenes/*.pl",
)

OFF = "off"
"""The value of FACETLOG_CACHE that forbids any cache."""

# A file: the magic, the digest of all that follows, the head, the compiled facts.
_MAGIC = b"facetlog scene 1\n"
_DIGEST_BYTES = hashlib.sha256().digest_size
# The key's digest, the number of facts, where in the compiled facts the module's name stands, and
# how many bytes it takes there.
_HEAD = struct.Struct(f">{_DIGEST_BYTES}sQQQ")

# SWI-Prolog writes 7-bit numbers as one byte: the top bit, and the number doubled.
_LONGEST_NAME = 63
# The name stands behind the paths of file and build; a path has at most 4096 bytes.
_NAME_WITHIN = 3 * 4096

_SUFFIX, _PART = ".scene", ".part"
_WRITABLE_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH

_LOG = logging.getLogger(__name__)


def get_default_folder(name: str = "scenes") -> Path:
    """Return facetlog/NAME in XDG_CACHE_HOME, which must be absolute, or in ~/.cache."""
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path("~/.cache").expanduser()) / "facetlog" / name


def cache_folder(name: str, folder: Path | None = None) -> Path | None:
    """Return that folder or NAME in the user's cache, made if need be; None for no cache at all.

    Raise OSError or RuntimeError (no home directory) for one that is not the user's alone.
    """
    if os.environ.get("FACETLOG_CACHE", "").lower() == OFF:
        return None
    return _make_private_folder(get_default_folder(name) if folder is None else Path(folder))


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


@dataclass(frozen=True, slots=True)
class _Saved:
    """The checked content of a file."""

    count: int
    before: bytes
    after: bytes

    def named(self, module: str) -> bytes | None:
        """Return the compiled facts as those of another module, None if its name is too long."""
        name = _encode_module_name(module)
        return None if name is None else b"".join((self.before, name, self.after))


def _encode_module_name(module: str) -> bytes | None:
    """Return a module's name as SWI-Prolog writes it at the head of a compiled module."""
    if not module.isascii() or not 0 < len(module) <= _LONGEST_NAME:
        return None
    return b"M\x03" + bytes((0x80 | len(module) << 1,)) + module.encode("ascii")


class SceneCache:
    """A folder of compiled scenes; each method that fails says so, and none of them raises.

    The default folder is made for its owner alone. One that another user owns or may write to is
    not used, and a warning is logged once. `FACETLOG_CACHE=off` in the environment turns it off.
    """

    def __init__(self, folder: Path | None = None, *, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self.folder: Path | None = None
        try:
            self.folder = cache_folder("scenes", folder)
        except (OSError, RuntimeError) as exc:  # no home directory is a RuntimeError
            _LOG.warning("scenes are not cached: %s", exc)

    def path(self, content_key: str, identity: str, schema: str | None = None) -> Path | None:
        """Return the file of a scene; None if there is no cache.

        `content_key` says what the facts were made from and by what, `identity` is that of the
        Prolog (operation cache_identity).
        """
        if self.folder is None:
            return None
        schema = compute_schema_hash() if schema is None else schema
        parts = [content_key, identity, schema, compute_loading_code_hash()]
        digest = hashlib.sha256(json.dumps(parts).encode("ascii"))
        return self.folder / f"{digest.hexdigest()}{_SUFFIX}"

    def load(
        self, path: Path | None, module: str, ask: Ask, operation: str = "load_saved_scene"
    ) -> int | None:
        """Return the number of facts loaded from the file into a fresh scene; None if it has none
        yet.

        Or, by another operation, of clauses into another module.
        """
        saved = None if path is None else _read_verified(path)
        if path is None or saved is None:
            return None
        facts = saved.named(module)
        if facts is None:
            return None
        try:
            with tempfile.NamedTemporaryFile(suffix=_PART) as file:
                file.write(facts)
                file.flush()
                request = Struct("load", (Atom(module), Atom(file.name), saved.count))
                loaded = ask(operation, format_prolog_term(request)) == Atom("true")
            if loaded:
                os.utime(path)  # the oldest go first
        except (OSError, EngineError) as exc:
            _LOG.info("%s: cannot be loaded: %s", path, exc)
            return None
        return saved.count if loaded else None

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
            content = _content(path, module, facts, count)
            if content is None or len(content) > min(MOST_SCENE_BYTES, self._most_bytes):
                return False
            replace_file(path, content)
            self._evict_oldest(path.parent)
        except (OSError, EngineError) as exc:
            _LOG.info("%s: cannot be written: %s", path, exc)
            return False
        return True

    def _evict_oldest(self, folder: Path) -> None:
        """Delete half-written files, and those not used for longest until the rest fits."""
        files = []
        with os.scandir(folder) as entries:
            for entry in entries:
                try:
                    status = entry.stat(follow_symlinks=False)
                except OSError:  # another process deleted it
                    continue
                if entry.name.endswith(_SUFFIX):
                    files.append((status.st_mtime_ns, status.st_size, entry.path))
                elif entry.name.endswith(_PART) and time.time() - status.st_mtime > STALE_SECONDS:
                    _delete_quietly(Path(entry.path))
        total = sum(size for _, size, _ in files)
        for _, size, path in sorted(files):
            if total <= self._most_bytes:
                break
            _delete_quietly(Path(path))
            total -= size


def _make_private_folder(folder: Path) -> Path:
    """Return the folder, made if need be; raises OSError if it is not ours alone to write."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = folder.stat()
    if status.st_uid != os.geteuid():
        raise PermissionError(f"{folder} belongs to another user")
    if status.st_mode & _WRITABLE_BY_OTHERS:
        raise PermissionError(f"{folder} can be written by other users (chmod go-w would do)")
    return folder


def _content(path: Path, module: str, facts: bytes, count: Term) -> bytes | None:
    """Return the whole file, None if the compiled facts have another form than is known."""
    name = _encode_module_name(module)
    where = -1 if name is None else facts.find(name, 0, _NAME_WITHIN)
    if name is None or where < 0 or not isinstance(count, int):
        _LOG.info("%s: this SWI-Prolog compiles in another form", path)
        return None
    body = _HEAD.pack(_compute_key_digest(path), count, where, len(name)) + facts
    return _MAGIC + hashlib.sha256(body).digest() + body


def _read_verified(path: Path) -> _Saved | None:
    """Return the content of the file, None if it is not there or not exactly what was written for
    it."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(descriptor, "rb") as file:
            status = os.fstat(descriptor)
            if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid():
                return None
            content = file.read()
    except OSError:
        return None
    start = len(_MAGIC) + _DIGEST_BYTES
    body = memoryview(content)[start:]
    if (
        not content.startswith(_MAGIC)
        or len(body) < _HEAD.size
        or hashlib.sha256(body).digest() != content[len(_MAGIC) : start]
    ):
        return None
    key, count, where, length = _HEAD.unpack_from(body)
    if key != _compute_key_digest(path):
        return None
    facts = body[_HEAD.size :]
    return _Saved(count, bytes(facts[:where]), bytes(facts[where + length :]))


def _compute_key_digest(path: Path) -> bytes:
    return hashlib.sha256(path.name.encode()).digest()


def replace_file(path: Path, content: bytes) -> None:
    """Write the file whole or not at all; of two who do so at once, the last one stays."""
    descriptor, part = tempfile.mkstemp(suffix=_PART, dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        Path(part).replace(path)
    except BaseException:
        _delete_quietly(Path(part))
        raise


def _delete_quietly(path: Path) -> None:
    try:
        path.unlink()
    except OSError:
        return  # it is gone, or the folder is read-only: no harm
