"""`board top` and its like: words for pieces where names follow them, and names elsewhere."""

import re
from pathlib import Path

import pytest

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis, analyse
from facetlog.grammar.compile import compiled
from facetlog.grammar.format import formatted
from facetlog.grammar.language_server.completion import completions
from facetlog.grammar.language_server.hover import find_hover_text
from facetlog.grammar.language_server.symbols import SymbolKind, occurrences
from facetlog.grammar.reading.layout import PIECE_WORDS
from facetlog.grammar.reading.parse import parse
from facetlog.grammar.source import Source
from facetlog.grammar.traversal import walk
from facetlog.grammar.vocabulary import HOLLOW, IN_SPACE, OPENING, PIECE, VOCABULARY, Gives

OF_PIECES = (
    "board top",
    "piece a, b",
    "bar x where x is upright",
    'block x  "why"',
    "optional board back",
    "board where where where is level",
    "a: each bar x: x is upright",
    "each board x where x is level: x is upright",
    "each face y: (each block x: x is upright)",
)
OF_NAMES = (
    "board is level",
    "board adjoins top",
    "board.seat is level",
    "board: board is level",
    "block: expect: board is level",
    "each board: board is level",
    "each board of a, b: board is level",
    "each pair board, bar of a, b: board adjoins bar",
    "face board, bar",
    "one table board",
    "board = 3 cm ± 1 cm",
    "bar at least 3",
    "let bar = 3 cm",
    "define block(piece): piece is level",
    "at least 2 separate faces board where board is level",
    "exactly 1 board board",
    "there is a bar board where board is level",
)
OLD = """model shelf2
  face top, piece
  at least 2 separate faces board where board is level, board is upward
  any number of faces bar where bar closes top
  define block(x): x is upright
  define thickness(a): width(a) / 2
  define joins(a, b): a adjoins b
  board: top is level
  block: each board: not board is block
  bars: count(board) at most 3 and count(bar) at most 9
  thin: thickness(top) at most 4 cm
  met: top joins piece
"""
TABLE = """model table2
  board top where top is level
  at least 3 separate bars leg where leg carries top, leg is on_ground
  wide: length(top) at least 3 * thickness(top), top_of(top) at most height(this)
  bare: there is no block x where x above top
"""


def _analysis(text: str) -> Analysis:
    return analyse(Path("m.model"), text)


def _codes(text: str) -> list[str]:
    return [fault.code for fault in _analysis(text).errors]


def _kinds_of_statement(line: str) -> list[str]:
    """The words that stand for pieces."""
    parsed = parse(Source("m", f"model m\n{line}"))
    assert parsed.faults == ()
    (node,) = parsed.file.models[0].statements
    kinds = [n.kind for n in walk(node) if isinstance(n, s.Part | s.Each) and n.kind]
    return [k.text for k in kinds if k.text in PIECE_WORDS and not _is_counted(node)]


def _is_counted(node: object) -> bool:
    return isinstance(node, s.Part) and node.count is not None


@pytest.mark.parametrize("line", OF_PIECES)
def test_they_are_words_where_names_follow(line: str) -> None:
    assert len(_kinds_of_statement(line)) == 1


@pytest.mark.parametrize("line", OF_NAMES)
def test_they_are_names_elsewhere(line: str) -> None:
    assert _kinds_of_statement(line) == []


def test_texts_that_use_them_as_names_stay_valid() -> None:
    assert _codes(OLD) == []


def test_a_model_of_that_name_is_meant_before_a_piece() -> None:
    board = "model board\n  face x\n  x is level\n"
    text = f"{board}model pile\n  one board under\n  at least 2 boards on where on touches under\n"
    text += "  made: under is board\n"
    assert _codes(text) == []
    prolog = compiled(_analysis(text)).prolog
    assert "is_a(Under, board)" in prolog
    assert "piece_in" not in prolog
    assert _codes(f"{board}model pile\n  face y\n  no: there is a board x where x is level\n") == [
        "unknown-kind"
    ]


def test_layout_keeps_them() -> None:
    lines = [f"  {line}\n" for line in (*OF_PIECES, *OF_NAMES)]
    text = "model m\n" + "".join(lines)
    assert formatted(Source("m", text)) == text
    spread = re.sub(r"(?<=[a-z]) (?=[a-z])", "   ", text)
    assert formatted(Source("m", spread)) == text


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("tilt(top) at most 5 deg, angle(top, top) at most 3 deg", "itself"),
        ("each face f: angle(top, f) at most 3 deg", "kind"),
        ("each bar b: offset(top, b) at most 3 cm", "kind"),
        ("each bar b: angle(top, b) at most 3 cm", "dimension"),
        ("thickness(this) at most 5 cm", "kind"),
        ("this is board", "kind"),
        ("there is a face f where f carries top", "kind"),
        ("there is a bord x where x joins top", "unknown-kind"),
        ("top joins top", "itself"),
        ("area(top) at most 3 cm2", "kind"),
        ("thickness(top) at most 5 deg", "dimension"),
    ],
)
def test_words_take_pieces_or_do_not(line: str, code: str) -> None:
    assert code in _codes(f"model m\n  board top\n  a: {line}\n")


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("gap(top, foot) at least 5 cm", "of pieces say `a joins b`: they touch"),
        ("top adjoins foot", "of pieces say `a joins b`"),
        ("side joins back", "of faces say `a adjoins b`, or name pieces: `board top`, `bar leg`"),
        ("side inside back", "name pieces: `board top`, `bar leg`"),
        ("area(top) at most 3 cm2", "`area(face): area`"),
    ],
)
def test_where_a_word_takes_others_there_is_one_that_takes_these(line: str, hint: str) -> None:
    faults = _analysis(f"model m\n  board top, foot\n  face side, back\n  a: {line}\n").faults
    assert next(f.hint for f in faults if f.code == "kind") == hint


