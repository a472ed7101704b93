"""The embedded SWI-Prolog: one per process, used from one thread, the only importer of pyswip.

Python and Prolog meet in a single deterministic predicate, request/3 of kb/bridge.pl: a text in, a
text out. So no query is ever open between two calls (pyswip crashes on interleaved queries and at
exit), nothing is converted by pyswip (it cuts large integers and text with NUL), and errors come
back as values. Limits on time and inferences act inside the goal, where they are heeded.
"""

import atexit
import ctypes
import os
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import islice
from pathlib import Path
from typing import Any, ClassVar

from facetlog.errors import EngineError, RuleSyntaxError
from facetlog.kb.encode import Fact, decode_verdict, fact_text
from facetlog.kb.terms import Atom, Failure, Struct, Term, decode_reply, term_text
from facetlog.kb.verdict import Verdict

__all__ = ["MINIMUM_VERSION", "Engine", "Limits", "LoadedScene", "RuleFile"]

MINIMUM_VERSION = (9, 0, 4)
"""SWI-Prolog of Debian 12, the oldest that this was tried with."""

BUILTIN_MODELS = ("box", "table", "chair")

# Facts are handed over in texts of this many: long enough that the crossing costs nothing.
FACTS_PER_CHUNK = 5000

INSTALL_HINT = (
    "install SWI-Prolog 9.0.4 or newer (Debian and Ubuntu: apt install swi-prolog-nox; "
    "macOS: brew install swi-prolog)"
)


@dataclass(frozen=True, slots=True)
class Limits:
    """What one question may cost: wall seconds and inferences (some 10 to 20 million a second)."""

    seconds: float = 30.0
    inferences: int = 300_000_000

    @property
    def term(self) -> Struct:
        """limits(Seconds, Inferences)."""
        return Struct("limits", (float(self.seconds), self.inferences))


@dataclass(frozen=True, slots=True)
class RuleFile:
    """A loaded file of rules: its Prolog module and the models that it defines."""

    path: Path
    module: str
    models: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LoadedScene:
    """A scene whose facts are in the engine; `module` is where."""

    name: str
    module: str


class _Door:
    """The C functions of SWI-Prolog that a request needs, declared with their true types.

    pyswip declares size_t* as int*, and wraps some functions in conversions of its own.
    """

    _TERM = ctypes.c_size_t  # term_t, fid_t: uintptr_t
    # Constants of SWI-Prolog.h.
    _ATOM, _STRING, _UTF8, _CATCH_EXCEPTION = 2, 6, 0x00100000, 0x0008

    def __init__(self, library: ctypes.CDLL) -> None:
        # When the interpreter ends, what still holds a scene must not call a Prolog that is gone.
        self.closed = False
        atexit.register(self._close)

        def declare(name: str, result: type | None, *arguments: type) -> Any:
            return ctypes.CFUNCTYPE(result, *arguments)((name, library))

        term, text, pointer, number = self._TERM, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int
        size = ctypes.c_size_t
        self._open_frame = declare("PL_open_foreign_frame", term)
        self._discard_frame = declare("PL_discard_foreign_frame", None, term)
        self._new_terms = declare("PL_new_term_refs", term, number)
        self._predicate = declare("PL_predicate", pointer, text, number, text)
        self._put = declare("PL_put_chars", number, term, number, size, text)
        self._call = declare("PL_call_predicate", number, pointer, number, pointer, term)
        self._get = declare(
            "PL_get_string", number, term, ctypes.POINTER(text), ctypes.POINTER(size)
        )

    def _close(self) -> None:
        self.closed = True

    def consult(self, path: Path) -> bool:
        """Whether the file was loaded."""
        frame = self._open_frame()
        try:
            term = self._new_terms(1)
            data = os.fsencode(path)
            self._put(term, self._ATOM | self._UTF8, len(data), data)
            predicate = self._predicate(b"consult", 1, b"user")
            return bool(self._call(None, self._CATCH_EXCEPTION, predicate, term))
        finally:
            self._discard_frame(frame)

    def request(self, operation: str, text: str) -> str:
        """The reply of request/3 of kb/bridge.pl."""
        frame = self._open_frame()
        try:
            terms = self._new_terms(3)
            for i, data in enumerate((operation.encode(), text.encode())):
                self._put(terms + i, self._STRING | self._UTF8, len(data), data)
            predicate = self._predicate(b"request", 3, b"facetlog_bridge")
            chars, length = ctypes.c_char_p(), ctypes.c_size_t()
            if not (
                self._call(None, self._CATCH_EXCEPTION, predicate, terms)
                and self._get(terms + 2, ctypes.byref(chars), ctypes.byref(length))
            ):
                raise EngineError(f"SWI-Prolog did not answer the request {operation}")
            return ctypes.string_at(chars, length.value).decode("ascii")
        finally:
            self._discard_frame(frame)


@cache
def _start() -> _Door:
    """The process's SWI-Prolog, started at the first call."""
    try:
        from pyswip import core, prolog
    except Exception as exc:  # pyswip raises bare Exception where SWI-Prolog is missing or old
        raise EngineError(f"SWI-Prolog is missing or cannot be used: {INSTALL_HINT}") from exc
    del prolog  # importing it starts SWI-Prolog without signal handlers
    major, minor, patch = _version(core.PL_VERSION)
    if (major, minor, patch) < MINIMUM_VERSION:
        raise EngineError(f"SWI-Prolog {major}.{minor}.{patch} is too old: {INSTALL_HINT}")
    door = _Door(core._lib)
    if not door.consult(_house("kb") / "bridge.pl"):
        raise EngineError("the knowledge base's own Prolog files cannot be loaded")
    return door


