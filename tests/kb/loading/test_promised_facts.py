"""Facts on demand: made at the first question or model that names them, once, and never before."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.scene_facts import needs_facts_on_demand
from facetlog.kb.recognize import judge_scene
from facetlog.perception.facts.fact_schema import ON_DEMAND

# An arrow's corner of a floating cube, as one view shows it.
SEEN: tuple[Fact, ...] = (
    ("thing", "t1"),
    ("face", "f1"),
    ("evidence", "f1", "measured"),
    ("part_of", "f1", "t1"),
    ("view", "view1", "a.png"),
)
DRAWN: tuple[Fact, ...] = (
    ("junction", "view1", "v1", "t"),
    ("junction", "view1", "v2", "end"),
    ("line_at", "view1", "v1", 1, "v2", "e1"),
)
POINTED = """
model(pointed, "A face of a thing that a T was seen at.", [f]).
candidate(pointed, T, [F]) :- face_of(T, F), fact(junction(_, _, t)).
condition(pointed, seen, "its face was measured", _, [F], measured(F)).
"""


class Maker:
    """Counts how often it is asked."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> Iterator[Fact]:
        self.calls += 1
        return iter(DRAWN)


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        yield base


def test_words_that_rest_on_them_are_known() -> None:
    assert all(needs_facts_on_demand(f"{word}(V, X, Y)") for word in ON_DEMAND)
    assert not needs_facts_on_demand("adjunction(X), my_contour(Y), junctions(Z), face(F)")


def test_names_of_pieces_count_where_something_is_said_of_them() -> None:
    assert all(
        map(needs_facts_on_demand, ("board(P)", "piece_in(T, P)", "piece_cover(P)", "thickness(P)"))
    )
    assert not any(
        map(needs_facts_on_demand, ("group(shelf, board, X)", "'shelf.board'(X)", "bars, block"))
    )


def test_a_question_that_names_them_makes_them_once(base: KnowledgeBase) -> None:
    maker = Maker()
    assert base.load_scene("s", SEEN, on_demand=maker).facts == len(SEEN)
    assert len(list(base.query("face(F)"))) == 1
    assert [v.state.value for v in (base.judge("s", m, "t1") for m in base.models)]
    assert maker.calls == 0
    for _ in range(2):
        assert [str(j) for (j,) in base.query("junction(view1, J, t)")] == ["v1"]
        assert [str(j) for (j,) in base.query("fact(junction(view1, J, end))")] == ["v2"]
    assert maker.calls == 1


def test_only_scenes_that_are_asked_get_theirs(base: KnowledgeBase) -> None:
    one, two = Maker(), Maker()
    base.load_scene("one", SEEN, on_demand=one)
    base.load_scene("two", SEEN, on_demand=two)
    assert len(list(base.query("junction(V, J, T)", scenes=("one",)))) == 2
    assert (one.calls, two.calls) == (1, 0)
    assert len(list(base.query("junction(V, J, T)"))) == 4


def test_a_replaced_scene_is_asked_anew_and_a_dropped_one_no_more(base: KnowledgeBase) -> None:
    old, new = Maker(), Maker()
    base.load_scene("s", SEEN, on_demand=old)
    base.load_scene("s", SEEN, on_demand=new)
    assert len(list(base.query("junction(V, J, T)"))) == 2
    assert (old.calls, new.calls) == (0, 1)
    base.drop_scene("s")
    base.load_scene("other", SEEN)
    assert list(base.query("junction(V, J, T)")) == []


def test_what_cannot_be_made_is_told_and_may_be_asked_again(base: KnowledgeBase) -> None:
    failures = [InputError("the file is gone")]

    def make() -> Iterator[Fact]:
        if failures:
            raise failures.pop()
        return iter(DRAWN)

    base.load_scene("s", SEEN, on_demand=make)
    with pytest.raises(InputError, match="the file is gone"):
        base.query("junction(V, J, T)")
    assert len(list(base.query("junction(V, J, T)"))) == 2


def test_a_model_that_asks_for_them_has_them_in_every_question(tmp_path: Path) -> None:
    path = tmp_path / "pointed.pl"
    path.write_text(POINTED, encoding="utf-8")
    maker = Maker()
    with KnowledgeBase() as base:
        base.load_rules(path, trusted=True)
        found = judge_scene(base, "s", SEEN, on_demand=maker)
        states = {v.model: v.state.value for v in found.verdicts}
        assert states["pointed"] == "holds"
        assert maker.calls == 1


def test_origins_of_such_facts_are_told(base: KnowledgeBase) -> None:
    maker: Callable[[], Iterator[Fact]] = Maker()
    base.load_scene("s", SEEN, on_demand=maker)
    assert base.origin("s", "junction(view1, v1)")
