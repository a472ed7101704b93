"""Models of pieces and openings, judged of solids: what holds, and why, in all ways alike."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.builtin_rules import builtin_rules
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.scene_facts import needs_facts_on_demand
from facetlog.perception.facts.all_facts import fact_columns, facts_on_demand, scene_facts
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from tests.perception.pieces.test_hollows import LID, RING
from tests.perception.pieces.test_hollows import of_boxes as changed
from tests.perception.pieces.test_openings import LINTEL, POSTS, SILL, Box, of_boxes
from tests.perception.space.simulated_scans import eye_at, scanned

MODELS = """model table2
  "A board on legs."
  board top where top is level
  at least 3 separate bars leg where leg carries top, leg is on_ground
  high: top_of(top) at least 30 % of height(this)  "it is high"
  legs: each leg: leg is upright, height(leg) at least 50 % of top_of(top)
  bare: there is no piece x where x above top  "nothing stands on it"
  size length: length(top)

model seat2
  "A board to sit on, and one to lean on."
  board seat where seat is level
  board back where back is upright, back above seat
  held: back joins seat, seat carries back
  at least 3 pieces leg where leg carries seat

model rack
  "Boards above one another."
  board top where top is level
  at least 2 boards shelf where shelf is level, shelf below top
  topmost: top_of(top) at least 90 % of height(this)

model brick
  "One block."
  block body where body is on_ground
  alone: there is no piece x where x joins body
  flat: curved(body) at most 10 %
"""
Loaded = tuple[KnowledgeBase, BatchJudge]


@cache
def _scene(name: str) -> Scene:
    return build(name, {})


@cache
def _known(name: str) -> tuple[Fact, ...]:
    return tuple(fact.row for fact in scene_facts(_scene(name)))


@cache
def _on_demand(name: str) -> tuple[Fact, ...]:
    return tuple(fact.row for fact in facts_on_demand(_scene(name)))


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Loaded]:
    path = tmp_path_factory.mktemp("pieces") / "pieces.model"
    path.write_text(MODELS, encoding="utf-8")
    with KnowledgeBase() as base, BatchJudge([path]) as judge:
        base.load_rules(path)
        yield base, judge


def _verdict(base: KnowledgeBase, name: str, model: str) -> Verdict:
    base.load_scene(name, _known(name), on_demand=lambda: _on_demand(name))
    return base.why(name, model)


@pytest.mark.parametrize(
    ("scene", "holding"),
    [
        ("table", {"table2"}),
        ("chair", {"seat2"}),
        ("shelf", {"rack"}),
        ("cuboid", {"brick"}),
    ],
)
@pytest.mark.slow
def test_each_solid_is_what_its_pieces_make(loaded: Loaded, scene: str, holding: set[str]) -> None:
    base, _ = loaded
    models = ("table2", "seat2", "rack", "brick")
    verdicts = {model: _verdict(base, scene, model) for model in models}
    assert {m for m, v in verdicts.items() if v.state is State.HOLDS} == holding


def test_a_block_is_no_board_and_the_proof_says_by_which_shares(loaded: Loaded) -> None:
    said = "\n".join(_verdict(loaded[0], "cuboid", "table2").iter_miss_lines())
    assert "p1 is no board: it is a block (thickness 75.00 % of width, limit 35 %)" in said


def test_a_chair_is_no_table_since_something_stands_on_it(loaded: Loaded) -> None:
    verdict = _verdict(loaded[0], "chair", "table2")
    failing = {c.label for c in verdict.conditions if c.proof.state is State.FAILS}
    assert failing == {"bare"}


def test_who_names_no_piece_does_not_ask_for_them() -> None:
    with BatchJudge() as judge:
        assert not {kind.functor for kind in PIECE_KINDS} & {name for name, _ in judge.needed}
    assert not needs_facts_on_demand((builtin_rules() / "shelf.pl").read_text(encoding="utf-8"))


WINDOW = """model window
  "A flat frame of one opening."
  opening pane
  face front where pane in front
  flat: depth(this) at most 20 % of width(this)
  alone: there is no opening other where other above pane or other below pane
  at least 1 piece rim where rim frames pane
