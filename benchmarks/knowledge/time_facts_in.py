"""How long do facts take into the knowledge base, beside SWI-Prolog's own reading and asserting?

Native is SWI-Prolog's loop of read_term/3 and assertz/1 over the same facts as text, in the program
`swipl` (the yardstick) and in the SWI-Prolog inside Python. The tuples' way includes making the
text that crosses. CPU time, of the process that works; the ways take turns.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import cast

from benchmarks.common import Report, Settings, Table
from benchmarks.knowledge.knowledge_base import (
    angle_facts,
    cpu_ms,
    python_says,
    rows_against,
    swipl_says,
)
from facetlog.kb.engine.engine_pool import engine_pool
from facetlog.kb.engine.terms import Atom, term_text
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact, fact_text

__all__ = ["NAME", "measure"]

NAME = "time_facts_in"
FACTS = 100_000
REPEATS = 5
LOAD_SECONDS = 600.0

NATIVE = """
read_and_assert(Path) :-
    retractall(angle(_, _, _, _)),
    open(Path, read, Stream),
    repeat,
    read_term(Stream, Fact, []),
    (   Fact == end_of_file
    ->  !, close(Stream)
    ;   assertz(Fact), fail
    ).
:- dynamic angle/4.
"""

EMBEDDED = """
from pyswip import Prolog
prolog = Prolog()
prolog.consult({program!r})
print(json.dumps(cpu_ms(lambda: list(prolog.query("read_and_assert('{facts}')")), {repeats})))
"""


@contextmanager
def cache_folder() -> Iterator[None]:
    """While it lasts, scenes are cached in a folder that goes afterwards."""
    before = os.environ.get("XDG_CACHE_HOME")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ["XDG_CACHE_HOME"]
            else:
                os.environ["XDG_CACHE_HOME"] = before


def native(text: str, repeats: int) -> tuple[list[float], list[float]]:
    """CPU milliseconds of reading and asserting, in `swipl` and in Python's SWI-Prolog."""
    with tempfile.TemporaryDirectory() as folder:
        facts, program = Path(folder) / "facts.pl", Path(folder) / "native.pl"
        facts.write_text(text, encoding="utf-8")
        program.write_text(NATIVE, encoding="utf-8")
        goal = f"main :- times({repeats}, read_and_assert('{facts}'), Ts), print(Ts), nl.\n"
        alone = swipl_says(NATIVE + goal)
        embedded = EMBEDDED.format(program=str(program), facts=facts, repeats=repeats)
        return cast(list[float], alone), cast(list[float], python_says(embedded))


def text_in(text: str, repeats: int) -> list[float]:
    """CPU milliseconds of adding the text's clauses to a fresh scene, each checked."""
    pool = engine_pool()
    numbers = count()

    def ask(operation: str, request: str) -> None:
        pool.reply(operation, request, seconds=LOAD_SECONDS)

    def fresh() -> None:
        number = next(numbers)
        if number:
            ask("destroy_scene", term_text(Atom(f"benchmark{number - 1}")))
        ask("new_scene", term_text(Atom(f"benchmark{number}")))
        requests.append(f"{term_text(Atom(f'benchmark{number}'))}.\n{text}")

    requests: list[str] = []
    times = cpu_ms(lambda: ask("add_facts", requests.pop()), repeats, before=fresh)
    ask("destroy_scene", term_text(Atom(f"benchmark{next(numbers) - 1}")))
    return times


def tuples_in(facts: list[Fact], repeats: int, cache_key: str | None = None) -> list[float]:
    """CPU milliseconds of KnowledgeBase.load_scene."""
    with KnowledgeBase() as base:

        def drop() -> None:
            if "s" in base.scenes:
                base.drop_scene("s")

        return cpu_ms(
            lambda: base.load_scene("s", facts, cache_key=cache_key), repeats, before=drop
        )


def measure(settings: Settings) -> Report:
    """All ways of loading; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    facts = angle_facts(FACTS, settings.first)
    text = "".join(f"{fact_text(fact)}\n" for fact in facts)
    with cache_folder():
        with KnowledgeBase():  # text_in needs the declarations
            checked = text_in(text, repeats)
        tuples = tuples_in(facts, repeats)
        cached = tuples_in(facts, repeats, cache_key="benchmark")
    alone, embedded = native(text, repeats)
    rows = rows_against(
        alone,
        [
            ("native read and assert, swipl", alone),
            ("native read and assert, in Python", embedded),
            ("text in, each fact checked", checked),
            ("tuples in (load_scene)", tuples),
            ("a scene seen before (load_scene)", cached),
        ],
    )
    counts = {"facts": FACTS, "repeats": repeats, "seed": settings.first}
    notes = (
        "Facts have two names and two numbers.",
        "Wanted: new facts at most 2 times native, scenes seen before at most 0.5 times.",
    )
    return Report(NAME, (Table("CPU time", rows),), counts, notes)
