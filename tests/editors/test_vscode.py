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

from facetlog.grammar.language_server.completion import UNLESS_LABEL
from facetlog.grammar.reading.parse import GRAMMAR
from facetlog.grammar.units import UNITS

FOLDER = Path(__file__).parents[2] / "editors" / "vscode"


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


def test_the_words_of_the_grammar_are_coloured_and_no_others():
    terminals = Lark(GRAMMAR.read_text(encoding="utf-8"), parser="lalr").terminals
    patterns = [t.pattern.value.removesuffix(UNLESS_LABEL) for t in terminals]
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
def test_words_for_pieces_are_coloured_where_names_follow(line, words):
    kinds = {text for text, colour in _coloured(line).items() if colour == "storage.type"}
    assert kinds == words


def test_the_units_are_coloured():
    match = _colours()["repository"]["quantity"]["match"]
    assert _words(match) - {"e"} == UNITS.keys() - {"%", "°"}
    for unit in UNITS:
        assert _coloured(f"  x at most 3 {unit}")[unit] == "keyword.other.unit"


def test_the_files_of_the_extension_belong_together():
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


def test_the_extension_is_packed_without_node(tmp_path):
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
def test_the_extension_speaks_with_the_server(tmp_path):
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