"""


def test_a_window_is_a_frame_with_one_opening_in_its_front(tmp_path: Path) -> None:
    middle = ((0.1, 0.0, 0.9), (1.1, 0.1, 1.1))
    path = tmp_path / "window.model"
    path.write_text(WINDOW, encoding="utf-8")
    found = {}
    with KnowledgeBase() as base:
        base.load_rules(path)
        for name, boxes in {"one": (LINTEL, SILL), "two": (LINTEL, SILL, middle)}.items():
            scene = of_boxes(*POSTS, *boxes)
            facts = tuple(fact.row for fact in scene_facts(scene))
            on_demand = tuple(fact.row for fact in facts_on_demand(scene))
            base.load_scene(name, facts, on_demand=lambda own=on_demand: own)
            found[name] = base.why(name, "window")
    assert found["one"].state is State.HOLDS
    assert next(p.faces for p in found["one"].parts if p.role == "pane") == ("o1",)
    assert [c.label for c in found["two"].list_conditions_in_state(State.FAILS)] == ["alone"]


WORDS = """model book_rack
  "Boards one above the other between two sides that stand beside each other."
  board side_a where side_a is upright
  board side_b where side_b is upright
  board top where top is level
  stand: side_a beside side_b, side_a is on_ground, side_b is on_ground
  square: parallel(side_a, side_b, 10 deg), angle(side_a, top) = 90 deg ± 10 deg
  seen: side_a is measured, top is measured
  rows: shelves_below(top) at least 3  "three boards at least lie below"
  bays: there are at least 2 openings bay where bay beside side_a

model hoop
  "A frame with one hole that is all its own."
  piece rim
  opening hole where hole in rim, hole inside rim
  alone: there is no opening other where other beside hole or other above hole

model two_holes
  "Something one sees through twice."
  opening a, b
  at most 2 openings c where c beside a
  over: there is an opening d where d above a or d below a

model plate
  "A level face with no shelf below it."
  face top where top is level, top is upward
  none: shelves_below(top) = 0, top_of(top) at least 95 % of height(this)

model pit
  "A level board, and walls that stand on its rim."
  board floor where floor is level, floor is on_ground
  at least 3 boards wall where wall is upright, wall joins floor
  deep: each wall: height(wall) at least 30 % of height(this)

model stand
  "A board, and another beneath it that is as large."
  board top where top is level
  board shelf where shelf is level, shelf below top
  under: overlap(shelf, top) at least 90 %

model two_walls
  "Two upright boards and an upright face between them."
  board side where side is upright
  board facing where facing is upright, facing beside side
  face back where back is upright
  deep: height(side) at least 50 % of height(this), height(facing) at least 50 % of height(this)

model tub
  "A space that is open at the top, and nothing else is."
  hollow inner where inner is open_at_top
  wide: mouth(inner) at least 80 %, depth(inner) at least 30 % of height(this)
  alone: there is no hollow other where other is open_at_side

model organ
  "Bars from a rail, evenly one after the other, and each longer than the one before."
  board rail where rail is upright
  at least 4 bars pipe where pipe is level, pipe joins rail
  sorted: order of length(pipe) at least 90 %
  even: smallest spacing of pipe at least 80 % of largest spacing of pipe
