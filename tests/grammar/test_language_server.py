"""The language server, asked over stdio as an editor asks it."""

import random
import sys
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

import pytest

from facetlog.grammar.format import formatted
from facetlog.grammar.source import Source
from tests.grammar.editor import Editor, RequestRefused, errors

TABLE = """\
let square = 15 deg "how square"

model board
  "A level board that stands."
  face top
  at least 3 separate faces leg where leg is upright, leg supports top
  flat: tilt(top) at most square "it lies flat"
  high: each leg: height(leg) at least 30 % of length(top)
  example "x" of table(width 70 cm) holds
"""

ROOM = """\
use "board.model"

model pair
  one board first
  at least 1 boards other where other touches first
  near: each other: gap(other, first) at most 40 cm
  low: elevation(first.top) at most 1 m
"""

BUILDERS = (
    sys.executable,
    "-c",
    "from facetlog.grammar.language_server import run\n"
    "from facetlog.grammar.units import Dimension; "
    "sizes = lambda *names: dict.fromkeys(names, Dimension.LENGTH); "
    "run({'table': sizes('width', 'length', 'height'), 'cuboid': sizes('width')})",
)


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    folder = tmp_path_factory.mktemp("models")
    with Editor(folder, BUILDERS) as opened:
        yield opened


def _place(text: str, word: str, number: int = 1) -> tuple[int, int]:
    """Line and column, from 0, of a word that stands in a text for the n-th time."""
    at = -1
    for _ in range(number):
        at = text.index(word, at + 1)
    return text.count("\n", 0, at), at - text.rfind("\n", 0, at) - 1


def _edited(text: str, edits: list[dict[str, Any]]) -> str:
    """A text of one-unit letters after edits."""
    lines = text.split("\n")

    def offset(position: dict[str, int]) -> int:
        return sum(len(x) + 1 for x in lines[: position["line"]]) + position["character"]

    for edit in sorted(edits, key=lambda e: offset(e["range"]["start"]), reverse=True):
        start, end = offset(edit["range"]["start"]), offset(edit["range"]["end"])
        text = text[:start] + edit["newText"] + text[end:]
    return text


def _end(text: str) -> tuple[int, int]:
    return text.count("\n"), len(text) - text.rfind("\n") - 1


# ------------------------------------------------------------------- faults


def test_faults_are_reported_when_a_text_is_opened_and_go_when_it_is_mended(editor: Editor) -> None:
    text = "model a\n  face x\n  x is levl\n"
    (fault,) = editor.open("a.model", text)
    assert fault["range"] == {
        "start": {"line": 2, "character": 7},
        "end": {"line": 2, "character": 11},
    }
    assert "did you mean `level`?" in fault["message"]
    assert fault["severity"] == 1
    start = {"line": 2, "character": 10}
    editor.change("a.model", {"range": {"start": start, "end": start}, "text": "e"})
    assert errors(editor.faults("a.model")) == []
    editor.close("a.model")


def test_warnings_are_reported_as_such(editor: Editor) -> None:
    text = "model a\n  face x, y\n  x is level\n"
    assert editor.open("w.model", text) == []
    editor.change("w.model", {"text": text})
    (unused,) = [w for w in editor.faults("w.model", severity=2) if w["code"] == "unused-part"]
    assert unused["range"]["start"] == {"line": 1, "character": 10}
    editor.close("w.model")


def test_columns_are_counted_in_utf_16(editor: Editor) -> None:
    text = 'model a\n  face x\n  x is level "😀😀" y\n  x is upward\n'
    (fault,) = editor.open("wide.model", text)
    assert fault["range"]["start"] == {"line": 2, "character": 20}
    # U+2028 ends a line for Unicode, and none for the protocol.
    place = {"line": 2, "character": 16}
    editor.change("wide.model", {"range": {"start": place, "end": place}, "text": "\u2028😀"})
    assert editor.faults("wide.model")[0]["range"]["start"] == {"line": 2, "character": 23}
    where = {
        "start": {"line": 2, "character": 22},
        "end": {"line": 2, "character": 9999},
    }
    editor.change("wide.model", {"range": where, "text": ""})
    assert errors(editor.faults("wide.model")) == []
    editor.close("wide.model")


