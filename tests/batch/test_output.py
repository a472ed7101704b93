"""Tables: what goes out comes back, in formats that others read, whole or not at all."""

import csv
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.batch.output import FORMATS, read_rows, write_rows
from facetlog.batch.rows import Row, parse_row
from facetlog.errors import InputError
from tests.batch.fake_worker import fake_row


def _rows() -> list[Row]:
    absent = 'absent, "so" \n called.json'
    return [fake_row(__file__, ()), fake_row(absent, ()), fake_row("box-ünï.json", ())]


@pytest.fixture(params=FORMATS)
def table(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    if request.param == ".parquet":
        pytest.importorskip("pyarrow")
    return tmp_path / f"t{request.param}"


@pytest.mark.slow
def test_rows_come_back_as_they_were(table: Path) -> None:
    rows = _rows() * 700  # more than one group
    write_rows(table, rows)
    assert list(read_rows(table)) == [parse_row(row, "") for row in rows]


def test_a_csv_holds_no_control_characters(tmp_path: Path) -> None:
    row = {**fake_row("a\x1b[31m\r\u202eb.json", ()), "error": "no \x07 bell"}
    write_rows(tmp_path / "t.csv", [row])
    (read,) = read_rows(tmp_path / "t.csv")
    assert (read["path"], read["error"]) == ("a\\x1b[31m\\r\\u202eb.json", "no \\x07 bell")
    said = (tmp_path / "t.csv").read_text(encoding="utf-8")
    assert all(line.isprintable() for line in said.splitlines())


def test_a_csv_holds_no_formulas_and_comes_back_as_it_was(tmp_path: Path) -> None:
    paths = [
        "=cmd|'/C calc'!A0.json",
        "+a.json",
        "-a.json",
        "@a.json",
        "'=a.json",
        "''-",
        "'a.json",
    ]
    rows = [fake_row(path, ()) for path in paths]
    write_rows(tmp_path / "t.csv", rows)
    assert [row["path"] for row in read_rows(tmp_path / "t.csv")] == paths
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as file:
        cells = [cell for line in csv.DictReader(file) for cell in line.items()]
    assert not [cell for _, cell in cells if cell.startswith(("=", "+", "-", "@"))]


def test_a_path_that_is_no_text_is_written_all_the_same(table: Path) -> None:
    write_rows(table, [fake_row("a\udcff.json", ())])
    assert [row["path"] for row in read_rows(table)] == ["a\\xff.json"]


def test_a_table_that_fails_leaves_the_old_one(table: Path) -> None:
    def failing() -> Iterator[Row]:
        yield from _rows()
        raise OSError(28, "No space left on device")

    write_rows(table, _rows()[:1])
    before = table.read_bytes()
    with pytest.raises(InputError, match="No space left"):
        write_rows(table, failing())
    assert table.read_bytes() == before
    assert [path.name for path in table.parent.iterdir()] == [table.name]


def test_a_file_that_is_no_table_is_one_line(table: Path) -> None:
    table.write_text('"not a table')
    with pytest.raises(InputError, match=table.name):
        list(read_rows(table))
    table.unlink()
    with pytest.raises(InputError, match="cannot be read: No such file"):
        list(read_rows(table))
