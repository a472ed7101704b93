"""Tables: what goes out comes back, in formats that others read, whole or not at all."""

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.batch.output import FORMATS, check_format, read_rows, write_rows
from facetlog.batch.row_records import row_from
from facetlog.batch.rows import Row
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
    assert list(read_rows(table)) == [row_from(row, "") for row in rows]


def test_a_table_without_rows_is_one(table: Path) -> None:
    write_rows(table, [])
    assert list(read_rows(table)) == []


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


def test_a_line_of_json_that_never_ends_or_nests_is_named(tmp_path: Path) -> None:
    (tmp_path / "t.jsonl").write_bytes(b"[" * 100_000)
    with pytest.raises(InputError, match=r"t\.jsonl:1: is no line of JSON: nested too deeply"):
        list(read_rows(tmp_path / "t.jsonl"))


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


def test_other_suffixes_are_refused() -> None:
    with pytest.raises(InputError, match=r"a\.xls: tables are written as \.parquet"):
        check_format(Path("a.xls"))


def test_pandas_reads_typed_columns(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    pandas = pytest.importorskip("pandas")
    write_rows(tmp_path / "t.parquet", _rows())
    frame = pandas.read_parquet(tmp_path / "t.parquet")
    assert list(frame["things"].dropna()) == [1]
    assert str(frame["seconds"].dtype) == "float64"
    assert frame["verdicts"][0][0]["parts"][0]["names"][1] == "f2"


def test_duckdb_asks_for_verdicts(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    duckdb = pytest.importorskip("duckdb")
    scene = tmp_path / "box-1.json"
    scene.touch()
    write_rows(tmp_path / "t.parquet", [fake_row(str(scene), ())])
    table = duckdb.read_parquet(str(tmp_path / "t.parquet"))
    verdicts = table.project("unnest(verdicts) as v").filter("v.state = 'holds'")
    found = verdicts.project("v.model, v.degree, v.sizes[1].value").fetchall()
    assert found == [("box", 0.9, 0.5)]


def test_lines_are_json_that_the_schema_describes(tmp_path: Path) -> None:
    write_rows(tmp_path / "t.jsonl", _rows())
    lines = (tmp_path / "t.jsonl").read_text().splitlines()
    assert json.loads(lines[1]) == _rows()[1]
