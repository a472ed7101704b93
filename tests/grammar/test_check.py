"""Names and dimensions: each fault once, where it is, with the way out."""

from pathlib import Path

import pytest

from facetlog.grammar.analysis import Analysis, analyse
from facetlog.grammar.faults import Fault
from facetlog.grammar.source import Source
from facetlog.grammar.vocabulary import VOCABULARY, Gives

MODEL = """model thing
  "A thing."
  let square = 15 deg
  define free(f): clear_below(f) at least 5 % of elevation(top)
  face top, side
  any number of separate elements leg where leg supports top
"""


def checked(text: str, **others: str) -> Analysis:
    """A file and the others that it may use, read from memory."""

    def read(path: Path) -> str:
        if path.stem in others:
            return others[path.stem]
        raise FileNotFoundError(path)

    return analyse(Path("m.model"), text, read=read)


def fault(line: str) -> Fault:
    """The only error that a line brings into the model."""
    (found,) = checked(
        f"{MODEL}  {line}\n  ok: top is level, side adjoins top, count(leg) = 3\n"
    ).errors
    return found


def blamed(found: Fault) -> str:
    return found.source.text[found.span.start : found.span.end]


def test_a_sound_model_has_no_errors() -> None:
    assert (
        checked(MODEL + "  ok: free(top), tilt(side) = 90 deg ± square, count(leg) = 3\n").errors
        == ()
    )


@pytest.mark.parametrize(
    ("line", "code", "word", "hint"),
    [
        ("a: topp is level", "unknown-name", "topp", "`top`"),
        ("a: top is levl", "unknown-word", "levl", "`level`"),
        ("a: side adjoin top", "unknown-word", "adjoin", "`adjoins`"),
        ("a: angel(top, side) at most 3 deg", "unknown-word", "angel", "`angle`"),
        ("a: angle(top) at most 3 deg", "arity", "angle", "angle(face/piece, face/piece)"),
        ("a: free(top, side)", "arity", "free", "free(f)"),
        ("a: tilt(top) at most 3 degs", "unknown-unit", "degs", "`deg`"),
        ("a: tilt(top) at most 3", "dimension", "3", "15 deg"),
        ("a: tilt(top) at most 3 cm", "dimension", "3 cm", ""),
        ("a: width(top) at most square", "dimension", "square", ""),
        ("a: area(top) at least 3 cm", "dimension", "3 cm", ""),
        ("a: width(top) + tilt(top) at least 3 cm", "dimension", "width(top) + tilt(top)", ""),
        ("a: width(top) at least 3 cm of width(top)", "dimension", "3 cm", "50 % of"),
        ("a: width(top) = 3 cm", "no-tolerance", "width(top) = 3 cm", "±"),
        ("a: width(top)", "not-condition", "width(top)", "compare"),
        ("a: top", "not-condition", "top", "is level"),
        ("a: top is length", "not-condition", "length", "compare it: `length(top) at least"),
        ("a: top is enclosed", "not-condition", "enclosed", "compare it: `enclosed(top) at"),
        ("a: top offset side", "not-condition", "offset", "compare it: `offset(top, side) at"),
        ("a: top at least 3 cm", "not-measure", "top", "length(top)"),
        ("a: level at least 3 cm", "word", "level", "top is level"),
        ("a: free is level", "word", "free", "free(...)"),
        ("a: leg is upright", "set", "leg", "each leg"),
        ("a: count(top) at least 3", "set", "count(top)", "leg"),
        ("a: lowest of width(top) at least 3 cm", "set", "lowest of width(top)", "lowest of"),
        ("a: each top: top is level", "set", "top", "each x of"),
        ("a: each x of top: x is level", "set", "top", "several"),
        ("a: each legg: legg is upright", "unknown-name", "legg", "`leg`"),
        ("a: each x of top, leg: x is level", "set", "leg", ""),
        ("a: each pair x, x of top, side: x adjoins x", "taken", "x", "another"),
        ("a: each top of top, side: top is level", "taken", "top", "another"),
        ("a: there is a fase x where x is level", "unknown-kind", "fase", "`face`"),
        ("a: edge_length(top) at least 3 cm", "kind", "top", "edge_length(edge)"),
        ("a: gap(top, this) at least 3 cm", "kind", "top", "gap(thing, thing)"),
        ("a: free(this)", "kind", "free(this)", "line 4"),
        ("a: top.seat is level", "member", "top", ""),
        ("expect 300 %: top is level", "weight", "top is level", ""),
        ("let square = 3 deg", "twice", "square", ""),
        ("let top = 3 deg", "taken", "top", "another"),
        ("let angle = 3", "taken", "angle", "another"),
        ("let tall = width(top)", "not-constant", "width(top)", "define"),
        ("let round = round", "not-constant", "round", "define"),
        ("let huge = 1e999", "number", "1e999", ""),
        ("face top", "taken", "top", "another"),
        ("chairr seat", "part", "chairr", ""),
        ("one chairr seat", "unknown-kind", "chairr", "`chair`"),
        ("one chair seat", "mixed", "chair", "one table board"),
        ("face x, y where x is level", "where", "y", "by itself"),
        ("exactly 1.5 faces x", "count", "1.5", ""),
        ("at least 0.5 faces x", "count", "0.5", ""),
        ("between 4 and 2 faces x", "count", "4", ""),
        ("define loop(f): loop(f)", "cycle", "loop", ""),
        ("define f(x, x): x is level", "taken", "x", ""),
        ("define f(top): top is level", "taken", "top", "another"),
        ("size height: tilt(top)", "dimension", "tilt(top)", ""),
        ("size a, b: width(top)", "size", "a", ""),
        ("drop ok", "drop", "drop ok", ""),
        ('example "e" of table() fails because okk', "unknown-line", "okk", "`ok`"),
        ('example "e" of table(width 3 inchs) holds', "unknown-unit", "inchs", "`inches`"),
        ('example "e" of table() holds at least 3 cm', "dimension", "3 cm", ""),
        ('use "absent.model"', "use", '"absent.model"', ""),
        ('use "words.txt"', "use", '"words.txt"', ".model"),
    ],
)
def test_a_fault_is_reported_once_and_where_it_is(
    line: str, code: str, word: str, hint: str
) -> None:
    found = fault(line)
    assert (found.code, blamed(found)) == (code, word)
    assert hint in found.hint


