"""What a question is, and who answers it: Prolog checks each, and answers what needs a search.

What only looks facts up comes back as a plan, and is answered from arrays (kb/arrays/), with the
same rows in the same order. What arrays cannot answer Prolog is asked for after all.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from facetlog.errors import QueryError, RuleSyntaxError
from facetlog.kb.arrays.cliques import PairGraph
from facetlog.kb.arrays.face_pairs import graph_by_measure, graph_by_prolog
from facetlog.kb.arrays.lookups import SceneTables, batches
from facetlog.kb.arrays.pace import Pace
from facetlog.kb.arrays.plan_terms import Pairs, Plan, PlannedScene, decode_plan
from facetlog.kb.arrays.scene_columns import FactKind, SceneColumns
from facetlog.kb.arrays.values import NotOnArraysError
from facetlog.kb.engine.answers import Answers
from facetlog.kb.engine.columns import Chunk, Column, decode_chunk
from facetlog.kb.engine.door import Door, Replies, checked
from facetlog.kb.engine.terms import Atom, Struct, Term, Var, term_text
from facetlog.kb.limits import Limits

__all__ = ["PosedQuestion", "Question"]

FEWEST_FACTS = 2000
"""Of a kind in a scene: of fewer Prolog is as fast, since a plan takes a millisecond."""


@dataclass(frozen=True, slots=True)
class Question:
    """A goal, as in docs/queries.md, with the values of some of its variables.

    Its scenes are those of the knowledge base `base`, all if None, for `most` answers, any number
    if None.
    """

    base: str
    goal: str
    scenes: tuple[str, ...] | None
    limits: Limits
    most: int | None = None
    bindings: tuple[tuple[str, Term], ...] = ()

    def put(self, door: Door, columns: Mapping[str, SceneColumns]) -> "PosedQuestion":
        """The question, on its way to Prolog; `columns` are those of scenes by their modules."""
        return PosedQuestion(self, door, dict(columns), self.replies(door, FEWEST_FACTS))

    def replies(self, door: Door, fewest: int | None = None) -> Replies:
        """What Prolog says: answers; before them a plan, of questions about `fewest` facts."""
        scenes: Term = Atom("all")
        if self.scenes is not None:
            scenes = tuple(map(Atom, self.scenes))
        most: Term = Atom("inf") if self.most is None else self.most
        few: Term = Atom("inf") if fewest is None else fewest
        bindings = tuple(Struct("=", (Atom(name), value)) for name, value in self.bindings)
        args = (Atom(self.base), scenes, most, few, self.limits.bounds, bindings, self.goal)
        return door.replies("query", term_text(Struct("query", args)), seconds=self.limits.seconds)


class PosedQuestion:
    """A question that was put; what is loaded afterwards changes none of its answers."""

    def __init__(
        self, question: Question, door: Door, columns: Mapping[str, SceneColumns], replies: Replies
    ) -> None:
        self._question, self._door, self._columns = question, door, columns
        self._replies = replies
        self._pace: Pace | None = None

    def answers(self) -> Answers:
        """The answers, once Prolog has checked the question; errors as of KnowledgeBase.query."""
        try:
            first = next(self._replies, None)
            if first is None:
                return Answers((), iter(()), self.close)
            head, pieces = checked(first, self._question.goal)
            if isinstance(head, tuple):
                chunks = self._from_prolog(decode_chunk(pieces))
                return Answers(tuple(map(str, head)), chunks, self.close)
            plan = decode_plan(head)
            return Answers(plan.names, self._planned(plan), self.close, on_arrays=True)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Ends the question."""
        if self._pace is not None:
            self._pace.stop()
        self._replies.close()

    def _from_prolog(self, *read: Chunk) -> Iterator[Chunk]:
        yield from read
        for reply in self._replies:
            yield decode_chunk(checked(reply, self._question.goal)[1])

    def _planned(self, plan: Plan) -> Iterator[Chunk]:
        """The answers by the plan. Meanwhile Prolog keeps the question, and so the scenes."""
        given = 0
        try:
            for chunk in self._on_arrays(plan):
                given += chunk.length
                yield chunk
        except NotOnArraysError:
            yield from _without_first(given, self._from_prolog())
        self._replies.close()

    def _on_arrays(self, plan: Plan) -> Iterator[Chunk]:
        pace = self._pace = Pace(self._question.limits.seconds)
        left = self._question.most
        for scene in plan.scenes:
            tables = self._tables(plan, scene, pace)
            for batch in batches(plan.steps, frozenset(plan.columns), tables):
                length = batch.length if left is None else min(batch.length, left)
                columns = [
                    batch.values[number].take(slice(length)).column() for number in plan.columns
                ]
                if len(plan.names) > len(plan.columns):
                    columns.insert(0, _repeated(scene.name, length))
                if left is not None:
                    left -= length
                if length:
                    pace.rest()
                    yield Chunk(tuple(columns), length)
                    pace.go_on()
                if left == 0:
                    return

    def _tables(self, plan: Plan, scene: PlannedScene, pace: Pace) -> SceneTables:
        columns = self._columns.get(scene.module)
        if columns is None:
            raise NotOnArraysError
        tables = {
            kind: columns.table(kind, generation, lambda kind: self._read(scene, kind))
            for kind, generation in zip(plan.kinds, scene.generations, strict=True)
        }

        def graph(step: Pairs) -> PairGraph:
            def ask(request: Struct) -> Term:
                return self._about_scene(scene, request)

            if step.way is None:
                return graph_by_prolog(step.text, ask, columns.names)
            make = partial(graph_by_measure, step.way, step.text, tables, ask)
            return columns.graph(step.text, scene.generations, make)

        return SceneTables(tables, columns.names, pace, graph)

    def _about_scene(self, scene: PlannedScene, request: Struct) -> Term:
        """What Prolog says to a request about a scene, within the limits of the question."""
        limits = self._question.limits
        about = (Atom(self._question.base), Atom(scene.module), limits.bounds, request)
        text = term_text(Struct("request", about))
        reply = self._door.reply(request.functor, text, seconds=limits.seconds)
        try:
            return checked(reply, self._question.goal)[0]
        except (QueryError, RuleSyntaxError):
            # The question itself meets it in Prolog, with its place.
            raise NotOnArraysError from None

    def _read(self, scene: PlannedScene, kind: FactKind) -> Sequence[tuple[Column, ...]]:
        """The facts of a kind as Prolog has them."""
        name, arity = kind
        goal = term_text(Struct(name, tuple(Var(f"V{place}") for place in range(arity))))
        question = Question(self._question.base, goal, (scene.name,), Limits())
        replies = question.replies(self._door)
        try:
            return [decode_chunk(checked(reply, goal)[1]).columns for reply in replies]
        finally:
            replies.close()


def _repeated(name: str, length: int) -> Column:
    return Column.of_names(np.zeros(length, np.int32), (Atom(name),))


def _without_first(count: int, chunks: Iterator[Chunk]) -> Iterator[Chunk]:
    """The chunks without so many rows in front."""
    for chunk in chunks:
        if count >= chunk.length:
            count -= chunk.length
        elif count:
            yield Chunk.of_rows(list(chunk.rows())[count:], len(chunk.columns))
            count = 0
        else:
            yield chunk