def test_words_said_of_pieces_have_other_names_in_prolog() -> None:
    text = compiled(_analysis(TABLE)).prolog
    assert "piece_in(Thing, Top)" in text
    assert "all([board(Top), piece_level(Top)])" in text
    assert "means('table2.leg'(Leg, Top), all([bar(Leg), carries(Leg, Top), piece_on_" in text
    assert "at_least(piece_length(Top), 3*thickness(Top))" in text
    assert "at_most(piece_top_of(Top), thing_height(Thing))" in text
    assert "all([block(X), piece_above(X, Top)])" in text
    # Each piece counts once.
    assert "separate(" not in text


def test_a_piece_is_above_an_opening_by_the_middles_of_both() -> None:
    text = compiled(_analysis("model m\n  board top\n  opening way\n  a: top above way\n")).prolog
    assert "at_least(piece_elevation(Top), opening_elevation(Way))" in text


def test_pieces_that_are_alike_are_tried_in_one_order() -> None:
    text = compiled(_analysis("model m\n  bar a, b\n  met: a joins b\n")).prolog
    assert "A @< B" in text
    other = "model m\n  bar a\n  board b\n  met: a joins b\n"
    assert "@<" not in compiled(_analysis(other)).prolog


def test_that_one_is_a_board_is_a_condition_of_each() -> None:
    text = compiled(_analysis("model m\n  board a, b\n  met: a joins b\n")).prolog
    assert "condition(m, a," in text
    assert "board(B)) " in text or "board(B))." in text


@pytest.mark.parametrize(
    ("before", "there", "missing"),
    [
        ("  ", {"board", "bar", "block", "piece"}, set()),
        ("  each ", {"board"}, set()),
        ("  at least 2 ", {"boards", "bars"}, set()),
        ("  board ne", set(), {"length", "where"}),
        ("  board new ", {"where"}, set()),
        ("  at least 2 bars le", set(), {"length"}),
        ("  a: there is a bar rail where ", {"rail", "thickness"}, set()),
        ("  a: top ", {"carries", "joins", "beside", "inside"}, set()),
        ("  a: there is an opening way where ", {"way", "shelves_below"}, set()),
        ("  a: top is ", {"board", "bar", "block", "level"}, set()),
    ],
)
def test_they_are_completed(before: str, there: set[str], missing: set[str]) -> None:
    text = TABLE + before
    found = {item.label for item in completions(_analysis(TABLE), text, len(text), {})}
    assert there <= found
    assert not missing & found


def test_hovering_says_what_a_board_is() -> None:
    analysis = _analysis(TABLE)
    words = {
        TABLE[one.span.start : one.span.end]: one.symbol
        for one in occurrences(analysis).every
        if one.symbol.kind is SymbolKind.WORD
    }
    assert {"board", "bar", "block", "carries", "thickness"} <= words.keys()
    assert "at most 35 %" in find_hover_text(analysis, words["board"], {})


def test_older_texts_may_call_their_own_by_the_new_words() -> None:
    old = """model shelf3
  face top, front, side
  any number of faces inside where inside below top
  define beside(a, b): a adjoins b
  define shelves_below(f): f is level
  beside: top beside side, front beside side
  kept: each inside: shelves_below(inside)
"""
    assert _codes(old) == []
    assert "piece_" not in compiled(_analysis(old)).prolog


def test_openings_are_counted_as_far_as_they_are_known() -> None:
    text = compiled(
        _analysis(
            "model m\n  opening way\n  at most 2 openings hole where hole below way\n"
            "  a: there is no opening x where x above way\n"
        )
    ).prolog
    assert "at_least_in(1, openings_known(Thing), Opening, Openings, all([]))" in text
    assert "'m.hole'(Hole, Way)), openings_known(Thing)])" in text
    assert "all([not(some(X, Xs, opening_above(X, Way))), openings_known(Thing)])" in text


def test_hollows_are_counted_as_far_as_they_are_known() -> None:
    text = compiled(
        _analysis(
            "model m\n  hollow bay where bay is open_at_side\n  board top\n"
            "  a: top above bay, depth(bay) at least 20 % of length(bay)\n"
            "  b: there is no hollow x where mouth(x) at most 10 %\n"
        )
    ).prolog
    assert "at_least_in(1, hollows_known(Thing), Hollow, Hollows, all([]))" in text
    assert "opening_open_at_side(Bay)" in text
    assert "hollows_known(Thing)])" in text


def test_words_of_pieces_and_openings_yield_and_so_do_three_of_levels() -> None:
    yields = {word.name for word in VOCABULARY.values() if word.yields}
    own = {w.name for w in VOCABULARY.values() if w.arguments[0] in (PIECE, OPENING, HOLLOW)}
    own |= {w.name for w in VOCABULARY.values() if w.arguments[0] == IN_SPACE}
    assert yields == own | {
        "enclosed",
        "front_depth",
        "front_width",
        "shelves_below",
        "side_behind",
    }
    assert VOCABULARY["thickness"].gives is Gives.LENGTH
