"""`facetlog model check`: faults of files, folders and standard input, in three outputs."""

import io
import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from facetlog.cli import main

GOOD = """model slab
  "A level board."
  face top
  level: top is level, top is upward  "it lies level"
  example "board" of cuboid(width 40 cm, depth 30 cm, height 2 cm) holds
"""
FAULTY = GOOD.replace("top is level,", "top is levle,")
THREE_FAULTS = GOOD.replace("upward", "upwrad").replace("2 cm", "2 deg").replace("40 cm", "40 cmm")


def _tree(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text)  # noqa: S314  what this program has just written


def _write(folder: Path, **texts: str) -> None:
    for name, text in texts.items():
        path = folder / f"{name}.model"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_file_without_faults_passes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _write(tmp_path, slab=GOOD)
    assert main(["model", "check", "slab.model"]) == 0
    assert capsys.readouterr() == ("1 file, no faults\n", "")


def test_all_faults_of_all_files_are_told_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path, a=THREE_FAULTS, b=FAULTY.replace("model slab", "model board"))
    assert main(["model", "check", "a.model", "b.model"]) == 1
    lines = capsys.readouterr().out.splitlines()
    heads = [line for line in lines if ": error: " in line]
    assert [head.split(": ")[0] for head in heads] == [
        "a.model:4:31",
        "a.model:5:38",
        "a.model:5:63",
        "b.model:4:17",
    ]
    assert "did you mean `upward`" in heads[0]
    assert lines[lines.index(heads[0]) + 1] == "  " + THREE_FAULTS.splitlines()[3]
    assert lines[lines.index(heads[0]) + 2] == "  " + " " * 30 + "^" * 6
    assert lines[-1] == "2 files, 4 errors"


def test_what_an_example_builds_is_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path, a=GOOD.replace("cuboid(", "cubiod("), b=GOOD.replace("depth", "deep"))
    assert main(["model", "check", "a.model", "b.model"]) == 1
    out = capsys.readouterr().out
    assert "a.model:5:22: error: nothing can be built that is called `cubiod`" in out
    assert "did you mean `cuboid`" in out
    assert "a cuboid has no size `deep`; did you mean `depth`?" in out


