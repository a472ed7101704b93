"""Random models: faces proposed for parts, conditions, groups and sizes; and their clauses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from random import Random

from tests.kb.meaning.random_tests import Drawing
from tests.kb.meaning.terms import Term, prolog

__all__ = ["Line", "Members", "Model", "Step", "random_models"]

PARTS = ("A", "B", "C")
LABELS = ("seen", "square", "large", "room")


@dataclass(frozen=True)
class Step:
    """One face more of a join: how it is found (`face`, `later`, `other` or `shared`, which adjoins
    the one before), and a test that is possible then."""

    part: str
    way: str
    test: Term | None


@dataclass(frozen=True)
class Members:
    """Fs: measured faces of the thing but for the parts for which the test of F is possible; Gs are
    those, grouped by which adjoin. `named` where a clause of its own collects them."""

    test: Term
    named: str | None
    grouped: bool


@dataclass(frozen=True)
class Line:
    """A condition: its test for Fs and Gs of `members`, for each face F of the thing (`each`), or
    only where a test holds (`where`)."""

    label: str
    test: Term
    members: Members | None = None
    each: bool = False
    where: Term | None = None


@dataclass(frozen=True)
class Model:
    """A join is tried first; where it finds nothing, or is empty, faces as far as they were seen:
    part, how many of the largest, test."""

    name: str
    module: str
    parts: Sequence[str]
    join: Sequence[Step]
    seen: Sequence[tuple[str, int, Term]]
    lines: Sequence[Line]
    group: Members | None
    size: tuple[str, str] | None

    def clauses(self) -> list[str]:
        """Return the texts of the model's clauses."""
        parts = f"[{', '.join(self.parts)}]"
        clauses = [f'model({self.name}, "", [{", ".join(map(str.lower, self.parts))}])']
        if self.join:
            clauses.append(f"likely({self.name}, T, {parts}) :- {self._join()}")
        else:
            clauses.append(f"likely({self.name}, _, {parts}) :- fail")
        steps = ", ".join(f"step({p}, {count}, {prolog(test)})" for p, count, test in self.seen)
        found = f"findall(Ps, likely({self.name}, T, Ps), Found)"
        if not self.seen:
            clauses.append(f"candidate({self.name}, T, {parts}) :- {self._join()}")
        else:
            clauses.append(
                f"candidate({self.name}, T, Parts) :- {found}, ( Found == [] -> "
                f"distant({self.name}, T, Parts) ; member(Parts, Found) )"
            )
            clauses.append(
                f"distant({self.name}, T, {parts}) :- as_far_as_seen(T, [{steps}], {parts})"
            )
        for line in self.lines:
            head = f'condition({self.name}, {line.label}, "", T, {parts}, {prolog(line.test)})'
            clauses.append(head + self._body(line, parts))
        of_lines = (line.members for line in self.lines)
        clauses += [
            f"members({self.name}, {one.named}, T, {parts}, Fs) :- {_search(one, parts)}"
            for one in (*of_lines, self.group)
            if one and one.named
        ]
        if self.group:
            goal = self._members(self.group, parts)
            clauses.append(f"group({self.name}, T, {parts}, others, Fs) :- {goal}")
        if self.size:
            one, two = self.size
            measures = f"length({one}), width({two})"
            clauses.append(
                f"size({self.name}, _, {parts}, Name, M) :- longest_first([{measures}], Sorted), "
                "nth1(N, [long, short], Name), nth1(N, Sorted, M)"
            )
            clauses.append(f"size({self.name}, _, {parts}, wide, width({one}))")
        return clauses

    def _join(self) -> str:
        goals = []
        before = ""
        for step in self.join:
            match step.way:
                case "shared":
                    goals.append(f"shared_edge({before}, {step.part}, _)")
                case "later":
                    goals.append(f"face_of(T, {step.part}), {before} @< {step.part}")
                case "other":
                    goals.append(f"face_of(T, {step.part}), {before} \\== {step.part}")
                case _:
                    goals.append(f"face_of(T, {step.part})")
            if step.test is not None:
                goals.append(f"possible({prolog(step.test)})")
            before = step.part
        return ", ".join(goals)

    def _body(self, line: Line, parts: str) -> str:
        if line.members:
            separate = ", separate(Fs, Gs)" if line.members.grouped else ""
            return f" :- {self._members(line.members, parts)}{separate}"
        if line.each:
            return " :- face_of(T, F)"
        return "" if line.where is None else f" :- holds({prolog(line.where)})"

    def _members(self, members: Members, parts: str) -> str:
        if members.named:
            return f"members({self.name}, {members.named}, T, {parts}, Fs)"
        return _search(members, parts)


