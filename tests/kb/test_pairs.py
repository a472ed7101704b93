"""each_pair/4, the search: the same faces that the test finds one by one."""

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

FACES = tuple(f"f{i}" for i in range(12))


def scene(seed: int, *, sd: float = 1.0) -> list[Fact]:
    """Return twelve faces, one of them implied, whose relations are drawn at random; some angles
    lack."""
    rng = np.random.default_rng(seed)
    facts: list[Fact] = [("thing", "t1")]
    for name in FACES:
        facts += [("face", name), ("part_of", name, "t1")]
        facts.append(("evidence", name, "implied" if name == "f5" else "measured"))
    for a, b in combinations(FACES, 2):
        angle = float(rng.uniform(50, 130))
        known, adjoin, convex = rng.random(3) < (0.9, 0.6, 0.7)
        for x, y in ((a, b), (b, a)):
            if known:
                facts.append(("angle", x, y, angle, sd))
            if adjoin:
                facts.append(("adjoins", x, y, f"e{a}{b}"))
                facts.append(("convex" if convex else "concave", x, y))
    return facts


@pytest.fixture(scope="module", params=[1, 2])
def base(request: pytest.FixtureRequest) -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        base.load_scene("s", scene(request.param))
        yield base


def found(base: KnowledgeBase, goal: str) -> list[tuple[str, ...]]:
    return [tuple(str(name) for name in row) for row in base.query(goal)]


def test_a_list_of_one_is_any_face_and_of_none_nothing(base: KnowledgeBase) -> None:
    assert found(base, "each_pair(X, Y, [], convex(X, Y))") == [()]
    ones = found(base, "each_pair(X, Y, [A], convex(X, Y))")
    assert sorted(ones) == sorted((name,) for name in FACES if name != "f5")


def test_faces_that_are_given_are_kept(base: KnowledgeBase) -> None:
    every = found(base, "each_pair(X, Y, [A, B, C], adjoins(X, Y))")
    of_one = found(base, "each_pair(X, Y, [A, f3, C], adjoins(X, Y))")
    assert sorted(of_one) == sorted((a, c) for a, b, c in every if b == "f3")
    assert found(base, "each_pair(X, Y, [f9, f3], adjoins(X, Y))") == []  # not in order


def test_each_scene_has_its_own_pairs() -> None:
    with KnowledgeBase() as base:
        goal = "each_pair(X, Y, [A, B], convex(X, Y))"
        facts: list[Fact] = [("face", "f1"), ("face", "f2"), ("convex", "f1", "f2")]
        facts += [("evidence", name, "measured") for name in ("f1", "f2")]
        base.load_scene("s", facts)
        assert found(base, goal) == [("f1", "f2")]
        base.load_scene("s", facts[:2])
        assert found(base, goal) == []


def test_pairs_of_a_crisp_base_have_no_deviations() -> None:
    facts: list[Fact] = [("face", "f1"), ("face", "f2"), ("angle", "f1", "f2", 104.0, 40.0)]
    facts += [("evidence", name, "measured") for name in ("f1", "f2")]
    for crisp in (False, True):
        with KnowledgeBase(crisp=crisp) as base:
            base.load_scene("s", facts)
            assert len(found(base, "each_pair(X, Y, [A, B], near(angle(X, Y), 90, 15))")) == crisp


def test_words_of_a_models_file_are_known_in_it(tmp_path: Path) -> None:
    path = tmp_path / "three.pl"
    path.write_text(
        ":- module(three, []).\n:- use_module(facetlog(vocabulary)).\n"
        'model(three, "Three faces.", [a, b, c]).\n'
        "means(squarish(X, Y), near(angle(X, Y), 90, tolerance(wide))).\n"
        "tolerance(wide, 25).\n"
        "candidate(three, _, [A, B, C]) :- each_pair(X, Y, [A, B, C], squarish(X, Y)).\n"
        'condition(three, square, "square", _, [A, B, C],\n'
        "          each_pair(X, Y, [A, B, C], squarish(X, Y))).\n"
    )
    with KnowledgeBase() as base:
        base.load_scene("s", scene(1))
        base.load_rules(path, trusted=True)
        verdict = base.judge("s", "three", "t1")
        count = len(found(base, "each_pair(X, Y, [A, B, C], near(angle(X, Y), 90, 25))"))
        assert count > 1
        assert verdict.also == count - 1