def test_folders_and_patterns_name_files_once_and_skip_hidden_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path / "m", a=GOOD, b=GOOD)
    _write(tmp_path / "m" / "deep", c=GOOD)
    _write(tmp_path / "m" / ".old", d="nonsense here")
    assert main(["model", "check", "m", "m/*.model", "m/a.model", "--output", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["files"] == ["m/a.model", "m/b.model", "m/deep/c.model"]


def test_standard_input_is_read(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(FAULTY.encode())))
    assert main(["model", "check", "-"]) == 1
    assert capsys.readouterr().out.startswith("<stdin>:4:")


def test_standard_input_that_is_no_text_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"model a\n\xff")))
    assert main(["model", "check", "-"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "line 2 is no UTF-8 text" in err


def test_a_model_of_two_files_is_told_of_both(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path / "a", slab=GOOD)
    _write(tmp_path / "b", slab=GOOD, board=GOOD.replace("model slab", "model board"))
    assert main(["model", "check", "."]) == 0
    assert capsys.readouterr().out.count("[same-name]") == 2
    assert main(["model", "check", "b"]) == 0
    assert "same-name" not in capsys.readouterr().out


@pytest.mark.parametrize("argument", ["empty", "*.model", "rules.pl", "a" * 5000])
def test_what_names_no_model_file_is_refused(
    argument: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    assert main(["model", "check", argument]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("facetlog: ")
    assert err.count("\n") == 1


def test_a_file_that_is_not_there_does_not_hide_the_faults_of_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path, a=FAULTY)
    assert main(["model", "check", "absent.model", "a.model"]) == 2
    out = capsys.readouterr().out
    assert "absent.model:1:1: error: the file cannot be read" in out
    assert "a.model:4:" in out


def test_a_fault_of_a_file_that_several_use_is_told_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = 'use "c.model"\n'
    _write(tmp_path, a=first + GOOD, b=first + GOOD.replace("slab", "slob"))
    _write(tmp_path, c=FAULTY.replace("slab", "other"))
    assert main(["model", "check", "a.model", "b.model", "--output", "json"]) == 1
    faults = json.loads(capsys.readouterr().out)["faults"]
    assert {fault["file"] for fault in faults} == {"c.model"}
    assert len(faults) == 1


def test_json_gives_places_and_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _write(tmp_path, a=FAULTY)
    assert main(["model", "check", "a.model", "--output", "json"]) == 1
    found = json.loads(capsys.readouterr().out)
    (fault,) = found["faults"]
    assert (found["schema"], found["errors"], found["warnings"]) == ("facetlog-model-check/1", 1, 0)
    line = FAULTY.splitlines()[fault["line"] - 1]
    assert fault["severity"] == "error"
    assert fault["file"] == "a.model"
    assert 1 <= fault["column"] < fault["end_column"] <= len(line) + 1


def test_sarif_has_what_the_standard_requires(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path / "a b", a=THREE_FAULTS)
    assert main(["model", "check", "a b/a.model", "--output", "sarif"]) == 1
    log = json.loads(capsys.readouterr().out)
    assert log["version"] == "2.1.0"
    assert log["$schema"].endswith("sarif-2.1.0.json")
    (run,) = log["runs"]
    driver = run["tool"]["driver"]
    assert driver["name"] == "facetlog"
    assert run["columnKind"] == "utf16CodeUnits"
    assert run["artifacts"] == [{"location": {"uri": "a%20b/a.model"}}]
    assert len(run["results"]) == 3
    for result in run["results"]:
        rule = driver["rules"][result["ruleIndex"]]
        assert rule["id"] == result["ruleId"]
        assert rule["shortDescription"]["text"].endswith(".")
        assert result["level"] in {"error", "warning", "note", "none"}
        assert result["message"]["text"]
        (location,) = result["locations"]
        place = location["physicalLocation"]
        assert place["artifactLocation"]["uri"] == "a%20b/a.model"
        region = place["region"]
        assert all(isinstance(n, int) and n >= 1 for n in region.values())
        start = region["startLine"], region["startColumn"]
        assert start < (region["endLine"], region["endColumn"])


def test_sarif_counts_columns_in_utf_16(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _write(tmp_path, a=GOOD.replace("example", 'example "\U0001f4d0" of cuboid() hodls\n  example'))
    assert main(["model", "check", "a.model", "--output", "sarif"]) == 1
    (result,) = json.loads(capsys.readouterr().out)["runs"][0]["results"]
    region = result["locations"][0]["physicalLocation"]["region"]
    before = '  example "\U0001f4d0" of cuboid() '
    assert region["startColumn"] == len(before.encode("utf-16-le")) // 2 + 1
    assert region["endColumn"] == region["startColumn"] + len("hodls")


def test_fix_writes_what_is_sure_and_tells_the_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path, a=THREE_FAULTS, good=GOOD.replace("model slab", "model board"))
    before = (tmp_path / "good.model").stat()
    assert main(["model", "check", "--fix", "a.model", "good.model"]) == 1
    out, err = capsys.readouterr()
    mended = (tmp_path / "a.model").read_text(encoding="utf-8")
    assert "top is upward" in mended
    assert "40 cmm," in mended  # cm or mm?
    assert "facetlog: a.model:4:31: write `upward` [unknown-word]" in err
    assert "facetlog: a.model: 1 fault put right" in err
    assert out.splitlines()[-1] == "2 files, 2 errors"
    after = (tmp_path / "good.model").stat()
    assert (before.st_mtime_ns, before.st_ino) == (after.st_mtime_ns, after.st_ino)
    assert main(["model", "check", "--fix", "a.model"]) == 1
    assert capsys.readouterr().err == ""


def test_fix_keeps_line_ends_and_modes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.model"
    path.write_bytes(FAULTY.replace("\n", "\r\n").encode())
    path.chmod(0o640)
    assert main(["model", "check", "--fix", "a.model"]) == 0
    assert path.read_bytes() == GOOD.replace("\n", "\r\n").encode()
    assert path.stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("arguments", [["-"], ["a.model", "--watch"]])
def test_fix_needs_files_that_nobody_is_editing(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(tmp_path, a=FAULTY)
    assert main(["model", "check", "--fix", *arguments]) == 2
    assert (tmp_path / "a.model").read_text(encoding="utf-8") == FAULTY


def test_sarif_and_json_hold_the_fixes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _write(tmp_path, a=FAULTY)
    assert main(["model", "check", "a.model", "--output", "sarif"]) == 1
    (result,) = json.loads(capsys.readouterr().out)["runs"][0]["results"]
    (fix,) = result["fixes"]
    (change,) = fix["artifactChanges"]
    assert fix["description"]["text"] == "write `level`"
    assert change["artifactLocation"] == {"uri": "a.model"}
    region = {"startLine": 4, "startColumn": 17, "endLine": 4, "endColumn": 22}
    assert change["replacements"] == [
        {"deletedRegion": region, "insertedContent": {"text": "level"}}
    ]
    assert main(["model", "check", "a.model", "--output", "json"]) == 1
    (fault,) = json.loads(capsys.readouterr().out)["faults"]
    assert [(f["title"], f["sure"]) for f in fault["fixes"]] == [("write `level`", True)]


def test_junit_has_a_suite_for_each_file_and_a_case_for_each_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    board = GOOD.replace("model slab", "model board")
    doubtful = board.replace("  example", "  let square = 15 deg\n  example")
    second = GOOD.replace("slab", "plank")
    _write(
        tmp_path,
        bad=f"let spare = 1\n{FAULTY}\n{second}",
        doubtful=doubtful,
        good=board.replace("board", "tray"),
    )
    arguments = ["model", "check", "bad.model", "doubtful.model", "good.model", "--output", "junit"]
    assert main(arguments) == 1
    root = _tree(capsys.readouterr().out)
    assert (root.tag, root.get("tests"), root.get("failures")) == ("testsuites", "7", "1")
    bad, warned, good = root
    cases = [[(case.get("name"), [one.tag for one in case]) for case in suite] for suite in root]
    assert cases[0] == [("bad.model", []), ("slab", ["failure"]), ("plank", [])]
    assert cases[1] == [("doubtful.model", []), ("board", ["system-out"])]
    assert cases[2] == [("good.model", []), ("tray", [])]
    assert [suite.get("failures") for suite in (bad, warned, good)] == ["1", "0", "0"]
    (failure,) = bad.iter("failure")
    assert failure.get("type") == "unknown-word"
    assert "bad.model:5:17: error:" in (failure.text or "")
    assert main([*arguments, "--warnings-as-errors"]) == 1
    assert _tree(capsys.readouterr().out).get("failures") == "2"