def _search(members: Members, parts: str) -> str:
    goals = f"face_of(T, F), \\+ memberchk(F, {parts}), possible({prolog(members.test)})"
    return f"findall(F, ( {goals} ), Found), sort(Found, Fs)"


def random_models(
    draw: Random, words: Mapping[str, Term], most: int, *, crowded: bool = False
) -> tuple[Model, ...]:
    """Return models of `rules`, and in one of two cases one of `asking` that asks for others."""
    names = [f"m{number}" for number in range(1, draw.randint(1, max(1, most)) + 1)]
    models = [_random_model(draw, name, "rules", words, (), crowded=crowded) for name in names]
    if draw.random() < 0.5:
        asked = (*names, "m9")
        models.append(_random_model(draw, "m9", "asking", {}, asked, crowded=False))
    return tuple(models)


def _random_model(
    draw: Random,
    name: str,
    module: str,
    words: Mapping[str, Term],
    models: Sequence[str],
    *,
    crowded: bool,
) -> Model:
    parts = PARTS[: 3 if crowded else draw.choice((1, 2, 2, 3))]

    def drawing(*names: str, faces: Sequence[str] = (), groups: Sequence[str] = ()) -> Drawing:
        return Drawing(draw, names, "T", faces, groups, words)

    def step(number: int) -> Step:
        ways = ("other",) if crowded else ("later", "other", "shared")
        known = parts[: number + 1]
        test = None
        if not crowded and draw.random() < 0.7:
            test = drawing(*known, known[-1]).test(1)
        return Step(parts[number], draw.choice(ways) if number else "face", test)

    def members(named: str) -> Members:
        some = draw.sample(parts, draw.randint(0, len(parts)))
        test = drawing("F", "F", *some).test(draw.randint(0, 2)) if draw.random() < 0.8 else None
        return Members(
            ("all", []) if test is None else test,
            named if draw.random() < 0.6 else None,
            draw.random() < 0.5,
        )

    def line(number: int) -> Line:
        label = draw.choice(LABELS)
        some = draw.sample(parts, draw.randint(1, len(parts)))
        way = draw.random()
        of = Drawing(draw, some, "T", words=words, models=models)
        if way < 0.4:
            return Line(label, of.test(draw.randint(0, 2)))
        if way < 0.5:
            return Line(label, of.test(1), where=drawing(*some).test(1))
        if way < 0.6:
            return Line(label, drawing("F", "F", *some).test(1), each=True)
        found = members(f"set{number}")
        groups = ("Gs",) if found.grouped else ()
        within = drawing(*some, faces=("Fs",), groups=groups)
        return Line(label, within.test(draw.randint(1, 3)), members=found)

    join = [step(number) for number in range(len(parts))]
    seen = [
        (part, draw.randint(1, 3), drawing(*parts[: number + 1], part).test(1))
        for number, part in enumerate(parts)
    ]
    way = draw.random()
    return Model(
        name,
        module,
        parts,
        () if way < 0.2 and not crowded else join,
        () if way > 0.6 or crowded else seen,
        [line(number) for number in range(draw.randint(1, 5))],
        members("group") if draw.random() < 0.5 else None,
        (draw.choice(parts), draw.choice(parts)) if draw.random() < 0.5 else None,
    )
