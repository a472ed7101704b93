"""`facetlog model format`: what is written, what is left alone, and what is reported."""

import io
import stat

import pytest

UNTIDY = "model  slab\nface top   # the board\n\n\n\nlevel:top is   level,top is upward\n"
TIDY = "model slab\n  face top  # the board\n\n  level: top is level, top is upward\n"
FAULTY = "model slab\nface top\nlevel: top is is level\n"


def test_a_file_is_laid_out_once_and_keeps_its_mode(run, tmp_path):
    path = tmp_path / "a.model"
    path.write_text(UNTIDY)
    path.chmod(0o640)
    assert run("model", "format", "a.model")[0] == 0
    assert path.read_text() == TIDY
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    before = path.stat()
    assert run("model", "format", "a.model") == (0, "", "")
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)


@pytest.mark.parametrize(
    ("option", "lines"), [("--check", {"a.model"}), ("--diff", {"-model  slab", "+model slab"})]
)
def test_check_and_diff_write_nothing(option, lines, run, tmp_path):
    (tmp_path / "a.model").write_text(UNTIDY)
    (tmp_path / "b.model").write_text(TIDY)
    code, out, err = run("model", "format", option, "a.model", "b.model")
    assert (code, err) == (1, "")
    assert lines <= set(out.splitlines())
    assert (tmp_path / "a.model").read_text() == UNTIDY
    assert run("model", "format", option, "b.model")[0] == 0


def test_files_that_cannot_be_laid_out_are_named_and_stop_no_others(run, tmp_path):
    (tmp_path / "a.model").write_text(FAULTY)
    (tmp_path / "b.model").write_text(UNTIDY)
    (tmp_path / "c.model").write_bytes(b"model \xff\n")
    code, _, err = run("model", "format", "a.model", "c.model", "gone.model", "b.model")
    assert code == 2
    assert (tmp_path / "a.model").read_text() == FAULTY
    assert (tmp_path / "b.model").read_text() == TIDY
    assert "a.model is left as it is: it has 1 fault, the first at a.model:3:" in err
    assert "c.model cannot be read: line 1 is no UTF-8 text" in err
    assert "gone.model cannot be read" in err


@pytest.mark.parametrize(("text", "code", "out"), [(UNTIDY, 0, TIDY), (FAULTY, 1, FAULTY)])
def test_standard_input_goes_to_standard_output(text, code, out, run, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    assert run("model", "format", "-")[:2] == (code, out)


def test_a_file_that_cannot_be_written_stays_as_it_was(run, tmp_path, monkeypatch):
    (tmp_path / "a.model").write_text(UNTIDY)

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    code, _, err = run("model", "format", "a.model")
    assert code == 2
    assert "a.model: cannot be written: No space left" in err
    assert (tmp_path / "a.model").read_text() == UNTIDY
    assert [p.name for p in tmp_path.iterdir()] == ["a.model"]
