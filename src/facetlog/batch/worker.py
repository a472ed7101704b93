"""A worker process: scenes come in by its standard input, a socket; rows go out by it.

Messages in are JSON: the settings, then lists of items. Messages out are a letter and JSON. What
another process says is never unpickled.
"""

import json
import os
import queue
import threading
from enum import Enum
from multiprocessing.connection import Connection
from typing import Any

from facetlog.batch.memory import format_memory_error, limit_memory
from facetlog.errors import FacetlogError, RuleSyntaxError


class Word(bytes, Enum):
    """First byte of a worker's message: its kind."""

    READY = b"="
    """The engine is open: the hash of its models, and their names."""
    REFUSED = b"!"
    """The engine cannot be opened: kind and text of the error. The process ends."""
    ROW = b"+"
    """The row of the item that was first in turn."""
    FAULT = b"-"
    """The same, for a row that has an error."""
    SPENT = b"*"
    """The same, of a scene for which memory ran out. The process ends: what was cut off in the
    middle of it may have left it in disorder."""
    PROFILE = b"%"
    """Where the time went, of all scenes up to the next row."""
    EXPLAINED = b"?"
    """The picture and the reasons of the item that was first in turn."""
    SHOWN = b"#"
    """The page of the item that was first in turn."""


def main() -> None:
    """Serve until the other side goes away."""
    connection = Connection(os.dup(0))
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(connection, messages), daemon=True).start()
    try:
        _serve(connection, messages)
    except OSError:
        pass  # nobody is left to tell
    finally:
        os._exit(0)  # what an engine may still be doing is not waited for


def _listen(connection: Connection, messages: "queue.SimpleQueue[Any]") -> None:
    """Take in what comes; when the other side is gone, end the process whatever it does."""
    try:
        while True:
            messages.put(json.loads(connection.recv_bytes()))
    except (EOFError, OSError):
        os._exit(0)


def _serve(connection: Connection, messages: "queue.SimpleQueue[Any]") -> None:
    def say(word: Word, content: object) -> None:
        text = json.dumps(content, separators=(",", ":"), allow_nan=False)
        connection.send_bytes(word.value + text.encode())

    first = messages.get()
    most_mb = first["memory_mb"]
    limit_memory(most_mb)
    try:
        # Loaded only now: a fault in what it loads can be reported.
        from facetlog.batch.engine import SceneEngine
        from facetlog.batch.settings import Item, Settings

        settings = Settings.from_json(first)
        engine = SceneEngine(settings)
    except FacetlogError as exc:
        kind = "rules" if isinstance(exc, RuleSyntaxError) else "input"
        say(Word.REFUSED, {"kind": kind if exc.exit_code == 2 else "engine", "error": str(exc)})
        return
    except MemoryError:
        say(Word.REFUSED, {"kind": "input", "error": f"a worker {format_memory_error(most_mb)}"})
        return
    except Exception as exc:  # the other side must not wait for ever
        say(Word.REFUSED, {"kind": "engine", "error": f"{type(exc).__name__}: {exc}"})
        return
    say(Word.READY, {"models_hash": engine.models_hash, "models": engine.models})
    while True:
        tasks = messages.get()
        mistakes = [task.pop("explain", None) for task in tasks]
        shown = [task.pop("page", None) for task in tasks]
        items = [Item(**task) for task in tasks]
        # A list is of one kind.
        if shown[0] is not None:
            from facetlog.batch.pages.scene_page import scene_page

            for item, sha256 in zip(items, shown, strict=True):
                say(Word.SHOWN, scene_page(item, settings, sha256))
            continue
        if mistakes[0] is None:
            for item in items:
                row = engine.row(item)
                if settings.profile:
                    say(Word.PROFILE, engine.profile.to_json())
                if engine.spent and row["error"] is not None:
                    say(Word.SPENT, row)
                    return
                say(Word.ROW if row["error"] is None else Word.FAULT, row)
            continue
        from facetlog.batch.pages.explain import explained

        for item, mistaken in zip(items, mistakes, strict=True):
            say(Word.EXPLAINED, explained(item, settings, mistaken))


if __name__ == "__main__":
    main()
