"""How long do 100,000 answers take to Python, beside SWI-Prolog's own loop over them?

Native is forall/2 over the same facts in the program `swipl`, as is findall/3, which also keeps
them. CPU time, of the process that works. `first` is the first question after the facts are loaded.
pyswip's generator answers a tenth of the question, and its time is multiplied by ten.
"""

import time
from collections.abc import Callable
from typing import cast

from benchmarks.common import Report, Settings, Table, median_and_spread
from benchmarks.knowledge.knowledge_base import (
    angle_facts,
    cpu_ms,
    python_says,
    rows_against,
    swipl_says,
)
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

__all__ = ["NAME", "measure"]

NAME = "time_answers_out"
ANSWERS = 100_000
REPEATS = 9
PYSWIP_SHARE = 10  # pyswip takes some 20 s for all

# The same facts as angle_facts makes, but for the numbers.
NATIVE = """
:- dynamic angle/4.
fill(Count) :-
    forall(between(1, Count, N),
           ( I is (N - 1) mod 300, J is (N - 1) // 300,
             atom_concat(f, I, A), atom_concat(f, J, B),
             Degrees is random_float*180,
             assertz(angle(A, B, Degrees, 0.5)) )).
"""

PYSWIP = """
from pyswip import Prolog
prolog = Prolog()
list(prolog.query("assertz((fill(N) :- forall(between(1, N, I), (X is I mod 300, Y is I // 300, "
                  "atom_concat(f, X, A), atom_concat(f, Y, B), D is I*0.001, "
                  "assertz(angle(A, B, D, 0.5)))))), fill({count})"))
def generator():
    for _ in prolog.query({goal!r}):
        pass
print(json.dumps([cpu_ms(generator, 1)[0], *cpu_ms(
    lambda: list(prolog.query("forall(angle(A, B, C, D), true)")), {repeats})]))
"""

ALL, NUMBERS, NUMBER = "angle(A, B, Degrees, Sd)", "angle(_, _, Degrees, Sd)", "angle(_, _, X, _)"


def native(repeats: int) -> tuple[list[float], list[float]]:
    """CPU milliseconds of forall/2 and of findall/3 in `swipl`."""
    loop = f"times({repeats}, forall(angle(_, _, _, _), true), Ts)"
    kept = f"times({repeats}, findall(a(A, B, C, D), angle(A, B, C, D), _), Fs)"
    main = f"main :- fill({ANSWERS}), {loop}, {kept}, print([Ts, Fs]), nl.\n"
    times, findall = cast(tuple[list[float], list[float]], swipl_says(NATIVE + main))
    return times, findall


def first_question(goal: str, facts: list[Fact], repeats: int) -> list[float]:
    """CPU milliseconds of a question to arrays that is the first one of its scene."""
    with KnowledgeBase() as base:
        return cpu_ms(
            lambda: base.query(goal).arrays(), repeats, before=lambda: base.load_scene("s", facts)
        )


def first_answer(base: KnowledgeBase, repeats: int) -> list[float]:
    """Wall milliseconds until the first answer is there."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        with base.query(ALL) as answers:
            next(answers)
        times.append(1e3 * (time.perf_counter() - start))
    return times


def measure(settings: Settings) -> Report:
    """All ways of reading; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    part = ANSWERS // PYSWIP_SHARE
    slow, *embedded = cast(
        list[float],
        python_says(PYSWIP.format(count=part, goal="angle(A, B, Degrees, Sd)", repeats=repeats)),
    )
    alone, findall = native(repeats)
    facts = angle_facts(ANSWERS, settings.first)
    with KnowledgeBase() as base:
        base.load_scene("s", facts)

        def tuples(goal: str) -> Callable[[], object]:
            return lambda: sum(1 for _ in base.query(goal))

        def arrays(goal: str) -> Callable[[], object]:
            return lambda: base.query(goal).arrays()

        measured = [
            ("native forall, swipl", alone),
            ("native forall, in Python", [PYSWIP_SHARE * t for t in embedded]),
            ("native findall of four-tuples, swipl", findall),
            ("tuples of two names and two numbers", cpu_ms(tuples(ALL), repeats)),
            ("tuples of two numbers", cpu_ms(tuples(NUMBERS), repeats)),
            ("arrays of two numbers", cpu_ms(arrays(NUMBERS), repeats)),
            ("arrays of two numbers, first", first_question(NUMBERS, facts, repeats)),
            ("arrays of two names and two numbers, first", first_question(ALL, facts, repeats)),
            ("an array of one number", cpu_ms(arrays(NUMBER), repeats)),
            ("pyswip's generator", [PYSWIP_SHARE * slow]),
        ]
        first = first_answer(base, repeats)
    tables = (
        Table("CPU time", rows_against(alone, measured)),
        Table("Wall time to the first answer", ({**_named(first)},)),
    )
    counts = {"answers": ANSWERS, "repeats": repeats, "seed": settings.first}
    notes = ("Wanted: two numbers to arrays at most 3 × forall, four-tuples at most 3 × findall.",)
    return Report(NAME, tables, counts, notes)


def _named(times: list[float]) -> dict[str, str | int | float | bool | None]:
    return {f"ms {key}": value for key, value in median_and_spread(times, digits=2).items()}
