"""Models into Prolog: readable, stable, each clause with its line; judged as they are meant."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import RuleSyntaxError
from facetlog.grammar.analysis import analyse
from facetlog.grammar.compile import Program, compiled
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids import polyhedra
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.scene_file import read_scene

BOX = """model block
  "Three faces that meet square."
  let square = 15 deg
  face a, b, c
  corner: each pair x, y of a, b, c: x adjoins y, angle(x, y) = 90 deg ± square  "they are square"
  full: each x of a, b, c: share(x) at least 80 %
"""

LEGS = """model stand
  face top where top is level, top is upward
  {parts}
  {lines}
"""


def program(text: str) -> Program:
    return compiled(analyse(Path("m.model"), text))


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as made:
        yield made


def judged(
    base: KnowledgeBase, tmp_path: Path, text: str, scene: Scene, thing: str = "t1"
) -> Verdict:
    """The verdict of the last model of a text."""
    path = tmp_path / "m.model"
    path.write_text(text)
    rules = base.load_rules(path, trusted=True)
    base.load_scene("s", [f.row for f in (*scene_facts(scene), *facts_on_demand(scene))])
    return base.judge("s", rules.models[-1], thing)


def stand(parts: str = "", lines: str = "ok: top is level") -> str:
    return LEGS.format(parts=parts, lines=lines)


# ---------------------------------------------------------------- the text


def test_each_line_becomes_a_condition_that_names_its_line_and_text() -> None:
    text = program(BOX).prolog
    assert "% m.model:5  each pair x, y of a, b, c: x adjoins y, angle(x, y)" in text
    assert "each_pair(X, Y, [A, B, C]," in text
    assert "near(angle(X, Y), 90, 15)" in text
    assert (
        "written(block, full, 'm.model:6', \"each x of a, b, c: share(x) at least 80 %\")" in text
    )


def test_symmetric_parts_are_tried_in_one_order_and_neighbours_before_angles() -> None:
    text = program(BOX).prolog
    likely = text[text.index("likely(block, Thing, [A, B, C]) :-") :]
    order = ["face_of(Thing, A)", "shared_edge(A, B, _)", "A @< B", "near(angle(A, B)", "B @< C"]
    places = [likely.index(goal) for goal in order]
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("line", "swapped"),
    [
        ("each pair x, y of a, b: x above y", False),
        ("not (each pair x, y of a, b: x above y)", False),
        ("not (each pair x, y of a, b: x adjoins y)", True),
        ("share(a) at least 50 %, share(b) at least 0.5", True),
        ("share(a) at least 50 % sharp, share(b) at least 50 %", False),
        ("share(a) at least 50 % fading 5 %, share(b) at least 50 % fading 10 %", False),
        ("share(a) at least share(b)", False),
    ],
)
def test_parts_are_swapped_only_if_what_is_said_of_them_stays(line: str, *, swapped: bool) -> None:
    text = program(f"model m\n  face a, b\n  l: {line}\n").prolog
    assert ("@<" in text) is swapped


@pytest.mark.parametrize(
    ("body", "swapped"),
    [
        ("x adjoins y, angle(y, x) = 90 deg ± 5 deg", True),
        ("beside(x, y)", True),
        ("x adjoins y, x is level", False),
        ("offset(x, y) at least 1 cm", False),
    ],
)
def test_parts_of_a_definition_are_swapped_if_it_reads_the_same_changed_about(
    body: str, *, swapped: bool
) -> None:
    text = (
        "model m\n  define beside(f, g): f adjoins g, convex(g, f)\n"
        f"  define of_both(x, y): {body}\n  face a, b\n  l: of_both(a, b)\n"
    )
    assert ("@<" in program(text).prolog) is swapped


def test_a_reason_that_is_the_line_itself_keeps_its_brackets() -> None:
    (line,) = (
        analyse(
            Path("m.model"), "model m\n  face a\n  l: a is level, (a is upward or a is upright)\n"
        )
        .models["m"]
        .written.lines
    )
    assert line.condition.span.end == line.span.end


def test_an_optional_part_may_be_found_by_others(base: KnowledgeBase, tmp_path: Path) -> None:
    text = (
        "model m\n  face a where a is level\n"
        "  optional face back where there is a face g where g adjoins back, g is level\n"
        "  l: a is level\n"
    )
    verdict = judged(base, tmp_path, text, polyhedra.cuboid())
    assert {p.role: bool(p.faces) for p in verdict.parts} == {"a": True, "back": True}


def test_parts_of_which_something_different_is_said_are_not_swapped() -> None:
    text = program(BOX + "  base: share(a) at least 90 %\n").prolog
    assert "A @< B" not in text
    assert "B @< C" in text


def test_the_same_text_gives_the_same_program() -> None:
    assert program(BOX).prolog == program(BOX).prolog
    moved = program(BOX.replace("  face a", "\n\n  face a"))
    assert [c.head for c in moved.clauses if c.head.functor == "condition"] == [
        c.head for c in program(BOX).clauses if c.head.functor == "condition"
    ]


def test_names_that_prolog_has_and_texts_with_quotes_stay_names_and_texts(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    text = (
        'model halt\n  "It\'s \\\\ a % thing."\n  face call, Assert, größe\n'
        "  member: call adjoins Assert, größe adjoins call \"halt. :- 'x'\"\n"
    )
    verdict = judged(base, tmp_path, text, polyhedra.cuboid())
    assert verdict.state is State.HOLDS
    assert [p.role for p in verdict.parts] == ["call", "Assert", "größe"]
    assert verdict.conditions[0].reason == "halt. :- 'x'"


def test_a_file_with_errors_is_not_compiled_and_all_are_reported() -> None:
    with pytest.raises(RuleSyntaxError) as caught:
        program("model m\n  face f\n  a: f is levl\n  b: g is level\n")
    assert str(caught.value).count("m.model:") == 2


def test_models_of_one_file_stand_side_by_side(base: KnowledgeBase, tmp_path: Path) -> None:
    path = tmp_path / "m.model"
    path.write_text(BOX + stand())
    assert base.load_rules(path).models == ("block", "stand")


# -------------------------------------------------------------- the meaning


def test_a_set_is_all_that_satisfies_its_condition(base: KnowledgeBase, tmp_path: Path) -> None:
    legs = "exactly 4 separate elements leg where leg supports top"
    verdict = judged(base, tmp_path, stand(legs), build("table", {}))
    assert verdict.state is State.HOLDS
    (part,) = (p for p in verdict.parts if p.role == "leg")
    assert len(part.faces) >= 4
    assert [c.label for c in verdict.conditions] == ["top", "leg", "ok"]


@pytest.mark.parametrize(
    ("count", "state"),
    [
        ("at least 4", State.HOLDS),
        ("at least 5", State.UNKNOWN),
        ("at most 4", State.HOLDS),
        ("at most 3", State.FAILS),
        ("exactly 4", State.HOLDS),
        ("between 2 and 3", State.FAILS),
        ("any number of", State.HOLDS),
    ],
)
@pytest.mark.slow
def test_counts_of_legs(count: str, state: State, base: KnowledgeBase, tmp_path: Path) -> None:
    legs = f"{count} separate elements leg where leg supports top"
    assert judged(base, tmp_path, stand(legs), build("table", {})).state is state


ON_BARS = """model on_bars
  board top
  level: top is level
  {line}