@pytest.mark.slow
def test_an_editor_that_counts_in_utf_8_is_understood_and_may_go_without_a_word(
    tmp_path: Path,
) -> None:
    other = Editor(tmp_path, positionEncodings=["utf-8", "utf-16"])
    assert other.capabilities["positionEncoding"] == "utf-8"
    (fault,) = other.open("a.model", 'model a\n  face x\n  x is level "😀" y\n  x is upward\n')
    assert fault["range"]["start"] == {"line": 2, "character": 20}
    other.leave()


def test_unsaved_texts_of_other_files_count(editor: Editor) -> None:
    first, *_ = editor.open("room.model", ROOM)
    assert "there is no such file" in first["message"]
    editor.open("board.model", TABLE)
    assert errors(editor.faults("room.model")) == []
    editor.change("board.model", {"text": TABLE.replace("tilt(top)", "tilt(tp)")})
    (fault,) = errors(editor.faults("room.model"))
    assert fault["range"]["start"]["line"] == 0
    assert "board.model has 1 fault" in fault["message"]
    (there,) = fault["relatedInformation"]
    assert there["location"]["uri"] == editor.uri("board.model")
    assert there["location"]["range"]["start"] == {"line": 6, "character": 13}
    editor.close("room.model")
    editor.close("board.model")


# --------------------------------------------------------------- completion


@pytest.mark.parametrize(
    ("written", "some", "none"),
    [
        ("  ", {"face", "model", "tilt", "top", "leg", "square", "let"}, {"width_", "cm", "least"}),
        ("  top ", {"is", "at", "adjoins", "between"}, {"top", "tilt", "face"}),
        ("  top is ", {"level", "upright", "not", "board"}, {"adjoins", "top", "tilt"}),
        ("  top is not ", {"level"}, {"adjoins", "top"}),
        ("  tilt(", {"top", "leg", "square"}, {"face", "is"}),
        ("  high: ", {"lowest", "smallest", "order", "tilt"}, {"deg"}),
        ("  tilt(top) at ", {"least", "most"}, {"level", "top"}),
        ("  tilt(top) at most 3 ", {"deg", "°", "cm", "%", "fading"}, {"top", "level"}),
        ("model desk ", {"is", "like"}, {"board"}),
        ("model lectern is ", {"board"}, {"lectern", "top", "level"}),
        ("  one ", {"board"}, {"top", "face"}),
        ("  at least 3 ", {"faces", "separate", "board"}, {"top", "cm"}),
        ("  each ", {"leg", "face", "pair"}, {"top", "square"}),
        ("  each x of ", {"top", "leg"}, {"square", "tilt"}),
        ("  each pair x, y of leg: x ", {"adjoins", "is"}, {"top"}),
        ("  each pair x, y of leg: ", {"x", "y", "tilt"}, {"is"}),
        ("  face ", set(), {"top", "tilt", "face"}),
        ("  let x = ", {"square"}, {"top", "tilt"}),
        ('  example "y" of ', {"table", "cuboid"}, {"top", "width"}),
        ('  example "y" of table(width 3 cm, ', {"length", "height"}, {"width", "top"}),
        ('  example "y" of table(', {"width", "length", "height"}, {"cuboid"}),
        ('  example "y" of table() and ', {"table", "cuboid"}, {"width"}),
        ('  example "y" of table(width 3 cm) and cuboid(', {"width", "z", "along"}, {"height"}),
        ('  example "y" from "y.ply" (up z, ', {"unit", "scale", "sensor"}, {"up", "width"}),
        ('  example "y" from "z" fails because ', {"flat", "high"}, {"tilt", "deg"}),
        ("  # to", set(), {"top", "tilt", "face"}),
        ('  "to', set(), {"top", "tilt", "face"}),
        ("  top is level and or ", set(), {"top"}),
    ],
)
def test_what_fits_is_completed(
    editor: Editor, written: str, some: set[str], none: set[str]
) -> None:
    text = TABLE + written
    editor.open("c.model", text)
    found = editor.completions("c.model", *_end(text))
    assert some <= found.keys()
    assert not none & found.keys()


