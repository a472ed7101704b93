"""`facetlog model compile`: the forms of a model file."""

import io
from pathlib import Path

import pytest

from facetlog.cli import main

MODEL = 'model slab\n  "A board."\n  face top\n  level: top is level, top is upward  "it is flat"\n'
MODEL += '  example "board" of cuboid(height 2 cm) holds\n'
UNKNOWN_WORD = MODEL.replace("upward", "upwrad")


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slab.model").write_text(MODEL)
    (tmp_path / "faulty.model").write_text(UNKNOWN_WORD)
    return tmp_path


def test_prolog_is_a_rule_file_that_can_be_loaded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "compile", "slab.model"]) == 0
    text, err = capsys.readouterr()
    assert text.startswith(":- module(slab, []).")
    assert err == ""
    from facetlog.kb.knowledge_base import KnowledgeBase

    (tmp_path / "slab.pl").write_text(text)
    with KnowledgeBase() as base:
        assert base.load_rules(tmp_path / "slab.pl", trusted=True).models == ("slab",)


@pytest.mark.parametrize(
    ("form", "lines"),
    [
        ("tree", ["line", "  part", "    relation", "property"]),
        ("ast", ["Model 1:7", "  doc: Text 2:3 value='A board.'", "  statements: Line 4:3"]),
        ("clauses", ['model(slab, "A board.", [top]).']),
    ],
)
def test_each_form_can_be_shown(
    form: str, lines: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "compile", "slab.model", "--emit", form]) == 0
    out = capsys.readouterr().out
    assert any(line in out for line in lines)
    assert [line for line in lines if line in out.splitlines() or form == "tree"] == lines


@pytest.mark.parametrize("form", ["clauses", "prolog"])
def test_a_faulty_file_has_no_clauses(
    form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["model", "compile", "faulty.model", "--emit", form, "-o", "out.pl"]
    assert main(arguments) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "faulty.model:4:31: error: " in err
    assert not (tmp_path / "out.pl").exists()


@pytest.mark.parametrize("form", ["tree", "ast"])
def test_a_faulty_file_is_shown_as_far_as_it_goes(
    form: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "compile", "faulty.model", "--emit", form]) == 1
    out, err = capsys.readouterr()
    assert "upwrad" in out
    assert "faulty.model:4:31: error: " in err


def test_standard_input_can_be_compiled(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(MODEL.encode())))
    assert main(["model", "compile", "-"]) == 0
    assert 'model(slab, "A board.", [top]).' in capsys.readouterr().out


def test_the_result_can_be_written_to_a_file_again_and_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for again in ((), ("--overwrite",)):
        assert main(["model", "compile", "slab.model", "-o", "slab.pl", *again]) == 0
    assert capsys.readouterr() == ("", "")
    assert (tmp_path / "slab.pl").read_text().startswith(":- module(slab, []).")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["faulty.model", "slab.model", "slab.pl"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["slab.model", "-o", "./slab.model"], "is what is read"),
        (["slab.model", "-o", "absent/slab.pl"], "cannot be written"),
        (["gone.model"], "gone.model: the file cannot be read"),
        (["."], "names 2 files: give one"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    arguments: list[str], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "compile", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("facetlog: ")
    assert err.count("\n") == 1
    assert says in err
    assert (tmp_path / "slab.model").read_text() == MODEL
