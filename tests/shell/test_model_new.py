"""`facetlog model new`: a file to start from."""

from pathlib import Path

import pytest

from facetlog.cli import main


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_new_model_passes_its_check(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "new", "coffee_table"]) == 0
    assert capsys.readouterr() == ("coffee_table.model\n", "")
    assert main(["model", "check", "coffee_table.model", "--warnings-as-errors"]) == 0


def test_the_file_can_be_named(tmp_path: Path) -> None:
    assert main(["model", "new", "bench", "-o", "mine.model"]) == 0
    assert "model bench\n" in (tmp_path / "mine.model").read_text(encoding="utf-8")


def test_a_name_may_be_that_of_the_file(tmp_path: Path) -> None:
    assert main(["model", "new", "gate.model"]) == 0
    assert "model gate\n" in (tmp_path / "gate.model").read_text(encoding="utf-8")


def test_a_file_that_is_there_is_left_as_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bench.model").write_text("mine")
    assert main(["model", "new", "bench"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert (tmp_path / "bench.model").read_text() == "mine"


@pytest.mark.parametrize("name", ["pair", "two words", "3legs", "a\nmodel b", "", "a-b"])
def test_a_name_that_the_language_does_not_have_is_refused(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "new", name]) == 2
    err = capsys.readouterr().err
    assert err.startswith("facetlog: ")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("out", ["absent/a.model", "a.pl", "."])
def test_a_file_that_cannot_be_written_is_refused(out: str, tmp_path: Path) -> None:
    assert main(["model", "new", "bench", "-o", out]) == 2
    assert not list(tmp_path.iterdir())