def test_words_are_completed_with_signature_and_meaning(editor: Editor) -> None:
    text = TABLE + "  ti"
    editor.open("c.model", text)
    item = editor.completions("c.model", *_end(text))["tilt"]
    assert item["detail"] == "tilt(edge/face/piece): angle"
    assert "upright" in item["documentation"]["value"]
    assert "up is not known" in item["documentation"]["value"]


def test_parts_of_an_object_are_completed_behind_its_point(editor: Editor) -> None:
    text = TABLE + "\nmodel two\n  one board first\n  first."
    editor.open("c.model", text)
    assert set(editor.completions("c.model", *_end(text))) == {"top"}


# -------------------------------------------------------------------- hover


@pytest.mark.parametrize(
    ("word", "number", "shown"),
    [
        ("tilt", 1, ["tilt(edge/face/piece): angle", "at most 90", "up is not known"]),
        ("square", 3, ["let square = 15 deg", "is 15°", "how square"]),
        ("top", 2, ["face top"]),
        ("leg", 2, ["at least 3 separate faces leg where"]),
        ("board", 1, ["model board", "A level board that stands."]),
        ("table", 1, ["table(width, length, height)"]),
        ("cm", 1, ["a length: 0.01 m"]),
        ("high", 1, ["high: each leg"]),
    ],
)
def test_hovering_tells_what_a_word_is(
    editor: Editor, word: str, number: int, shown: list[str]
) -> None:
    editor.open("h.model", TABLE)
    found = editor.at("hover", "h.model", *_place(TABLE, word, number))
    assert all(piece in found["contents"]["value"] for piece in shown)


def test_hovering_tells_from_where_to_where_a_limit_fades(editor: Editor) -> None:
    text = TABLE + "  tilt(top) at most 40 deg\n"
    editor.open("h.model", text)
    for word, number in (("tilt", text.count("tilt(")), ("40", text.count("40"))):
        found = editor.at("hover", "h.model", *_place(text, word, number))
        assert (
            "`tilt(top) at most 40 deg` fades from 36 deg to 44 deg" in found["contents"]["value"]
        )


def test_hovering_tells_what_a_word_is_where_a_statement_cannot_be_read(editor: Editor) -> None:
    text = TABLE + "  tilt(top at\n"
    editor.open("h.model", text)
    found = editor.at("hover", "h.model", *_place(text, "tilt", 2))
    assert "tilt(edge/face/piece): angle" in found["contents"]["value"]
    assert editor.at("hover", "h.model", *_place(text, "at\n")) is None


# -------------------------------------------------------------------- names


def test_definitions_are_found_in_this_and_in_other_files(editor: Editor) -> None:
    editor.open("board.model", TABLE)
    editor.open("room.model", ROOM)

    def home(text: str, name: str, word: str, number: int) -> tuple[str, int, int]:
        found = editor.at("definition", name, *_place(text, word, number))
        start = found["range"]["start"]
        return found["uri"].rpartition("/")[2], start["line"], start["character"]

    assert home(TABLE, "board.model", "square", 3) == ("board.model", 0, 4)
    assert home(TABLE, "board.model", "top", 2) == ("board.model", *_place(TABLE, "top"))
    assert home(ROOM, "room.model", "board first", 1) == ("board.model", *_place(TABLE, "board"))
    assert home(ROOM, "room.model", "boards", 1) == ("board.model", *_place(TABLE, "board"))
    assert home(ROOM, "room.model", "top)", 1) == ("board.model", *_place(TABLE, "top"))
    assert home(ROOM, "room.model", "board.model", 1) == ("board.model", 0, 0)
    assert editor.at("definition", "board.model", *_place(TABLE, "tilt")) is None
    editor.close("board.model")
    editor.close("room.model")