def test_a_fault_in_a_definition_is_reported_where_it_is_written_and_not_at_its_calls() -> None:
    text = MODEL + "  define bad(f): f is levl\n  a: bad(top)\n  b: bad(side), count(leg) = 3\n"
    (found,) = checked(text).errors
    assert blamed(found) == "levl"


def test_what_stands_before_the_first_model_is_checked_too() -> None:
    (found,) = checked("let a = 3 cm + 5 deg\nmodel m\n  face f\n  b: f is level\n").errors
    assert (found.code, blamed(found)) == ("dimension", "3 cm + 5 deg")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("let level = 3 deg", "taken"),
        ("let a = 3\nlet a = 4", "twice"),
        ("let a = b", "unknown-name"),
    ],
)
def test_names_before_the_first_model_are_free_and_given_once(text: str, code: str) -> None:
    (found,) = checked(f"{text}\nmodel m\n  face f\n  b: f is level\n").errors
    assert found.code == code


def test_a_model_whose_only_line_cannot_be_read_is_not_said_to_lack_it() -> None:
    (found,) = checked("model m\n  face f\n  a: f is is is\n").errors
    assert found.code == "syntax"


@pytest.mark.parametrize("name", ["level", "count", "size", "none", "error"])
def test_a_model_is_not_called_like_a_word(name: str) -> None:
    found = checked(f"model {name}\n  face f\n  b: f is level\n").errors
    assert [f.code for f in found] == ["taken"]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("model m\n  a: this is table\n", "no-parts"),
        ("model m\n  any number of faces f\n  a: count(f) = 3\n", "no-parts"),
        ("model m\n  face f\n", "no-lines"),
        ("model m\n  piece f\n  at least 0 bars g\n", "no-lines"),
        ("model m\n  face f\n  a: f is level\nmodel m\n  face f\n  a: f is level\n", "twice"),
        ("model m\n  face f\n  a: f is level\n  a: f is upward\n", "twice"),
        ("model m is m\n  face f\n  a: f is level\n", "cycle"),
        ("model m is absent\n  face f\n  a: f is level\n", "unknown-model"),
        ("model m\n  one n x\n  a: x is n\nmodel n\n  one m y\n  a: y is m\n", "cycle"),
        ("model m\n  face f\n  a: not this is m\n", "cycle"),
        ("model m rather than m\n  face f\n  a: f is level\n", "cycle"),
        ("model m rather than n\n  face f\n  a: f is level\n", "unknown-model"),
        (
            "model m rather than n\n  face f\n  a: f is level\n"
            "model n rather than m\n  face f\n  a: f is level\n",
            "cycle",
        ),
        (
            "model m rather than n\n  face f\n  a: f is level\n"
            "model n rather than k\n  face f\n  a: f is level\n"
            "model k rather than m\n  face f\n  a: f is level\n",
            "cycle",
        ),
        (
            "model m rather than n\n  face f\n  a: f is level\n"
            "model n is m\n  b: f is upward\n",
            "cycle",
        ),
        ("model m\n  " + "face " + ", ".join(f"f{i}" for i in range(20)) + "\n  a: f1 is level\n",
         "too-many"),
    ],
)  # fmt: skip
def test_a_model_as_a_whole(text: str, code: str) -> None:
    assert code in {f.code for f in checked(text).errors}


