"""Rules of models specialised for searches (prolog/batch/code.pl), kept as compiled files."""

import hashlib
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Protocol

from facetlog.kb.engine.engine import house
from facetlog.kb.engine.terms import Atom, Struct, Term, format_prolog_term
from facetlog.kb.engine.transport import LOAD_SECONDS, scene_module
from facetlog.kb.explaining.records import decode_record
from facetlog.kb.loading.loaded import RuleFile
from facetlog.kb.loading.rule_source import MODEL_SUFFIX
from facetlog.kb.loading.scene_cache import SceneCache

__all__ = ["JUDGING_CODE", "OpenCode", "Opener", "compute_models_hash", "open_code"]

# Files that verdicts depend on beside the models: words, measures, and the code that judges.
JUDGING_CODE = ("rules/*.pl", "kb/prolog/**/*.pl")
HASH_DIGITS = 16
NAME_DIGITS = 24  # of a module's digest

# opened(Kinds, General): the kinds of facts that models need, and of which models some are special.
_OPENED = tuple[tuple[tuple[str, int], ...], tuple[tuple[str, tuple[str, ...]], ...]]

# Modules of open code that are named by what they hold.
_in_use: set[str] = set()


class Opener(Protocol):
    """Ask a knowledge base."""

    def request(
        self, operation: str, about: Struct, columns: str = "", *, seconds: float | None = None
    ) -> Term:
        """Return the result of a request about the base."""
        ...

    def send(self, operation: str, text: str) -> Term:
        """Return the result of a request that needs no more than this text."""
        ...


@dataclass(frozen=True, slots=True)
class OpenCode:
    """Specialised rules: the module with them, the kinds of facts that they ask for as (functor,
    number of arguments), and for models that are special cases of others these."""

    target: str
    needed: frozenset[tuple[str, int]]
    general: Mapping[str, tuple[str, ...]]


def open_code(
    base: Opener, models: Mapping[str, RuleFile], *, crisp: bool, shared: bool = False
) -> OpenCode:
    """Return the specialised rules of these models, in a module of their own.

    With `shared` there is one module for all who ask for the same models; nobody closes it.
    """
    of_module: dict[str, list[Atom]] = defaultdict(list)
    for model, rules in models.items():
        of_module[rules.module].append(Atom(model))
    listed = tuple(Struct("-", (Atom(m), tuple(names))) for m, names in of_module.items())
    digest = _compute_digest(models, listed, crisp)
    kind = "facetlog_shared" if shared else "facetlog_code"
    target = scene_module() if digest is None else f"{kind}:{digest[:NAME_DIGITS]}"
    is_open = target in _in_use
    if is_open and not shared:
        target, digest = scene_module(), None
    cache, loaded, path = SceneCache(), None, None
    if digest is not None and not is_open:
        _in_use.add(target)
        identity = str(base.send("cache_identity", ""))
        path = cache.path(digest, identity)
        loaded = cache.load(path, target, base.send, "load_code")
    opened = base.request("open_code", Struct("code", (Atom(target), listed)), seconds=LOAD_SECONDS)
    if loaded is None and not is_open:
        cache.save(path, target, base.send, "save_code")
    kinds, general = decode_record(opened, _OPENED)
    return OpenCode(target, frozenset(kinds), dict(general))


def note_closed(target: str) -> None:
    """Note that a module is there no longer."""
    _in_use.discard(target)


def _compute_digest(
    models: Mapping[str, RuleFile], listed: tuple[Term, ...], crisp: bool
) -> str | None:
    """Return a digest of all that the specialised rules depend on, and name; None where nobody
    knows what that is: Prolog may load files of its own.
    """
    files = {path for rules in models.values() if rules.own for path in (rules.path, *rules.files)}
    if any(path.suffix != MODEL_SUFFIX for path in files):
        return None
    total = hashlib.sha256(f"{compute_models_hash(models)} crisp={crisp}\n".encode())
    total.update(format_prolog_term(listed).encode())
    try:
        for path in sorted(files):
            total.update(path.read_bytes())
    except OSError:
        return None  # it is gone by now
    return total.hexdigest()


def compute_models_hash(models: Mapping[str, RuleFile]) -> str:
    """Return a digest of the models' clauses and of what they are judged by, the same on every
    machine."""
    total = hashlib.sha256()
    for model, rules in models.items():
        total.update(f"{model}={rules.content}\n".encode())
    total.update(_hash_judging_code())
    return total.hexdigest()[:HASH_DIGITS]


@cache
def _hash_judging_code() -> bytes:
    total = hashlib.sha256()
    root = house("rules").parent
    for pattern in JUDGING_CODE:
        for path in sorted(root.glob(pattern)):
            total.update(path.read_bytes())
    return total.digest()
