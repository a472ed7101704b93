"""`facetlog model format`: what is written, what is left alone, and what is told."""

import io
import stat
from pathlib import Path

import pytest

from facetlog.cli import main

UNTIDY = "model  slab\nface top   # the board\n\n\n\nlevel:top is   level,top is upward\n"
TIDY = "model slab\n  face top  # the board\n\n  level: top is level, top is upward\n"
FAULTY = "model slab\nface top\nlevel: top is is level\n"


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_file_is_laid_out_and_keeps_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "a.model"
    path.write_text(UNTIDY)
    path.chmod(0o640)
    assert main(["model", "format", "a.model"]) == 0
    assert path.read_text() == TIDY
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert [p.name for p in tmp_path.iterdir()] == ["a.model"]


def test_a_file_in_form_is_not_touched(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.model"
    path.write_text(TIDY)
    before = path.stat()
    assert main(["model", "format", "a.model"]) == 0
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)
    assert capsys.readouterr() == ("", "")


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "a.model").write_text(UNTIDY)
    (tmp_path / "b.model").symlink_to("deep/a.model")
    assert main(["model", "format", "b.model"]) == 0
    assert (tmp_path / "b.model").is_symlink()
    assert (tmp_path / "deep" / "a.model").read_text() == TIDY


def test_check_names_the_files_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.model").write_text(UNTIDY)
    (tmp_path / "b.model").write_text(TIDY)
    assert main(["model", "format", "--check", "a.model", "b.model"]) == 1
    assert capsys.readouterr() == ("a.model\n", "")
    assert (tmp_path / "a.model").read_text() == UNTIDY
    assert main(["model", "format", "--check", "b.model"]) == 0


def test_diff_shows_what_would_change_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.model").write_text(UNTIDY)
    assert main(["model", "format", "--diff", "a.model"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert "-model  slab" in lines
    assert "+model slab" in lines
    assert (tmp_path / "a.model").read_text() == UNTIDY


def test_files_with_faults_are_left_alone_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.model").write_text(FAULTY)
    (tmp_path / "b.model").write_text(UNTIDY)
    assert main(["model", "format", "a.model", "b.model"]) == 1
    assert (tmp_path / "a.model").read_text() == FAULTY
    assert (tmp_path / "b.model").read_text() == TIDY
    assert "a.model is left as it is: it has 1 fault, the first at a.model:3:" in (
        capsys.readouterr().err
    )


def test_standard_input_goes_to_standard_output(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(UNTIDY.encode())))
    assert main(["model", "format", "-"]) == 0
    assert capsys.readouterr() == (TIDY, "")


def test_faulty_standard_input_comes_back_as_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(FAULTY.encode())))
    assert main(["model", "format", "-"]) == 1
    assert capsys.readouterr().out == FAULTY


def test_a_file_that_cannot_be_read_does_not_stop_the_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.model").write_bytes(b"model \xff\n")
    (tmp_path / "b.model").write_text(UNTIDY)
    assert main(["model", "format", "a.model", "gone.model", "b.model"]) == 2
    err = capsys.readouterr().err
    assert "a.model cannot be read: line 1 is no UTF-8 text" in err
    assert "gone.model cannot be read" in err
    assert (tmp_path / "b.model").read_text() == TIDY


@pytest.mark.parametrize("text", ["", "\n\n", "# nothing but this\n"])
def test_a_file_without_models_is_no_fault(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.model").write_text(text)
    assert main(["model", "format", "."]) == 0
    assert "fault" not in capsys.readouterr().err
    assert (tmp_path / "a.model").read_text() == text.lstrip("\n")


def test_a_file_that_cannot_be_written_stays_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.model").write_text(UNTIDY)

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    assert main(["model", "format", "a.model"]) == 2
    assert "a.model: cannot be written: No space left" in capsys.readouterr().err
    assert (tmp_path / "a.model").read_text() == UNTIDY
    assert [p.name for p in tmp_path.iterdir()] == ["a.model"]


def test_files_that_are_rewritten_are_not_watched(tmp_path: Path) -> None:
    (tmp_path / "a.model").write_text(UNTIDY)
    assert main(["model", "format", "--watch", "a.model"]) == 2
    assert (tmp_path / "a.model").read_text() == UNTIDY