def test_definitions_that_name_one_another_are_checked_in_no_more_than_linear_time() -> None:
    lines = ["define d0(f): f is level"]
    lines += [f"define d{i}(f): d{i - 1}(f), d{i - 1}(f)" for i in range(1, 25)]
    text = "model m\n  face top\n" + "\n".join(lines) + "\n  a: d24(top)\n"
    assert {f.code for f in checked(text).errors} == {"too-large"}


@pytest.mark.parametrize("turned", [False, True])
def test_definitions_within_definitions_are_no_deeper_than_anyone_can_follow(turned: bool) -> None:
    lines = ["define d0(f): 2 * length(f)"]
    lines += [
        f"define d{i}(f): " + "(" * 30 + f"d{i - 1}(f)" + " + 1 * width(f))" * 30
        for i in range(1, 25)
    ]
    defined = "\n".join(reversed(lines) if turned else lines)
    text = f"model m\n  face top\n{defined}\n  a: d24(top) at least width(top)\n"
    assert {f.code for f in checked(text).errors} == {"too-large"}


def test_a_used_file_gives_models_definitions_and_faults_of_its_own() -> None:
    other = "model board\n  face top\n  a: top is level\n  b: top is levl\n"
    found = checked('use "other.model"\nmodel m is board\n  c: top is upward\n', other=other)
    assert [(f.source.name, f.code) for f in found.errors] == [("other.model", "unknown-word")]
    assert [label for label, _ in found.models["m"].lines] == ["a", "b", "c"]


def test_files_that_use_one_another_are_read_once() -> None:
    other = 'use "m.model"\nmodel n\n  face f\n  a: f is level\n'
    assert (
        checked('use "other.model"\nmodel m\n  face f\n  a: f is level\n', other=other).errors == ()
    )


def test_words_of_the_user_s_own_are_known_with_their_kinds() -> None:
    words = (
        'word(lean(face), angle, "how far it leans").\nword(red(face), condition, "it is red").\n'
    )

    def read(path: Path) -> str:
        return words

    lines = ['use "w.pl"', "model m", "face f", "a: lean(f) at most 3 deg, f is red"]
    text = "\n".join([*lines, "b: lean(f) at most 3 cm"])
    found = analyse(Path("m.model"), text, read=read)
    assert [blamed(f) for f in found.errors] == ["3 cm"]
    assert found.words["lean"].gives is Gives.ANGLE


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        ('word(angle(face), angle, "x").', "cannot be redefined"),
        ('word(lean(fase), angle, "x").', "no kind"),
        ('word(lean(face), angel, "x").', "no word gives"),
        ("word(lean(face), angle).", "no word/3"),
    ],
)
def test_a_faulty_word_of_the_user_s_own_is_reported_in_its_file(
    declared: str, message: str
) -> None:
    found = analyse(
        Path("m.model"),
        'use "w.pl"\nmodel m\n  face f\n  a: f is level\n',
        read=lambda _: declared,
    )
    (error,) = found.errors
    assert error.source.name == "w.pl"
    assert message in error.message


