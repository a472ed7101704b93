"""The extension for VS Code: its colours know the language's words, its files belong together."""

import json
import os
import re
import runpy
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest
from lark import Lark
from lark.lexer import PatternStr

from facetlog.grammar.reading.parse import GRAMMAR
from facetlog.grammar.units import UNITS

FOLDER = Path(__file__).parents[2] / "editors" / "vscode"

EXAMPLE = """\
use "board.model"
let square = 15 deg  # how square
model desk is table
  face a, b
  optional one box parcel
  at least 3 separate faces leg where leg is upright and not leg touches top
  flat: each pair x, y of a, b: angle(x, y) = 90° ± square  "why"
  if known: elevation(top) at most 1.5 m fading 10 % of length(this)
  expect weakly: there is no face z where z is level or lowest of tilt(leg) about 3
  size height: length(a) longest first
  example "x" of table(width 70 cm) fails because flat
"""


def _json(name: str) -> Any:
    return json.loads((FOLDER / name).read_text(encoding="utf-8"))


@cache
def _colours() -> dict[str, Any]:
    found: dict[str, Any] = _json("syntaxes/facetlog-model.tmLanguage.json")
    return found


def _pattern(text: str) -> re.Pattern[str]:
    """An expression of Oniguruma in Python's words."""
    return re.compile(text.replace(r"[\p{L}\p{N}_]", r"\w").replace(r"[\p{L}_]", r"[^\W\d]"))


@cache
def _rules() -> tuple[tuple[re.Pattern[str], dict[int, str]], ...]:
    """The expressions in their order, and the colour of each group; 0 is all of a match."""
    rules = []
    for entry in _colours()["patterns"]:
        rule = _colours()["repository"][entry["include"].removeprefix("#")]
        for one in rule.get("patterns", [rule]):
            groups = {int(n): c["name"] for n, c in one.get("captures", {}).items()}
            if "name" in one:
                groups[0] = one["name"]
            rules.append((_pattern(one["match"]), groups))
    return tuple(rules)


def _coloured(line: str) -> dict[str, str]:
    """The pieces of a line with their colours: the first match, of several the first rule's."""
    found: dict[str, str] = {}
    at = 0
    while at < len(line):
        matches = [(m, groups) for p, groups in _rules() if (m := p.search(line, at))]
        if not matches:
            break
        match, groups = min(matches, key=lambda one: one[0].start())
        for group, colour in groups.items():
            if match[group]:
                found[match[group]] = colour.removesuffix(".facetlog-model")
        at = max(match.end(), at + 1)
    return found


def _words(match: str) -> set[str]:
    """The words that stand in an expression."""
    bare = re.sub(r"\(\?[:!=<]+|\\[a-zA-Z](\{\w+\})?|\[[^\]]*\]", " ", match)
    return set(re.findall(r"[a-z]+\d?", bare))


def test_the_words_of_the_grammar_are_coloured_and_no_others() -> None:
    terminals = Lark(GRAMMAR.read_text(encoding="utf-8"), parser="lalr").terminals
    patterns = [t.pattern.value for t in terminals if isinstance(t.pattern, PatternStr)]
    language = {word for word in patterns if word.isalpha()} | {"longest", "first"}
    repository = _colours()["repository"]
    groups = ("statement", "phrase", "connective", "comparison", "kind")
    coloured = set().union(*(_words(repository[name]["match"]) for name in groups))
    assert coloured == language


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("  board top where top is level", {"board"}),
        ("  bar a, b", {"bar"}),
        ("  at least 3 bars leg where leg carries top", {"bars"}),
        ("  a: each block x: x joins top", {"block"}),
        ("  board: board is level", set()),
        ("  board adjoins bar", set()),
    ],
)
def test_words_for_pieces_are_coloured_where_names_follow(line: str, words: set[str]) -> None:
    kinds = {text for text, colour in _coloured(line).items() if colour == "storage.type"}
    assert kinds == words


def test_the_units_are_coloured() -> None:
    match = _colours()["repository"]["quantity"]["match"]
    assert _words(match) - {"e"} == UNITS.keys() - {"%", "°"}
    for unit in UNITS:
        assert _coloured(f"  x at most 3 {unit}")[unit] == "keyword.other.unit"


