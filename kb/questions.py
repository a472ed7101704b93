"""What a question is, and who answers it: Prolog checks each, and answers what needs a search.

What only looks facts up comes back as a plan, and is answered from arrays (kb/arrays/), with the
same rows in the same order. What arrays cannot answer Prolog is asked for after all.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.kb.arrays.lookups import SceneTables, batches
from facetlog.kb.arrays.pace import Pace
from facetlog.kb.arrays.plan_terms import Plan, PlannedScene, decode_plan
from facetlog.kb.arrays.scene_columns import FactKind, SceneColumns
from facetlog.kb.arrays.values import NotOnArraysError
from facetlog.kb.engine.answers import Answers
from facetlog.kb.engine.columns import Chunk, Column, decode_chunk
from facetlog.kb.engine.door import Door, Replies, checked
from facetlog.kb.engine.terms import Atom, Struct, Term, Var, term_text
from facetlog.kb.limits import Limits

__all__ = ["Asked", "Question"]


@dataclass(frozen=True, slots=True)
class Question:
    """A goal, as in docs/queries.md, with the values of some of its variables.

    Asked are the scenes of the knowledge base `base`, all if None, for `most` answers, any number
    if None.
    """

    base: str
    goal: str
    scenes: tuple[str, ...] | None
    limits: Limits
    most: int | None = None
    bindings: tuple[tuple[str, Term], ...] = ()

    def put(self, door: Door, columns: Mapping[str, SceneColumns]) -> "Asked":
        """The question, on its way to Prolog; `columns` are those of scenes by their modules."""
        return Asked(self, door, dict(columns), self.replies(door, "arrays"))

    def replies(self, door: Door, way: str) -> Replies:
        """What Prolog says: with the way `prolog` answers, with `arrays` a plan if there is one."""
        scenes: Term = Atom("all")
        if self.scenes is not None:
            scenes = tuple(map(Atom, self.scenes))
        most: Term = Atom("inf") if self.most is None else self.most
        bindings = tuple(Struct("=", (Atom(name), value)) for name, value in self.bindings)
        args = (Atom(self.base), scenes, most, Atom(way), self.limits.bounds, bindings, self.goal)
        return door.replies("query", term_text(Struct("query", args)), seconds=self.limits.seconds)


class Asked:
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
            match head:
                case tuple(names):
                    chunks = self._from_prolog(decode_chunk(pieces))
                    return Answers(tuple(map(str, names)), chunks, self.close)
                case _:
                    plan = decode_plan(head)
                    return Answers(plan.names, self._planned(plan), self.close)
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
        given = 0
        try:
            for chunk in self._on_arrays(plan):
                given += chunk.length
                yield chunk
        except NotOnArraysError:
            self._replies = self._question.replies(self._door, "prolog")
            yield from _without_first(given, self._from_prolog())

    def _on_arrays(self, plan: Plan) -> Iterator[Chunk]:
        pace = self._pace = Pace(self._question.limits.seconds)
        left = self._question.most
        # All tables are fetched before the first answer: a scene may be dropped after it.
        scenes = [(scene, self._tables(plan, scene, pace)) for scene in plan.scenes]
        for scene, tables in scenes:
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
        return SceneTables(tables, columns.names, pace)

    def _read(self, scene: PlannedScene, kind: FactKind) -> Sequence[tuple[Column, ...]]:
        """The facts of a kind as Prolog has them."""
        name, arity = kind
        goal = term_text(Struct(name, tuple(Var(f"V{place}") for place in range(arity))))
        question = Question(self._question.base, goal, (scene.name,), Limits())
        replies = question.replies(self._door, "prolog")
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