def _version(number: int) -> tuple[int, int, int]:
    """Major, minor and patch of SWI-Prolog's version number.

    >>> _version(90004)
    (9, 0, 4)
    """
    return number // 10000, number // 100 % 100, number % 100


def _house(room: str) -> Path:
    # Prolog loads files by path: wheels are unpacked, so the resource is one.
    return Path(str(files(f"facetlog.{room}"))).resolve()


class Engine:
    """The process's Prolog with the vocabulary and the built-in models loaded.

    All engines of a process share one Prolog; each belongs to the thread that made the first. Batch
    work goes to spawned processes: a forked one would share the parent's Prolog, and is refused.
    """

    _owner: ClassVar[tuple[int, int] | None] = None

    def __init__(self, limits: Limits | None = None) -> None:
        self.limits = limits or Limits()
        here = (os.getpid(), threading.get_ident())
        if Engine._owner is None:
            Engine._owner = here
        self._check_owner()
        self._door = _start()
        self.rules: tuple[RuleFile, ...] = tuple(
            self._rule_file("load_builtin", _house("rules") / f"{name}.pl")
            for name in BUILTIN_MODELS
        )

    def load_rules(self, path: Path) -> RuleFile:
        """The models of a user's file, loaded into a module of their own.

        A model takes the place of a built-in one of the same name. Raises RuleSyntaxError, naming
        file and line, if the file cannot be read, uses a word that there is not, or defines a model
        that another user's file defines.
        """
        path = Path(path)
        loaded = self._rule_file("load_rules", path)
        builtin = set(self.rules[: len(BUILTIN_MODELS)])
        for other in self.rules:
            twice = set(other.models) & set(loaded.models)
            if twice and other not in builtin:
                self._request("drop_rules", term_text(Atom(loaded.module)))
                raise RuleSyntaxError(
                    f"{path}: the model {min(twice)} is already defined in {other.path}"
                )
        self.rules = (*self.rules, loaded)
        return loaded

    def unload_rules(self, rules: RuleFile) -> None:
        """Forget a user's file."""
        self.rules = tuple(r for r in self.rules if r != rules)
        self._request("drop_rules", term_text(Atom(rules.module)))

    @property
    def models(self) -> dict[str, str]:
        """Name of each model and the module that defines it; the last one loaded wins."""
        return {model: rules.module for rules in self.rules for model in rules.models}

    @contextmanager
    def load_scene(self, name: str, facts: Iterable[Fact]) -> Iterator[LoadedScene]:
        """The scene with these facts in the engine, for as long as the context lasts."""
        module = str(self._request("new_scene", ""))
        try:
            lines = map(fact_text, facts)
            first = term_text(Atom(module)) + "."
            while chunk := tuple(islice(lines, FACTS_PER_CHUNK)):
                self._request("add_facts", "\n".join((first, *chunk)))
            yield LoadedScene(name, module)
        finally:
            if not self._door.closed:
                self._request("drop_scene", term_text(Atom(module)))

    def query(
        self, scene: LoadedScene, goal: Term, *, limits: Limits | None = None, most: int = 10_000
    ) -> list[dict[str, Term]]:
        """Bindings of the goal's variables, one dict for each of at most `most` solutions.

        The goal may use the words of the vocabulary and `fact(...)`; anything else is refused.
        """
        question = Struct("query", (Atom(scene.module), goal, (limits or self.limits).term, most))
        match self._request("query", term_text(question)):
            case tuple(solutions):
                return [dict(map(_binding, _items(solution))) for solution in solutions]
        raise EngineError("Prolog's answer cannot be read")

    def judge(
        self, scene: LoadedScene, model: str, thing: str, *, length_unit: str | None = None
    ) -> Verdict:
        """The verdict of a model on one thing of the scene."""
        request = Struct(
            "judge",
            (
                Atom(scene.module),
                Atom(self.models[model]),
                Atom(model),
                Atom(thing),
                self.limits.term,
            ),
        )
        return decode_verdict(self._request("judge", term_text(request)), length_unit=length_unit)

    def _rule_file(self, operation: str, path: Path) -> RuleFile:
        match self._request(operation, term_text(Atom(str(path)))):
            case Struct("loaded", (Atom(module), tuple(models))):
                return RuleFile(path, module, tuple(str(m) for m in models))
        raise EngineError(f"{path}: no rules were loaded")

    def _check_owner(self) -> None:
        if Engine._owner != (os.getpid(), threading.get_ident()):
            raise EngineError(
                "Prolog belongs to the thread and process that used it first: "
                "use that thread, or start worker processes by spawn"
            )

    def _request(self, operation: str, text: str) -> Term:
        self._check_owner()
        result = decode_reply(self._door.request(operation, text))
        match result:
            case Failure(kind="rules", message=message):
                raise RuleSyntaxError(message)
            case Failure(message=message):
                raise EngineError(message)
        return result


def _items(term: Term) -> tuple[Term, ...]:
    if isinstance(term, tuple):
        return term
    raise EngineError("Prolog's answer cannot be read")


def _binding(term: Term) -> tuple[str, Term]:
    match term:
        case Struct("=", (Atom(name), value)):
            return name, value
    raise EngineError("Prolog's answer cannot be read")
