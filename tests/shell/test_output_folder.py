"""Results are there as a whole or not at all, and nobody else's files are lost."""

from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.output_folder import RUN_FILE, check_replaceable, output_folder


def _write(folder: Path, text: str) -> None:
    with output_folder(folder, {"scene": "s"}) as made:
        (made / "views").mkdir()
        (made / "views" / "a.txt").write_text(text)


def test_an_earlier_run_is_replaced(tmp_path):
    out = tmp_path / "deep" / "out"
    _write(out, "first")
    _write(out, "second")
    assert (out / "views" / "a.txt").read_text() == "second"
    assert [p.name for p in out.parent.iterdir()] == ["out"]


@pytest.mark.parametrize("fault", [KeyboardInterrupt, ZeroDivisionError])
def test_nothing_half_written_stays(tmp_path, fault):
    _write(tmp_path / "out", "first")

    def write_half() -> None:
        with output_folder(tmp_path / "out", {}) as made:
            (made / "views.txt").write_text("half")
            raise fault

    with pytest.raises(fault):
        write_half()
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert (tmp_path / "out" / "views" / "a.txt").read_text() == "first"


def test_a_full_disk_is_one_line_that_names_the_folder(tmp_path):
    with (
        pytest.raises(InputError, match="out cannot be written"),
        output_folder(tmp_path / "out", {}),
    ):
        raise OSError(28, "No space left on device")
    assert not list(tmp_path.iterdir())


def test_files_of_others_are_not_replaced(tmp_path):
    _write(tmp_path / "out", "first")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"holds notes\.txt"):
        check_replaceable(tmp_path / "out")
    (tmp_path / "out" / "notes.txt").unlink()
    (tmp_path / "out" / RUN_FILE).write_text("{}")
    with pytest.raises(InputError, match="did not write"):
        check_replaceable(tmp_path / "out")
