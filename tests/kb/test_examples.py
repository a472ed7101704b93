"""Examples of models: what is expected, what came out, and how it is told."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import analyse
from facetlog.grammar.example_scenes import convert_sizes
from facetlog.kb.examples import Case, CaseResult, Expected, list_example_cases, run_cases
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.labelled_scenes import read_labelled_cases
from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid

MODEL = """model slab
  face top
  level: top is level, top is upward
  thin: height(this) at most 20 % of length(this)
  closed: clear_below(top) at most 5 % of length(this)
"""

HOLDS, FAILS, UNKNOWN = State.HOLDS, State.FAILS, State.UNKNOWN


def _facts(scene: Scene) -> tuple[Fact, ...]:
    return tuple(fact.row for fact in scene_facts(scene))


class Maker:
    """Makes blocks, and remembers of what."""

    def __init__(self) -> None:
        self.made: list[object] = []

    def __call__(self, scene: s.SceneFile | s.SceneBuilt, model: Path) -> Iterable[Fact]:
        if isinstance(scene, s.SceneFile):
            raise InputError(f"{model.parent / scene.path.value} does not exist")
        (solid,) = scene.solids
        sizes = convert_sizes(solid)
        self.made.append(sizes)
        return _facts(cuboid(sizes["width"], sizes["depth"], sizes["height"]))


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as found:
        yield found


def _run(
    base: KnowledgeBase, folder: Path, *examples: str, maker: Maker | None = None
) -> list[CaseResult]:
    path = folder / "slab.model"
    path.write_text(MODEL + "".join(f"  example {e}\n" for e in examples), encoding="utf-8")
    analysis = analyse(path)
    assert analysis.errors == ()
    base.load_rules(path)
    return list(run_cases(base, list_example_cases(analysis, maker or Maker())))


FLAT = "of cuboid(width 80 cm, depth 50 cm, height 5 cm)"
THICK = "of cuboid(width 80 cm, depth 50 cm, height 50 cm)"


@pytest.mark.parametrize(
    "example",
    [
        f"{FLAT} holds",
        f"{FLAT} holds at least 90 %",
        f"{FLAT} holds at least 0.9",
        f"{THICK} fails",
        f"{THICK} fails because thin",
    ],
)
def test_what_is_as_expected_passes(example: str, base: KnowledgeBase, tmp_path: Path) -> None:
    (result,) = _run(base, tmp_path, f'"one" {example}')
    assert result.problems == ()
    assert result.passed
    place = f"{tmp_path / 'slab.model'}:6:3"
    (line,) = result.lines()
    assert line.startswith(f'{place}: passed: slab "one" ')


@pytest.mark.parametrize(
    ("example", "problem"),
    [
        (f"{THICK} holds", "it fails, expected was that it holds"),
        (f"{FLAT} fails", "it holds, expected was that it fails"),
        (f"{FLAT} unknown", "it holds, expected was that it is unknown"),
        (f"{THICK} fails because level", "`level` holds, expected was that it fails"),
    ],
)
def test_what_is_not_as_expected_is_told_with_the_reasons(
    example: str, problem: str, base: KnowledgeBase, tmp_path: Path
) -> None:
    (result,) = _run(base, tmp_path, f'"one" {example}')
    assert result.problems == (problem,)
    first, *rest = result.lines()
    assert first == f'{tmp_path / "slab.model"}:6:3: failed: slab "one": {problem}'
    assert any("thin" in line for line in rest)
    assert any("t1's own height" in line for line in rest)


def test_a_scene_that_cannot_be_made_does_not_hide_the_others(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    results = _run(base, tmp_path, '"gone" from "gone.json" holds', f'"one" {FLAT} holds')
    of_title = {result.case.title: result for result in results}
    (problem,) = of_title["gone"].problems
    assert problem == f"the scene: {tmp_path / 'gone.json'} does not exist"
    assert of_title["gone"].verdict is None
    assert of_title["one"].passed


def test_each_scene_is_made_once(base: KnowledgeBase, tmp_path: Path) -> None:
    maker = Maker()
    same = FLAT.replace("80 cm", "0.8 m")
    results = _run(
        base, tmp_path, f'"a" {FLAT} holds', f'"b" {THICK} fails', f'"c" {same} holds', maker=maker
    )
    assert [result.passed for result in results] == [True, True, True]
    assert len(maker.made) == 2
    assert not base.scenes


def _two_things() -> tuple[Fact, ...]:
    """Return a thick block t1, and a small flat one t2 beside it."""
    big, small = _facts(cuboid(0.8, 0.5, 0.5)), _facts(cuboid(0.08, 0.05, 0.005))

    def renamed(fact: Fact) -> Fact:
        names = {"t1": "t2"}
        return (
            fact[0],
            *(
                names.get(a, f"{a}0")
                if isinstance(a, str) and a[:1] in "fevt" and a[1:].isdigit()
                else a
                for a in fact[1:]
            ),
        )

    once = {fact for fact in big if fact[0] in {"up", "metric", "view"}}
    return (*big, *(f for f in map(renamed, small) if f not in once))


@pytest.mark.parametrize(("expected", "thing"), [(HOLDS, "t2"), (UNKNOWN, "t2"), (FAILS, "t1")])
def test_the_main_thing_fits_best_or_is_the_largest(
    expected: State, thing: str, base: KnowledgeBase, tmp_path: Path
) -> None:
    _run(base, tmp_path)
    case = Case("two", "x:1", "slab", Expected(expected), "two", _two_things)
    (result,) = run_cases(base, [case])
    assert result.verdict is not None
    assert result.verdict.thing == thing


def test_labels_name_scene_thing_model_and_state(base: KnowledgeBase, tmp_path: Path) -> None:
    _run(base, tmp_path)
    table = tmp_path / "labels.csv"
    table.write_text(
        "scene,thing,model,expected\ntwo.json,t1,slab,fails\ntwo.json,t2,slab,holds\n\n"
        "two.json,,slab,holds\ntwo.json,t1,slab,holds\n",
        encoding="utf-8",
    )
    cases = read_labelled_cases(table, lambda _: _two_things(), known=base.models)
    assert {case.scene for case in cases} == {str(tmp_path / "two.json")}
    results = list(run_cases(base, cases))
    assert [result.passed for result in results] == [True, True, True, False]
    assert results[3].case.place == f"{table}:6"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ":1: the first line"),
        ("scene,model\n", ":1: the first line"),
        ("scene,model,expected,why\n", ":1: the first line"),
        ("scene,model,expected\na.json,slab,maybe\n", ":2: 'maybe' is none of holds"),
        ("scene,model,expected\na.json,slob,holds\n", ":2: there is no model 'slob'"),
        ("scene,model,expected\n,slab,holds\n", ":2: there should be"),
        ("scene,model,expected\na,slab,holds,x\n", ":2: there should be"),
        ('scene,model,expected\na,"sl', ":2: "),
    ],
)
def test_a_faulty_table_is_refused_with_its_line(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "labels.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_labelled_cases(path, lambda _: (), known=["slab"])
    assert str(caught.value).startswith(f"{path}{says}")


def test_a_table_that_is_no_text_or_not_there_is_refused(tmp_path: Path) -> None:
    (tmp_path / "labels.csv").write_bytes(b"scene,\xff")
    for name, says in (("labels.csv", "UTF-8"), ("gone.csv", "cannot be read")):
        with pytest.raises(InputError, match=says):
            read_labelled_cases(tmp_path / name, lambda _: (), known=["slab"])