def test_a_file_that_is_not_there_is_a_fault(tmp_path: Path) -> None:
    (found,) = analyse(tmp_path / "absent.model").errors
    assert found.code == "unreadable"
    assert "\n" not in found.message


def test_a_file_that_is_no_text_is_a_fault(tmp_path: Path) -> None:
    path = tmp_path / "m.model"
    path.write_bytes(b"model m\n\xff\xfe")
    (found,) = analyse(path).errors
    assert "UTF-8" in found.message


def test_every_fault_shows_its_line_with_carets_under_the_word() -> None:
    found = fault("a: topp is level")
    place, line, caret = found.lines()
    assert place.startswith("m.model:7:6: error: nothing here is called `topp`")
    assert line[caret.index("^") : caret.rindex("^") + 1] == "topp"
    assert Source("m", "x").line(1) == "x"


def test_the_vocabulary_s_symmetric_words_take_two_of_a_kind() -> None:
    for word in VOCABULARY.values():
        if word.symmetric and not word.many:
            assert word.arguments[0] == word.arguments[1], word.name


def test_constants_of_constants_are_worked_out_once() -> None:
    lines = ["let x0 = 2"] + [f"let x{i} = x{i - 1} + x{i - 1}" for i in range(1, 30)]
    text = "\n".join(lines) + "\nmodel m\n  face f\n  a: tilt(f) at least x29 * 1 deg\n"
    assert [f.code for f in checked(text).errors] == ["never-holds"]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (
            "any number of faces a where there is a face x of b where x adjoins a\n"
            "any number of faces b where there is a face r of a where r adjoins b",
            "cycle",
        ),
        ("face not", "taken"),
        ("face each, sum", "taken"),
        ("let x = 1e13 m", "number"),
        ("a: f adjoins f", "itself"),
        ("a: share_corner(f)", "arity"),
    ],
)
def test_what_would_go_astray_later_is_reported(text: str, code: str) -> None:
    found = checked(f"model m\n  face f\n  ok: f is level\n  {text}\n").errors
    assert {f.code for f in found} == {code}


def test_a_name_that_inherited_lines_use_otherwise_is_reported() -> None:
    other = "let lim = 5 deg\nmodel parent\n  face f\n  a: tilt(f) at most lim\n"
    text = 'use "other.model"\nlet lim = 20 deg\nmodel m like parent\n  b: tilt(f) at most lim\n'
    assert [f.code for f in checked(text, other=other).errors] == ["taken"]


def test_models_follow_from_no_more_models_than_anyone_can_follow() -> None:
    lines = [f"model m{i} is m{i + 1}" for i in range(300)]
    text = "\n".join(lines) + "\nmodel m300\n  face f\n  a: f is level\n"
    assert "too-deep" in {f.code for f in checked(text).errors}


def test_sound_lines_are_looked_at_beside_faulty_ones() -> None:
    text = "model m\n  face a\n  b: a is levl\n  c: tilt(a) at least 100 deg\n"
    assert [f.code for f in checked(text).errors] == ["unknown-word", "never-holds"]


@pytest.mark.parametrize(
    ("clause", "name"),
    [("likely(_, _, _).", "likely"), ("condition(_, _, _, _, _, _).", "condition")],
)
def test_prolog_beside_a_model_does_not_take_its_clauses_place(clause: str, name: str) -> None:
    text = 'use "w.pl"\nmodel m\n  face f\n  a: f is level\n'
    (found,) = analyse(Path("m.model"), text, read=lambda _: clause).errors
    assert (found.code, blamed(found)) == ("own-word", name)