"""


@pytest.mark.parametrize(
    "line",
    [
        "at least 3 bars leg where leg carries top",
        "any number of bars leg where leg carries top\n  ok: count(leg) at least 3",
        "ok: there are at least 3 bars leg where leg carries top",
    ],
)
@pytest.mark.parametrize(
    ("scene", "state"),
    [
        (build("table", {}), State.HOLDS),
        # all of a thing that is known from all sides is known to be no bar
        (build("bench", {}), State.FAILS),
        # of what pictures show there may be more
        (read_scene(Path("rules/scenes/table_two_legs.json")), State.UNKNOWN),
    ],
    ids=["table", "bench", "two legs in sight"],
)
@pytest.mark.slow
def test_too_few_pieces_fail_where_all_are_known(
    line: str, scene: Scene, state: State, base: KnowledgeBase, tmp_path: Path
) -> None:
    verdict = judged(base, tmp_path, ON_BARS.format(line=line), scene)
    assert verdict.state is state
    if state is State.FAILS:
        assert "at least 3 are wanted" in "".join(verdict.lines())
        assert "may be more" not in "".join(verdict.lines())


@pytest.mark.parametrize(
    ("line", "state"),
    [
        ("count(leg) = 4", State.HOLDS),
        ("count(leg) at least 5 or count(leg) at most 4", State.HOLDS),
        ("each leg: leg is upright, bottom_of(leg) at most 1 cm", State.HOLDS),
        ("each leg: height(leg) at least 5 m", State.FAILS),
        ("each pair x, y of leg: not x is level", State.HOLDS),
        ("there is a element e of leg where height(e) at least 20 cm", State.HOLDS),
        ("there is no element e of leg where height(e) at least 5 m", State.HOLDS),
        ("there are at least 9 faces e where e is upright", State.HOLDS),
        ("there is a face e where e underside_of top", State.HOLDS),
        ("there is no face e where e underside_of top", State.FAILS),
        ("each face e where e is level: e is upright", State.FAILS),
        ("each face e where tilt(e) between 20 deg and 70 deg: e is level", State.HOLDS),
        ("not top is upright, top is not downward", State.HOLDS),
        ("lowest of top_of(leg) at least 50 % of elevation(top)", State.HOLDS),
        ("highest of bottom_of(leg) at least 50 % of elevation(top)", State.FAILS),
        ("sum of height(leg) at least 1 m and mean of height(leg) at most 1 m", State.HOLDS),
        ("elevation(top) = 74 cm ± 5 %", State.HOLDS),
        ("elevation(top) = 90 cm ± 10 %", State.FAILS),
        ("elevation(top) about 80 cm", State.HOLDS),
        ("elevation(top) about 94 cm", State.FAILS),
        ("elevation(top) at least 76 cm fading 10 cm", State.HOLDS),
        ("elevation(top) at least 90 cm fading 10 cm", State.FAILS),
        ("2 * width(top) - length(top) at least 0", State.HOLDS),
        ("area(top) at most 4 m2 and length(top) / width(top) at most 300 %", State.HOLDS),
        ("count(leg) = 5 ± 50 %", State.HOLDS),
        ("count(leg) about 4", State.HOLDS),
        ("4 = count(leg)", State.HOLDS),
        ("3 at most count(leg)", State.HOLDS),
        ("9 at most count(leg)", State.UNKNOWN),
        ("count(leg) * 2 = 8 ± 10 %", State.HOLDS),
        ("this is table", State.HOLDS),
        ("this is not chair", State.HOLDS),
        ("expect: elevation(top) at least 5 m", State.HOLDS),
    ],
)  # fmt: skip
@pytest.mark.slow
def test_a_line_says_what_it_says(
    line: str, state: State, base: KnowledgeBase, tmp_path: Path
) -> None:
    legs = "any number of separate elements leg where leg supports top"
    written = line if line.startswith("expect") else f"line: {line}"
    text = stand(legs, written)
    verdict = judged(base, tmp_path, text, build("table", {"height": 0.74}))
    assert verdict.state is state, "\n".join(verdict.lines(full=True))


def test_absolute_lengths_are_open_where_the_scale_is_not_known(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    from dataclasses import replace

    scene = replace(build("table", {}), metric=False)
    tall = "tall: elevation(top) at least 5 m"
    assert judged(base, tmp_path, stand(lines=tall), scene).state is State.UNKNOWN
    tall = "tall: if known: elevation(top) at least 5 m"
    assert judged(base, tmp_path, stand(lines=tall), scene).state is State.HOLDS


def test_an_absent_optional_part_is_asked_nothing(base: KnowledgeBase, tmp_path: Path) -> None:
    back = "optional face back where back is upright, top_of(back) at least 130 % of elevation(top)"
    line = "broad: length(back) at least 50 % of width(top)"
    text = stand(back, line)
    assert judged(base, tmp_path, text, build("table", {})).state is State.HOLDS
    chair = judged(base, tmp_path, text, build("chair", {}))
    assert chair.state is State.HOLDS
    assert {p.role: bool(p.faces) for p in chair.parts} == {"top": True, "back": True}


def test_a_model_that_is_another_adds_lines_and_says_so(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    text = stand() + "model low is stand\n  low: elevation(top) at most 50 cm\n"
    verdict = judged(base, tmp_path, text, build("table", {"height": 0.74}))
    assert [c.label for c in verdict.conditions] == ["top", "ok", "low"]
    assert verdict.state is State.FAILS
    assert verdict.specialises == ("stand",)


@pytest.mark.slow
def test_a_models_name_goes_before_others_and_judges_nothing(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    text = stand() + "model other\n  face f\n  a: f is upright\n"
    text += "model high like stand rather than stand, other\n"
    scene = build("table", {})
    assert judged(base, tmp_path, text, scene).rather_than == ("stand", "other")
    with BatchJudge([tmp_path / "m.model"]) as judge:
        found = {v.model: v for v in judge.judge([f.row for f in scene_facts(scene)])}
    assert found["high"].rather_than == ("stand", "other")
    assert found["stand"].rather_than == ()


def test_a_model_like_another_replaces_and_drops_lines(base: KnowledgeBase, tmp_path: Path) -> None:
    first = stand(lines="low: elevation(top) at most 50 cm\n  ok: share(top) at most 10 %")
    text = first + "model high like stand\n  low: elevation(top) at least 50 cm\n  drop ok\n"
    verdict = judged(base, tmp_path, text, build("table", {"height": 0.74}))
    assert [c.label for c in verdict.conditions] == ["top", "low"]
    assert verdict.state is State.HOLDS


def test_a_model_of_objects_is_judged_at_its_first(base: KnowledgeBase, tmp_path: Path) -> None:
    text = """model set
  one table board
  at least 2 chairs seat where gap(seat, board) at most 2 m
  lower: each seat: elevation(seat.seat) at most elevation(board.top)