def test_definitions_of_own_words_are_found_in_prolog(editor: Editor) -> None:
    (editor.folder / "own.pl").write_text('word(lean(face), angle, "how far it leans").\n')
    text = 'use "own.pl"\nmodel a\n  face x\n  lean(x) at most 3 deg\n'
    assert errors(editor.open("own.model", text)) == []
    found = editor.at("definition", "own.model", *_place(text, "lean"))
    assert found["uri"] == editor.uri("own.pl")
    assert found["range"]["start"] == {"line": 0, "character": 5}
    editor.close("own.model")


def test_references_are_found_with_or_without_the_declaration(editor: Editor) -> None:
    editor.open("board.model", TABLE)
    (editor.folder / "room.model").write_text(ROOM)
    place = _place(TABLE, "top")
    found = editor.at("references", "board.model", *place, context={"includeDeclaration": True})
    here = [x["range"]["start"]["line"] for x in found if x["uri"] == editor.uri("board.model")]
    there = [x["range"]["start"]["line"] for x in found if x["uri"] == editor.uri("room.model")]
    assert (here, there) == ([4, 5, 6, 7], [6])
    found = editor.at("references", "board.model", *place, context={"includeDeclaration": False})
    assert len(found) == 4
    editor.close("board.model")


def test_renaming_reaches_all_files_and_keeps_them_sound(editor: Editor) -> None:
    editor.open("board.model", TABLE)
    (editor.folder / "room.model").write_text(ROOM)
    renamed = {"board": ("board", "bench"), "top": ("top", "seat"), "square": ("square", "right")}
    for word, new in renamed.values():
        place = _place(TABLE, word)
        changes = editor.at("rename", "board.model", *place, newName=new)["changes"]
        table = _edited(TABLE, changes[editor.uri("board.model")])
        room = _edited(ROOM, changes.get(editor.uri("room.model"), []))
        assert word not in table.replace("A level board", "").replace("how square", "").split()
        editor.change("board.model", {"text": table})
        editor.faults("board.model")
        assert errors(editor.open("room.model", room)) == []
        editor.close("room.model")
        editor.change("board.model", {"text": TABLE})
        editor.faults("board.model")
    assert "at least 1 benches other" in _edited(
        ROOM,
        editor.at("rename", "board.model", *_place(TABLE, "board"), newName="bench")["changes"][
            editor.uri("room.model")
        ],
    )
    editor.close("board.model")
    (editor.folder / "room.model").unlink()


@pytest.mark.parametrize(
    ("word", "new", "why"),
    [
        ("top", "leg", "is a part already"),
        ("top", "face", "is a word of the language"),
        ("top", "level", "is a word of the vocabulary"),
        ("top", "a b", "is no name"),
        ("top", "3", "is no name"),
        ("top", "square", "already"),
        ("leg", "lowest", "is a word of the language"),
        ("flat", "high", "there are two lines"),
        ("tilt", "lean", "is a word of the vocabulary and keeps its name"),
        ("table", "desk", "is built by facetlog"),
        ("holds", "x", "there is no name here"),
    ],
)
def test_renaming_refuses_what_would_change_the_meaning(
    editor: Editor, word: str, new: str, why: str
) -> None:
    editor.open("r.model", TABLE)
    with pytest.raises(RequestRefused, match=why):
        editor.at("rename", "r.model", *_place(TABLE, word), newName=new)


def test_models_that_inherit_take_part_in_renaming(editor: Editor) -> None:
    text = (
        TABLE
        + "\nmodel desk like board\n  drop high\n  let square = 5 deg\n  tilt(top) at most square\n"
        '  example "y" from "z" fails because flat\n'
    )
    editor.open("i.model", text)
    for word, new, count in (("square", "right", 4), ("top", "plate", 5), ("flat", "even", 2)):
        changes = editor.at("rename", "i.model", *_place(text, word), newName=new)["changes"]
        assert len(changes[editor.uri("i.model")]) == count