"""
OF_WORDS = ("book_rack", "hoop", "two_holes", "plate", "pit", "stand", "two_walls", "tub", "organ")
RAIL = ((0.0, 0.0, 0.0), (0.6, 0.02, 0.1))


def _pipes(places: tuple[float, ...], lengths: tuple[float, ...]) -> tuple[Box, ...]:
    each = zip(places, lengths, strict=True)
    return RAIL, *(((x, 0.02, 0.0), (x + 0.04, 0.02 + length, 0.03)) for x, length in each)


EVENLY, LONGER = (0.02, 0.14, 0.26, 0.38), (0.3, 0.34, 0.38, 0.42)
CHANGES = {
    "as it is": np.eye(3),
    "turned": Rotation.from_euler("z", 70.0, degrees=True).as_matrix(),
    "mirrored": np.diag([-1.0, 1.0, 1.0]),
    "small": 0.2 * np.eye(3),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize(
    ("boxes", "fails"),
    [
        (_pipes(EVENLY, LONGER), set()),
        (_pipes(EVENLY, LONGER[::-1]), set()),
        (_pipes(EVENLY, (0.34, 0.3, 0.42, 0.38)), {"sorted"}),
        (_pipes(EVENLY, (0.3,) * 4), {"sorted"}),
        (_pipes((0.02, 0.14, 0.2, 0.38), LONGER), {"even"}),
    ],
    ids=["rising", "falling", "mixed", "alike", "uneven"],
)
def test_a_row_is_sorted_and_even_in_whatever_frame(
    worded: Loaded, boxes: tuple[Box, ...], fails: set[str], change: str
) -> None:
    verdict = _alike(worded, "row", changed(*boxes, by=CHANGES[change]))["organ"]
    assert {c.label for c in verdict.list_conditions_in_state(State.FAILS)} == fails
    assert verdict.state is (State.FAILS if fails else State.HOLDS)


@pytest.mark.parametrize("change", CHANGES)
def test_a_hollow_is_found_by_models_in_whatever_frame(worded: Loaded, change: str) -> None:
    by = CHANGES[change]
    assert _alike(worded, "ring", changed(*RING, by=by))["tub"].state is State.HOLDS
    assert _alike(worded, "lid", changed(*RING, LID, by=by))["tub"].state is State.FAILS


@pytest.fixture(scope="module")
def worded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Loaded]:
    path = tmp_path_factory.mktemp("words") / "words.model"
    path.write_text(WORDS, encoding="utf-8")
    with KnowledgeBase() as base, BatchJudge([path]) as judge:
        base.load_rules(path)
        yield base, judge


def _alike(worded: Loaded, name: str, scene: Scene) -> dict[str, Verdict]:
    """Return the verdicts of the interpreter, which those of the batch are equal to."""
    base, judge = worded
    columns = fact_columns(scene, {kind for kind, _ in judge.needed})
    brief = {v.model: v for v in judge.judge_columns(columns) if v.thing == "t1"}
    facts = tuple(fact.row for fact in scene_facts(scene))
    on_demand = tuple(fact.row for fact in facts_on_demand(scene))
    base.load_scene(name, facts, on_demand=lambda: on_demand)
    found = {model: base.judge(name, model, "t1") for model in OF_WORDS}
    for model, verdict in found.items():
        assert brief[model].state is verdict.state, model
        assert brief[model].degree == pytest.approx(verdict.degree, abs=1e-3)
        if verdict.state is not State.FAILS:
            assert brief[model].parts == tuple((p.role, p.faces) for p in verdict.parts)
    left = {x for m, c in judge.conditions().items() if m in OF_WORDS for x in c.interpreted}
    assert left == {"sorted"}  # the order of a row
    return found


@pytest.mark.parametrize(
    ("name", "holding", "open_"),
    [
        ("shelf", {"book_rack", "two_holes", "two_walls", "stand"}, set()),
        ("frame", set(), set()),
        ("cuboid", {"plate"}, set()),
        ("table", {"plate"}, set()),
        ("tray", {"plate", "pit", "two_walls", "tub"}, set()),
        ("chair", {"plate"}, set()),
    ],
)
@pytest.mark.slow
def test_words_of_places_and_counts_say_the_same_in_both_ways(
    worded: Loaded, name: str, holding: set[str], open_: set[str]
) -> None:
    found = _alike(worded, name, _scene(name))
    assert {m for m, v in found.items() if v.state is State.HOLDS} == holding
    assert {m for m, v in found.items() if v.state is State.UNKNOWN} == open_


def test_a_closed_mesh_without_a_hole_is_no_hoop_and_says_so(worded: Loaded) -> None:
    verdict = _alike(worded, "plain", of_boxes(((0.0, 0.0, 0.0), (1.0, 0.1, 1.0))))["hoop"]
    assert verdict.state is State.FAILS
    said = "\n".join(verdict.iter_miss_lines())
    assert "none was found, at least 1 is wanted" in said
    assert "there may be more" not in said


def test_a_scan_from_one_side_leaves_open_how_many_openings_there_are(worded: Loaded) -> None:
    solid = _scene("shelf")
    scan = scanned(solid, eye_at(solid, 20.0, 30.0))
    found = _alike(worded, "scan", scan)
    assert {found[model].state for model in ("hoop", "two_holes", "book_rack")} == {State.UNKNOWN}


def test_a_board_that_nobody_saw_is_played_by_none_that_lies_otherwise(worded: Loaded) -> None:
    solid = _scene("frame")
    found = _alike(worded, "side", scanned(solid, eye_at(solid, 20.0, 0.0)))
    for model, part in (("pit", "floor"), ("two_walls", "facing")):
        assert found[model].state is State.UNKNOWN
        assert f"nothing was measured that could be its {part}" in found[model].summary
    # Of a thing that is known from all sides any board is the nearest miss.
    block = _alike(worded, "block", _scene("cuboid"))["pit"]
    assert block.state is State.FAILS
    assert next(part.faces for part in block.parts if part.role == "floor")


POSTS_SEEN_IN_PART = """
model post
  "A post nearly as high as its thing."
  piece post where post is upright
  top: top_of(post) at least 95 % of height(this)
  high: height(post) at least 80 % of height(this)

