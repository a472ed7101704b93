"""The way to Prolog, in this process or in one of its own, and what its replies say."""

import logging
from collections.abc import Iterator
from time import perf_counter
from typing import Protocol

from facetlog.errors import EngineError, LimitError, QueryError, RuleSyntaxError
from facetlog.kb.engine.engine import Reply, piece_text
from facetlog.kb.engine.python_predicates import raised
from facetlog.kb.engine.terms import Failure, Term, decode_reply

__all__ = ["LOAD_SECONDS", "Door", "Replies", "ask", "checked", "clean_up"]

_LOG = logging.getLogger(__name__)

LOAD_SECONDS = 600.0
"""Wall time for one chunk of facts or one file of rules: the reader has limits of its own."""


class Replies(Protocol):
    """The replies of one request, pulled one by one."""

    def __iter__(self) -> Iterator[Reply]: ...
    def __next__(self) -> Reply: ...
    def close(self) -> None:
        """Ends the request; harmless if it has ended."""


class Door(Protocol):
    """The way to Prolog: in this process (EnginePool) or in one of its own (IsolatedProcess)."""

    def replies(self, operation: str, text: str, *, seconds: float) -> Replies:
        """The replies to a request, one for each solution."""

    def reply(
        self, operation: str, text: str, *, seconds: float, state: str | None = None
    ) -> Reply:
        """The only reply to a request that has one; what it loads belongs to `state`."""

    def when_quiet(self, operation: str, text: str, *, state: str) -> bool:
        """Sends the request, which forgets `state`, when all that is running now has ended.

        Returns whether it is done already.
        """


def ask(
    door: Door,
    operation: str,
    text: str,
    *,
    seconds: float = LOAD_SECONDS,
    state: str | None = None,
) -> Term:
    """The result of a request that has one reply; raises what the reply reports."""
    began = perf_counter()
    try:
        return checked(door.reply(operation, text, seconds=seconds, state=state))[0]
    finally:
        _LOG.debug("Prolog: %s took %.3f s", operation, perf_counter() - began)


def clean_up(door: Door, operation: str, text: str) -> None:
    """Have Prolog forget something; what was asked before must not fail by it.

    An interrupt that came late may hit this request instead of its own: then it is asked again.
    """
    for _ in range(2):
        try:
            ask(door, operation, text)
        except EngineError as exc:
            _LOG.info("%s: %s", operation, exc)
        else:
            return


def checked(reply: Reply, question: str | None = None) -> tuple[Term, Reply]:
    """The result of a reply and what follows it; raises what the reply reports."""
    if not reply:
        raise EngineError("SWI-Prolog gave no answer")
    result = decode_reply(piece_text(reply[0]))
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