def test_an_example_is_coloured_as_it_is_meant() -> None:
    lines = [_coloured(line) for line in EXAMPLE.splitlines()]
    assert lines[0]['"board.model"'] == "string.quoted.double"
    assert lines[1]["square"] == "variable.other.constant"
    assert lines[1]["# how square"] == "comment.line.number-sign"
    assert lines[2]["desk"] == "entity.name.type"
    assert lines[2]["table"] == "entity.other.inherited-class"
    assert lines[3] == {"face": "storage.type"}
    assert lines[4]["box"] == "entity.name.type"
    assert lines[5]["at least"] == "keyword.operator.comparison"
    assert lines[5]["not"] == "keyword.operator.logical"
    assert "top" not in lines[5]
    assert lines[6]["flat"] == "entity.name.label"
    assert lines[6]["each pair"] == "keyword.control"
    assert lines[6]["angle"] == "support.function"
    assert lines[6]["°"] == "keyword.other.unit"
    assert lines[7]["if known"] == "keyword.control"
    assert lines[7]["this"] == "variable.language"
    assert lines[8]["expect"] == "keyword.declaration"
    assert lines[8]["there is no"] == "keyword.control"
    assert lines[9]["longest first"] == "keyword.control"
    assert lines[10]["fails"] == "keyword.control"


def test_a_name_that_is_a_words_beginning_is_not_coloured() -> None:
    assert _coloured("  faces_up adjoins isle, cmx is_") == {}


def test_the_files_of_the_extension_belong_together() -> None:
    package = _json("package.json")
    contributes = package["contributes"]
    (language,), (grammar,) = contributes["languages"], contributes["grammars"]
    for name in (package["main"], language["configuration"], grammar["path"]):
        assert (FOLDER / name).is_file()
    assert grammar["language"] == language["id"] == "facetlog-model"
    assert grammar["scopeName"] == _colours()["scopeName"]
    scripts = {path.stem: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.js")}
    script = scripts[package["main"].removeprefix("./").removesuffix(".js")]
    required = set(re.findall(r'require\("([^"]+)', "\n".join(scripts.values())))
    # What is no part of VS Code or of Node would have to be packed as well.
    others = {name.removeprefix("./") for name in required - {"vscode", "child_process"}}
    assert others == scripts.keys() - {"extension"}
    assert "dependencies" not in package
    for command in contributes["commands"]:
        assert f'registerCommand("{command["command"]}"' in script
    default = contributes["configuration"]["properties"]["facetlog.command"]["default"]
    assert default == ["facetlog", "model", "lsp"]


def test_words_are_what_the_language_takes_for_names() -> None:
    pattern = _json("language-configuration.json")["wordPattern"]
    assert pattern["flags"] == "u"
    words = _pattern(pattern["pattern"])
    assert words.findall("größe x_1 3cm") == ["größe", "x_1", "cm"]


def test_the_extension_is_packed_without_node(tmp_path: Path) -> None:
    main = runpy.run_path(str(FOLDER.parents[1] / "scripts" / "build_vsix.py"))["main"]
    first, second = tmp_path / "a.vsix", tmp_path / "b.vsix"
    assert main(["-o", str(first)]) == main(["-o", str(second)]) == 0
    assert first.read_bytes() == second.read_bytes()
    with ZipFile(first) as archive:
        names = set(archive.namelist())
        manifest = ElementTree.fromstring(archive.read("extension.vsixmanifest"))  # noqa: S314
        packed = json.loads(archive.read("extension/package.json"))
    assets = {one.attrib["Path"] for one in manifest.iter() if "Path" in one.attrib}
    assert assets <= names
    wanted = [packed["main"], packed["contributes"]["grammars"][0]["path"]]
    assert {f"extension/{name.removeprefix('./')}" for name in wanted} <= names
    identity = next(one for one in manifest.iter() if one.tag.endswith("Identity"))
    assert identity.attrib["Version"] == packed["version"]


STAND_IN = Path(__file__).with_name("vscode_stand_in.js")


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
def test_the_extension_speaks_with_the_server(tmp_path: Path) -> None:
    server = [sys.executable, "-m", "facetlog.grammar.language_server"]
    run = subprocess.run(
        ["node", str(STAND_IN), str(FOLDER), json.dumps(server)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(FOLDER.parents[1] / "src")},
    )
    assert run.stderr == ""
    found = json.loads(run.stdout)
    assert found["faults"] == ["unknown-word"]
    assert found["actions"][0] == "write `level`"
    assert "level" in found["completions"]
    assert found["hover"]
    assert found["symbols"] == ["board"]
    assert found["errors"] == []