"""
    chair = build("chair", {})
    scene = polyhedra.together(
        build("table", {"length": 1.4, "width": 0.8}),
        polyhedra.moved(chair, translation=(0.0, -1.2, 0.0)),
        polyhedra.moved(chair, translation=(0.5, 1.2, 0.0)),
    )
    verdict = judged(base, tmp_path, text, scene)
    assert verdict.state is State.HOLDS, "\n".join(verdict.lines(full=True))
    assert {p.role: len(p.faces) for p in verdict.parts} == {"board": 1, "seat": 2}
    assert base.judge("s", "set", "t2").state is not State.HOLDS


def test_words_of_the_user_s_own_are_asked(base: KnowledgeBase, tmp_path: Path) -> None:
    (tmp_path / "w.pl").write_text(
        'word(lean(face), angle, "how far it leans").\n'
        'word(lying(face), condition, "it lies").\n'
        "measured(lean(F), Value, Sd, deg) :- measure(tilt(F), Tilt, Sd, _), Value is 90 - Tilt.\n"
        "means(lying(F), at_least(tilt(F), 0)).\n"
    )
    text = 'use "w.pl"\n' + stand(lines="leans: lean(top) at least 80 deg, top is lying")
    verdict = judged(base, tmp_path, text, build("table", {}))
    assert verdict.state is State.HOLDS, "\n".join(verdict.lines(full=True))


def test_a_verdict_shows_the_author_s_lines(base: KnowledgeBase, tmp_path: Path) -> None:
    verdict = judged(base, tmp_path, BOX, polyhedra.cuboid())
    corner = verdict.conditions[0]
    assert (corner.label, corner.reason, corner.place) == ("corner", "they are square", "m.model:5")
    assert corner.text.startswith("each pair x, y of a, b, c")
    assert "[m.model:5: each pair x, y" in "\n".join(verdict.lines(full=True))


def test_faults_in_prolog_beside_a_model_are_reported_where_they_stand(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    (tmp_path / "w.pl").write_text(
        ':- module(w, []).\n\nword(lean(face), angle, "x").\n'
        "measured(lean(_), V, 0, deg) :- V = = 1.\n"
    )
    (tmp_path / "m.model").write_text('use "w.pl"\n' + stand(lines="l: lean(top) at most 3 deg"))
    with pytest.raises(RuleSyntaxError, match=r"^w\.pl:4: .*[Ss]yntax"):
        base.load_rules(tmp_path / "m.model", trusted=True)
