"""`facetlog model check`: faults of files, folders and standard input, in four outputs."""

import io
import json
from pathlib import Path
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree

import pytest

GOOD = """model slab
  "A level board."
  face top
  level: top is level, top is upward  "it lies level"
  example "board" of cuboid(width 40 cm, depth 30 cm, height 2 cm) holds
"""
FAULTY = GOOD.replace("top is level,", "top is levle,")
THREE_FAULTS = GOOD.replace("upward", "upwrad").replace("2 cm", "2 deg").replace("40 cm", "40 cmm")


@pytest.fixture
def write(tmp_path):
    """Return a function that writes model files by their names."""

    def write_models(folder=".", **texts):
        (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (tmp_path / folder / f"{name}.model").write_text(text, encoding="utf-8")

    return write_models


def test_all_faults_of_all_files_are_reported_at_once(run, write):
    write(a=THREE_FAULTS, b=FAULTY.replace("model slab", "model board"), good=GOOD)
    assert run("model", "check", "good.model") == (0, "1 file, no faults\n", "")
    code, out, _ = run("model", "check", "a.model", "b.model")
    lines = out.splitlines()
    heads = [line for line in lines if ": error: " in line]
    places = ["a.model:4:31", "a.model:5:38", "a.model:5:63", "b.model:4:17"]
    assert (code, [head.split(": ")[0] for head in heads]) == (1, places)
    assert "did you mean `upward`" in heads[0]
    assert lines[lines.index(heads[0]) + 1] == "  " + THREE_FAULTS.splitlines()[3]
    assert lines[lines.index(heads[0]) + 2] == "  " + " " * 30 + "^" * 6
    assert lines[-1] == "2 files, 4 errors"


def test_folders_and_patterns_name_files_once_and_skip_hidden_ones(run, write):
    write("m", a=GOOD, b=GOOD)
    write("m/deep", c=GOOD)
    write("m/.old", d="nonsense here")
    code, out, _ = run("model", "check", "m", "m/*.model", "m/a.model", "--output", "json")
    assert code == 0
    assert json.loads(out)["files"] == ["m/a.model", "m/b.model", "m/deep/c.model"]


@pytest.mark.parametrize(
    ("data", "code", "message"),
    [(FAULTY.encode(), 1, "<stdin>:4:"), (b"model a\n\xff", 2, "line 2 is no UTF-8 text")],
)
def test_standard_input_is_checked(data, code, message, run, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(data)))
    found, out, err = run("model", "check", "-")
    assert found == code
    assert message in out + err


def test_a_model_of_two_files_is_reported_in_both(run, write):
    write("a", slab=GOOD)
    write("b", slab=GOOD, board=GOOD.replace("model slab", "model board"))
    assert run("model", "check", ".")[1].count("[same-name]") == 2
    assert "same-name" not in run("model", "check", "b")[1]


@pytest.mark.parametrize("argument", ["empty", "*.model", "rules.pl", "a" * 5000])
def test_what_names_no_model_file_is_refused(argument, refused, tmp_path):
    (tmp_path / "empty").mkdir()
    refused("model", "check", argument)


def test_a_missing_file_does_not_hide_the_faults_of_others(run, write):
    write(a=FAULTY)
    code, out, _ = run("model", "check", "absent.model", "a.model")
    assert code == 2
    assert "absent.model:1:1: error: the file cannot be read" in out
    assert "a.model:4:" in out


def test_a_fault_of_a_file_that_several_use_is_reported_once(run, write):
    first = 'use "c.model"\n'
    write(a=first + GOOD, b=first + GOOD.replace("slab", "slob"))
    write(c=FAULTY.replace("slab", "other"))
    _, out, _ = run("model", "check", "a.model", "b.model", "--output", "json")
    found = json.loads(out)
    assert (found["schema"], found["errors"], found["warnings"]) == ("facetlog-model-check/1", 1, 0)
    (fault,) = found["faults"]
    assert (fault["file"], fault["severity"], fault["line"]) == ("c.model", "error", 4)
    assert [(fix["title"], fix["sure"]) for fix in fault["fixes"]] == [("write `level`", True)]


def test_each_code_leads_to_its_heading(run, write):
    """As text, JSON and SARIF: a page that is installed, and a heading in it."""
    write(a=THREE_FAULTS)
    text = run("model", "check", "a.model")[1]
    found = json.loads(run("model", "check", "a.model", "--output", "json")[1])["faults"]
    sarif = json.loads(run("model", "check", "a.model", "--output", "sarif")[1])
    rules = sarif["runs"][0]["tool"]["driver"]["rules"]
    addresses = {fault["help"] for fault in found}
    assert addresses == {rule["helpUri"] for rule in rules}
    assert addresses == {line[4:] for line in text.splitlines() if line.startswith("see ")}
    for fault in found:
        page, heading = fault["help"].split("#")
        assert heading == fault["code"]
        assert f"\n## {heading}\n" in Path(unquote(urlparse(page).path)).read_text("utf-8")