model stump
  "A post half as high."
  piece post where post is upright
  top: top_of(post) at least 95 % of height(this)
  low: height(post) at most 60 % of height(this)

model tower
  "A post that is higher than its thing."
  piece post where post is upright
  tower: height(post) at least 120 % of height(this)
"""


@pytest.mark.slow
def test_a_post_whose_foot_nobody_saw_may_reach_down_to_the_ground(tmp_path: Path) -> None:
    slab, screen = ((0.0, 0.0, 0.0), (1.0, 0.6, 0.05)), ((0.0, 0.0, 0.05), (1.0, 0.05, 0.5))
    post, shown = ((0.44, 0.4, 0.05), (0.56, 0.52, 1.0)), ((0.44, 0.4, 0.45), (0.56, 0.52, 1.0))
    solid, eye = of_boxes(slab, screen, post), np.array([1.5, -3.0, 0.8])
    scan = scanned(of_boxes(slab, screen, shown), eye)
    scan = replace(scan, sights=scanned(solid, eye).sights)
    path = tmp_path / "posts.model"
    path.write_text(POSTS_SEEN_IN_PART, encoding="utf-8")
    states = {}
    with KnowledgeBase() as base, BatchJudge([path]) as judge:
        base.load_rules(path)
        for name, scene in (("solid", solid), ("scan", scan)):
            facts, more = scene_facts(scene), facts_on_demand(scene)
            rows = tuple(fact.row for fact in (*facts, *more))
            base.load_scene(name, rows)
            states[name] = {m: base.judge(name, m, "t1").state for m in ("post", "stump", "tower")}
            columns = fact_columns(scene, {kind for kind, _ in judge.needed})
            brief = {v.model: v.state for v in judge.judge_columns(columns) if v.thing == "t1"}
            assert states[name].items() <= brief.items()
    holds, fails, unknown = State.HOLDS, State.FAILS, State.UNKNOWN
    assert states == {
        "solid": {"post": holds, "stump": fails, "tower": fails},
        "scan": {"post": unknown, "stump": unknown, "tower": fails},
    }
