"""as_far_as_seen/3: parts chosen one after the other, as far as a thing was seen."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import FacetlogError, QueryError
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

FACES = tuple(f"f{i}" for i in range(9))


def scene(seed: int) -> list[Fact]:
    """Return faces of one thing, one implied, with their areas and which adjoin, drawn at
    random."""
    rng = np.random.default_rng(seed)
    facts: list[Fact] = [("thing", "t1"), ("thing", "t2")]
    for name, area in zip(FACES, rng.permutation(len(FACES)) + 1.0, strict=True):
        facts += [("face", name), ("part_of", name, "t1"), ("area", name, float(area), 0.1)]
        facts.append(("evidence", name, "implied" if name == "f5" else "measured"))
    for a, b in combinations(FACES, 2):
        if rng.random() < 0.35:
            facts += [("adjoins", a, b, f"e{a}{b}"), ("adjoins", b, a, f"e{a}{b}")]
    return facts


def steps(counts: tuple[int, int, int]) -> str:
    a, b, c = counts
    return (
        f"[step(A, {a}, measured(A)), step(B, {b}, adjoins(A, B)),"
        f" step(C, {c}, all([adjoins(A, C), adjoins(B, C)]))]"
    )


def found(base: KnowledgeBase, goal: str) -> list[tuple[str, ...]]:
    return [tuple(map(str, row)) for row in base.query(goal)]


def test_there_are_never_more_than_sixty(base: KnowledgeBase) -> None:
    base.load_scene("s", scene(0))
    free = "[step(A, 8, measured(A)), step(B, 8, measured(B)), step(C, 8, measured(C))]"
    rows = found(base, f"as_far_as_seen(t1, {free}, [A, B, C])")
    assert len(rows) == len(set(rows)) == 60


def test_a_thing_without_faces_has_no_part_seen(base: KnowledgeBase) -> None:
    base.load_scene("s", scene(0))
    assert found(base, f"as_far_as_seen(t2, {steps((3, 3, 3))}, [A, B, C])") == [("unseen",) * 3]
    assert found(base, "as_far_as_seen(t1, [step(A, 0, measured(A))], [A])") == [("unseen",)]
    assert found(base, "as_far_as_seen(t1, [], P)") == [("()",)]


@pytest.mark.parametrize(
    ("searched", "fault"),
    [
        ("[step(A, 2, levl(A))]", "did you mean level"),
        ("[step(A, 2, shell(ls))]", "no test of the vocabulary"),
        ("[step(f1, 2, measured(f1))]", "begins with the variable"),
        ("[step(A, x, measured(A))]", "a whole number"),
        ("[stp(A, 2, measured(A))]", "a step is step"),
        ("steps", "a list of steps is wanted"),
    ],
)
def test_faulty_steps_are_refused_with_their_place(
    base: KnowledgeBase, searched: str, fault: str
) -> None:
    base.load_scene("s", scene(0))
    with pytest.raises(QueryError, match=fault):
        list(base.query(f"as_far_as_seen(t1, {searched}, P)"))


@pytest.mark.parametrize(
    "hidden",
    ["Test = user:shell(ls)", "Test = M:measured(A), M = other", "member(Test, [_])", "Test = 3"],
)
def test_what_is_hidden_from_the_check_is_refused_when_it_runs(
    base: KnowledgeBase, hidden: str
) -> None:
    base.load_scene("s", scene(0))
    with pytest.raises(FacetlogError):
        list(base.query(f"{hidden}, as_far_as_seen(t1, [step(A, 2, Test)], P)"))


def test_steps_know_the_words_of_their_file(tmp_path: Path) -> None:
    path = tmp_path / "m.pl"
    path.write_text("""model(m, "Two that are near.", [a, b]).
candidate(m, T, P) :- as_far_as_seen(T, [step(A, 1, big(A)), step(B, 1, nigh(A, B))], P).
means(nigh(A, B), all([adjoins(A, B), at_most(area(B), tolerance(part)*area(A))])).
means(big(A), at_least(area(A), tolerance(part)*area(A))).
tolerance(part, 0.9).
condition(m, near, "they adjoin", _, [A, B], nigh(A, B)).
""")
    facts = scene(1)
    areas = {str(fact[1]): float(fact[2]) for fact in facts if fact[0] == "area"}
    with KnowledgeBase() as own:
        own.load_scene("s", facts)
        own.load_rules(path, trusted=True)
        largest, second = (part.faces[0] for part in own.judge("s", "m", "t1").parts)
    assert areas[largest] == max(area for name, area in areas.items() if name != "f5")
    assert areas[second] <= 0.9 * areas[largest]