def test_what_has_a_name_may_be_renamed_and_nothing_else(editor: Editor) -> None:
    editor.open("r.model", TABLE)
    found = editor.at("prepareRename", "r.model", *_place(TABLE, "top", 2))
    assert found["end"]["character"] - found["start"]["character"] == 3
    with pytest.raises(RequestRefused, match="vocabulary"):
        editor.at("prepareRename", "r.model", *_place(TABLE, "tilt"))


# --------------------------------------------------------- text and outline


def test_formatting_gives_the_canonical_text(editor: Editor) -> None:
    text = "model   a\nface x\nx   is level"
    editor.open("f.model", text)
    params = {
        "textDocument": {"uri": editor.uri("f.model")},
        "options": {"tabSize": 2, "insertSpaces": True},
    }
    edits = editor.ask("textDocument/formatting", params)
    after = _edited(text, edits)
    assert after == formatted(Source("f", text)) == "model a\n  face x\n  x is level\n"
    editor.change("f.model", {"text": after})
    assert editor.ask("textDocument/formatting", params) == []


def test_the_outline_shows_models_with_what_they_name(editor: Editor) -> None:
    editor.open("o.model", TABLE)
    found = editor.ask(
        "textDocument/documentSymbol", {"textDocument": {"uri": editor.uri("o.model")}}
    )
    assert [x["name"] for x in found] == ["square", "board"]
    assert [x["name"] for x in found[1]["children"]] == ["top", "leg", "flat", "high", "x"]
    for symbol in [*found, *found[1]["children"]]:
        whole, name = symbol["range"], symbol["selectionRange"]
        for end, sign in (("start", 1), ("end", -1)):
            outer = whole[end]["line"], whole[end]["character"]
            inner = name[end]["line"], name[end]["character"]
            assert sign * (outer > inner) - sign * (outer < inner) <= 0 or outer == inner


# ------------------------------------------------------------------- hardship


def test_the_server_survives_whatever_is_typed(editor: Editor) -> None:
    chance = random.Random(4)
    pieces = ["\n", '"', "(", ")", "é😀", "\r", "\x00", "\ud800", "\u2028", "model ", "each ", ":",
              " of ", "1e999", "± ", ".", "use \"z.model\"\n", "# ", "a" * 300]  # fmt: skip
    text = TABLE
    editor.open("z.model", text)
    methods = ("hover", "completion", "definition", "prepareRename")
    for _ in range(120):
        line = chance.randrange(0, 14)
        start = {"line": line, "character": chance.randrange(0, 60)}
        end = {"line": line + chance.randrange(0, 2), "character": chance.randrange(0, 60)}
        change = {"range": {"start": start, "end": end}, "text": chance.choice(pieces)}
        editor.change("z.model", change)
        method = chance.choice(methods)
        refusable = suppress(RequestRefused) if method == "prepareRename" else nullcontext()
        with refusable:
            editor.at(method, "z.model", start["line"], start["character"])
    for method in ("documentSymbol", "formatting"):
        document = {
            "textDocument": {"uri": editor.uri("z.model")},
            "options": {"tabSize": 2, "insertSpaces": True},
        }
        editor.ask(f"textDocument/{method}", document)
    editor.change("z.model", {"text": TABLE})
    assert errors(editor.faults("z.model")) == []


def test_questions_about_files_that_nobody_opened_are_answered(editor: Editor) -> None:
    assert editor.at("hover", "nowhere.model", 3, 5) is None
    assert editor.completions("nowhere.model", 0, 0)


def test_a_text_without_a_file_is_served(editor: Editor) -> None:
    item = {"uri": "untitled:Untitled-1", "languageId": "facetlog-model", "version": 1}
    editor.tell("textDocument/didOpen", {"textDocument": {**item, "text": "model a\n  face x\n"}})
    place = {"textDocument": {"uri": item["uri"]}, "position": {"line": 1, "character": 2}}
    assert editor.ask("textDocument/completion", place)["items"]
    editor.tell("textDocument/didClose", {"textDocument": {"uri": item["uri"]}})
