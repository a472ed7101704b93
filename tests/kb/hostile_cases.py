"""Corpora of hostile texts, and what must be the same after each of them."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from facetlog.kb.engine.terms import Term
from facetlog.kb.knowledge_base import KnowledgeBase

HERE = Path(__file__).parent / "hostile"

# Five lines, so that what is put after them begins on line 6.
GOOD = """:- module(slab, []).
:- use_module(facetlog(vocabulary)).
model(slab, "A level board.", [board]).
candidate(slab, Thing, [Board]) :- face_of(Thing, Board).
condition(slab, flat, "it lies level", _, [Board], at_most(tilt(Board), 5)).
"""

FACTS = (
    ("scene", "s"),
    ("scale", "metric"),
    ("thing", "t1"),
    ("face", "f1"),
    ("face", "f2"),
    ("part_of", "f1", "t1"),
    ("part_of", "f2", "t1"),
    ("evidence", "f1", "measured"),
    ("evidence", "f2", "measured"),
    ("angle", "f1", "f2", 88.0, 1.0),
    ("angle", "f2", "f1", 88.0, 1.0),
    ("tilt", "f1", 2.0, 0.5),
    ("tilt", "f2", 88.0, 0.5),
    ("upward", "f1"),
)

# Everything of Prolog that a text could change and that nothing else changes meanwhile. A file
# that is trusted looks at it, and says it as the name of a part of a model.
CANARY = """
:- module(canary, []).
:- use_module(facetlog(vocabulary)).
:- use_module(library(lists)).
:- use_module(library(aggregate)).

model(canary, "What Prolog is like.", [flags, operators, predicates, threads]).
candidate(canary, _, [Flags, Operators, Predicates, Threads]) :-
    flags(Flags), operators(Operators), predicates(Predicates), threads(Threads).
condition(canary, alive, "it sings", _, _, all([])).

flags(Text) :-
    findall(Flag=Value, ( current_prolog_flag(Flag, Value), \\+ of_the_thread(Flag) ), Flags),
    said(Flags, Text).

% These differ between the threads that serve questions.
of_the_thread(stack_limit).
of_the_thread(system_thread_id).

operators(Text) :-
    findall(op(P, T, M:N),
            ( member(M, [user, system, vocabulary, box, facetlog_query, facetlog_text]),
              current_op(P, T, M:N) ),
            Operators),
    said(Operators, Text).

% Names and numbers of clauses of all that no scene, file or request makes.
predicates(Text) :-
    findall(M:N/A-Count,
            ( current_module(M), lasting(M),
              current_predicate(M:N/A), functor(H, N, A),
              \\+ predicate_property(M:H, imported_from(_)),
              \\+ ( predicate_property(M:H, dynamic), noted(M, N) ),
              \\+ predicate_property(M:H, volatile),
              ( predicate_property(M:H, number_of_clauses(Count)) -> true ; Count = none ) ),
            Predicates),
    said(Predicates, Text).

% What our own modules remember, and Prolog of loaded files: of other knowledge bases, too.
noted(Module, _) :- sub_atom(Module, 0, _, _, facetlog).
noted(system, Name) :- sub_atom(Name, 0, _, _, '$').

threads(Text) :-
    findall(Thread, thread_property(Thread, status(running)), Threads),
    length(Threads, Count),
    atom_number(Text, Count).

lasting(Module) :- \\+ module_property(Module, class(temporary)).

said(Terms, Text) :-
    sort(Terms, Sorted),
    with_output_to(string(String), forall(member(Term, Sorted), ( writeq(Term), nl ))),
    atom_string(Text, String).
"""


def cases(name: str) -> list[tuple[str, str, str]]:
    """Return title, expectation and text of each case of a corpus; questions are their own
    titles."""
    blocks = (HERE / name).read_text(encoding="utf-8").split("\n=== ")[2:]
    found = []
    for block in blocks:
        title, _, rest = block.partition("\n")
        mark, _, text = rest.partition("\n")
        assert mark.startswith(">>> "), block
        found.append((title, mark.removeprefix(">>> "), text.rstrip("\n")))
    return found


class Aviary:
    """A knowledge base with a scene, and what it says of itself."""

    def __init__(self, base: KnowledgeBase, folder: Path) -> None:
        self.base, self.folder = base, folder
        base.load_scene("s", FACTS)
        path = folder / "canary.pl"
        path.write_text(CANARY)
        base.load_rules(path, trusted=True)
        self.song()  # what Prolog loads when it is first used is no effect
        self.last = self.song()

    def song(self) -> tuple[object, ...]:
        """Return the state that nothing may change: Prolog, facts, answers, folder, threads."""
        parts = [part.faces[0] for part in self.base.judge("s", "canary", "t1").parts]
        # Prolog has its main thread, one that collects atoms, and those of our pool.
        pool = [t for t in threading.enumerate() if t.name == "facetlog-prolog"]
        assert int(parts.pop()) <= len(pool) + 2
        return (
            *(set(part.split("\n")) for part in parts),
            self.rows("angle(A, B, D, S)"),
            self.rows("face_of(T, F)"),
            self.rows("upward(F)"),
            self.rows("verdict(t1, box, S, D)"),
            self.rows("X is 2*3, append([a], [b], L), atom_concat(a, b, AB)"),
            sorted(p.name for p in self.folder.iterdir()),
            sorted(p.name for p in Path.cwd().iterdir()),
            os.getpid(),
        )

    def rows(self, question: str) -> list[tuple[Term, ...]]:
        """Return all answers to a question."""
        return list(self.base.query(question))

    @contextmanager
    def unchanged(self) -> Iterator[None]:
        """Asserts that what happens in this context has no effect."""
        yield
        before, self.last = self.last, self.song()
        for old, new in zip(before, self.last, strict=True):
            if isinstance(old, set) and isinstance(new, set):
                assert old == new, sorted(old ^ new)[:10]
            assert old == new, (old, new)