def test_sarif_has_what_the_standard_requires(run, write):
    write("a b", a=THREE_FAULTS)
    code, out, _ = run("model", "check", "a b/a.model", "--output", "sarif")
    log = json.loads(out)
    assert (code, log["version"]) == (1, "2.1.0")
    assert log["$schema"].endswith("sarif-2.1.0.json")
    (sarif_run,) = log["runs"]
    driver = sarif_run["tool"]["driver"]
    assert driver["name"] == "facetlog"
    assert sarif_run["columnKind"] == "utf16CodeUnits"
    assert sarif_run["artifacts"] == [{"location": {"uri": "a%20b/a.model"}}]
    assert len(sarif_run["results"]) == 3
    for result in sarif_run["results"]:
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


def test_sarif_holds_fixes_and_counts_columns_in_utf_16(run, write):
    write(a=FAULTY.replace("example", 'example "\U0001f4d0" of cuboid() hodls\n  example'))
    _, out, _ = run("model", "check", "a.model", "--output", "sarif")
    fixable, wide = json.loads(out)["runs"][0]["results"]
    (change,) = fixable["fixes"][0]["artifactChanges"]
    assert change["artifactLocation"] == {"uri": "a.model"}
    region = {"startLine": 4, "startColumn": 17, "endLine": 4, "endColumn": 22}
    assert change["replacements"] == [
        {"deletedRegion": region, "insertedContent": {"text": "level"}}
    ]
    region = wide["locations"][0]["physicalLocation"]["region"]
    before = '  example "\U0001f4d0" of cuboid() '
    assert region["startColumn"] == len(before.encode("utf-16-le")) // 2 + 1
    assert region["endColumn"] == region["startColumn"] + len("hodls")


def test_fix_writes_what_is_sure_and_reports_the_rest(run, write, tmp_path):
    write(a=THREE_FAULTS, good=GOOD.replace("model slab", "model board"))
    before = (tmp_path / "good.model").stat()
    code, out, err = run("model", "check", "--fix", "a.model", "good.model")
    mended = (tmp_path / "a.model").read_text(encoding="utf-8")
    assert "top is upward" in mended
    assert "40 cmm," in mended  # cm or mm?
    assert "facetlog: a.model:4:31: write `upward` [unknown-word]" in err
    assert (code, out.splitlines()[-1]) == (1, "2 files, 2 errors")
    after = (tmp_path / "good.model").stat()
    assert (before.st_mtime_ns, before.st_ino) == (after.st_mtime_ns, after.st_ino)


def test_fix_keeps_line_ends_and_modes(run, tmp_path):
    path = tmp_path / "a.model"
    path.write_bytes(FAULTY.replace("\n", "\r\n").encode())
    path.chmod(0o640)
    assert run("model", "check", "--fix", "a.model")[0] == 0
    assert path.read_bytes() == GOOD.replace("\n", "\r\n").encode()
    assert path.stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("arguments", [["-"], ["a.model", "--watch"]])
def test_fix_needs_files_that_nobody_is_editing(arguments, run, write, tmp_path):
    write(a=FAULTY)
    assert run("model", "check", "--fix", *arguments)[0] == 2
    assert (tmp_path / "a.model").read_text(encoding="utf-8") == FAULTY


def test_junit_has_a_suite_for_each_file_and_a_case_for_each_model(run, write):
    board = GOOD.replace("model slab", "model board")
    write(
        bad=f"let spare = 1\n{FAULTY}\n{GOOD.replace('slab', 'plank')}",
        doubtful=board.replace("  example", "  let square = 15 deg\n  example"),
    )
    arguments = ["model", "check", "bad.model", "doubtful.model", "--output", "junit"]
    code, out, _ = run(*arguments)
    root = ElementTree.fromstring(out)  # noqa: S314 - what this program has just written
    assert (code, root.get("tests"), root.get("failures")) == (1, "5", "1")
    bad, warned = root
    cases = [[(case.get("name"), [one.tag for one in case]) for case in suite] for suite in root]
    assert cases[0] == [("bad.model", []), ("slab", ["failure"]), ("plank", [])]
    assert cases[1] == [("doubtful.model", []), ("board", ["system-out"])]
    assert (bad.get("failures"), warned.get("failures")) == ("1", "0")
    (failure,) = bad.iter("failure")
    assert failure.get("type") == "unknown-word"
    assert "bad.model:5:17: error:" in (failure.text or "")
    assert 'failures="2"' in run(*arguments, "--warnings-as-errors")[1]
