"""Requests to Prolog, the errors that its replies report, and what is cleared away afterwards."""

import logging
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from time import perf_counter

from facetlog.errors import EngineError, LimitError, QueryError, RuleSyntaxError
from facetlog.kb.engine.engine import Reply, decode_piece
from facetlog.kb.engine.engine_pool import engine_pool
from facetlog.kb.engine.python_predicates import forget, raised
from facetlog.kb.engine.terms import Atom, Failure, Term, decode_reply, format_prolog_term

__all__ = [
    "LOAD_SECONDS",
    "Leftovers",
    "ask",
    "checked",
    "clear",
    "clear_all",
    "destroy_scene",
    "forget_in_prolog",
    "leave",
    "scene_module",
]

_LOG = logging.getLogger(__name__)

LOAD_SECONDS = 600.0
"""Time limit for one chunk of facts or one file of rules: the reader has limits of its own."""


def ask(operation: str, text: str, *, seconds: float = LOAD_SECONDS) -> Term:
    """Return the result of a request that has one reply; raise what the reply reports."""
    began = perf_counter()
    try:
        return checked(engine_pool().reply(operation, text, seconds=seconds))[0]
    finally:
        _LOG.debug("Prolog: %s took %.3f s", operation, perf_counter() - began)


def forget_in_prolog(operation: str, text: str) -> None:
    """Have Prolog forget something; what was asked before must not fail by it.

    An interrupt that came late may hit this request instead of its own: then it is asked again.
    """
    for _ in range(2):
        try:
            ask(operation, text)
        except EngineError as exc:
            _LOG.info("%s: %s", operation, exc)
        else:
            return


def checked(reply: Reply, question: str | None = None) -> tuple[Term, Reply]:
    """Return the result of a reply and what follows it; raise what the reply reports."""
    if not reply:
        raise EngineError("SWI-Prolog gave no answer")
    result = decode_reply(decode_piece(reply[0]))
    match result:
        case Failure("question", message, (int(start), int(end))):
            raise QueryError(message, text=question or "", start=start, end=end)
        case Failure("rules", message):
            raise RuleSyntaxError(message)
        case Failure("python", message, (int(key),)):
            original = raised(key)
            raise original if original is not None else EngineError(message)
        case Failure("prolog", message) if question is not None:
            # An error of the question while it runs, such as a division by 0: it has no place.
            raise QueryError(message, text=question)
        case Failure("limit", message):
            raise LimitError(message)
        case Failure(message=message):
            raise EngineError(message)
    return result, reply[1:]


# ---- modules of scenes, and what is left when a knowledge base goes

_modules = count(1)
# Prolog keeps a few hundred bytes for each name that a module ever had: names are used again.
_free_modules: list[str] = []


@dataclass(frozen=True, slots=True)
class Leftovers:
    """Scenes and rules of a knowledge base by their modules, and its Python functions."""

    base: str
    scenes: tuple[str, ...]
    rules: tuple[str, ...]
    functions: tuple[int, ...]


# Left by garbage-collected knowledge bases; the next request of another one removes it.
_left: deque[Leftovers] = deque()


def scene_module() -> str:
    """Return the name of a module that no scene of this process has."""
    try:
        return _free_modules.pop()
    except IndexError:
        return f"facetlog_scene:{next(_modules)}"


def destroy_scene(module: str) -> None:
    """Destroy a scene's module when all that is asked now has ended."""
    if engine_pool().send_when_quiet("destroy_scene", format_prolog_term(Atom(module))):
        _free_modules.append(module)


def leave(left: Leftovers) -> None:
    """Note what is to be cleared away, without waiting for anything."""
    _left.append(left)


def clear_all() -> None:
    """Clear away what was noted."""
    while _left:
        with suppress(IndexError):
            clear(_left.popleft())


def clear(left: Leftovers) -> None:
    """Clear it away; what Prolog does not forget stays until the process ends."""
    forget_in_prolog("forget_base", format_prolog_term(Atom(left.base)))
    for key in left.functions:
        forget(key)
    for module in left.scenes:
        destroy_scene(module)
    for module in left.rules:
        engine_pool().send_when_quiet("drop_rules", format_prolog_term(Atom(module)))