def test_words_in_comments_of_prolog_are_no_words() -> None:
    text = 'use "w.pl"\nmodel m\n  face f\n  a: bad(f) at most 3 deg\n'
    words = '/*\nword(bad(face), angle, "x").\n*/\n'
    (found,) = analyse(Path("m.model"), text, read=lambda _: words).errors
    assert found.code == "unknown-word"


@pytest.mark.parametrize("line", ["a: this is whole", "a: not this is scanned"])
def test_of_a_word_that_left_the_language_it_is_said_what_to_write_instead(line: str) -> None:
    (found,) = checked(f"model m\n  face f\n  {line}, f is level\n").errors
    assert found.code == "unknown-word"
    assert "`solidity(this)`" in found.hint
    assert not found.fixes


LINES = """model m
  "It."
  board top where top is level
  bar left
  at least 3 bars rung where rung joins left
  ok: top is level, left is upright, each rung: rung is level
"""


def _codes(*lines: str) -> list[tuple[str, str]]:
    text = LINES + "".join(f"  {line}\n" for line in lines) + '  example "e" of table() fails\n'
    found = analyse(Path("m.model"), text).errors
    return [(f.code, f.source.text[f.span.start : f.span.end]) for f in found]


@pytest.mark.parametrize(
    ("line", "code", "blamed"),
    [
        ("size: height(this) at least 5 cm", "label", "size"),
        ("each: height(this) at least 5 cm", "label", "each"),
        ("not high: height(this) at most 5 cm", "label", "not high"),
        ("half-way: height(this) at least 5 cm", "label", "half-way"),
        ("tilt(top) at most 5 deg, if known: height(this) at least 5 cm", "if-known", "if known:"),
        ("a: tilt(top) at most 5 deg, if known: width(this) at least 1 m", "if-known", "if known:"),
        ("each rung: if known: height(rung) at least 5 cm", "if-known", "if known:"),
        ("if known: a: height(this) at least 5 cm", "if-known", "if known:"),
        ("a: if known: expect: height(this) at least 5 cm", "if-known", "if known:"),
        ("each rung is upright", "each", "each rung"),
        ("length(each rung) at least 5 cm", "each", "each rung"),
        ("each x in rung: x is upright", "each", "each x"),
        ("for each rung: rung is upright", "each", "each rung"),
        ("every rung: rung is upright", "each", "every rung"),
        ("each rung of rung: rung is upright", "each", "rung"),
    ],
)
def test_what_people_write_first_has_a_sentence_of_its_own(
    line: str, code: str, blamed: str
) -> None:
    assert _codes(line) == [(code, blamed)]


@pytest.mark.parametrize(
    "line",
    [
        "expect: if known: height(this) at least 5 cm",
        "a: expect 30 %: if known: height(this) at least 5 cm",
        "a: if known: height(this) at least 5 cm",
        "each pair x, y of rung: angle(x, y) at most 5 deg",
    ],
)
def test_what_looks_alike_and_is_sound_has_no_fault(line: str) -> None:
    assert _codes(line) == []


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("board seat whre seat is level", "misspelt"),
        ("board seat where seat is,", "syntax"),
        ("plank seat", "part"),
        ('plank seat "to sit on"', "part"),
        ("boards seat where seat is level", "part"),
        ("board seat high", "part"),
        ("a board seat", "part"),
        ("at least four bars seat where seat is level", "syntax"),
        ("4 bars seat", "syntax"),
        ("board seat where (seat is level", "bracket"),
        ('board seat where seat is level "flat', "open-text"),
    ],
)
def test_nothing_follows_from_a_part_that_cannot_be_read(line: str, code: str) -> None:
    found = _codes(
        line,
        "each seat: seat is upright" if "bars" in line else "thin: thickness(seat) at most 3 cm",
        "under: there is no piece x where x below seat",
        "enough: count(seat) at most 9" if "bars" in line else "up: seat is level",
        "typo: topp is level",
    )
    if "bars" in line:  # a set is no one part, whether its line can be read or not
        found = [one for one in found if one[0] != "set"]
    assert [code for code, _ in found] == [code, "unknown-name"]
