"""Tables of results: Parquet, JSON lines or CSV, out and in, a row at a time."""

import csv
import io
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import count, islice
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, BinaryIO, Literal, get_args, get_origin

from pydantic import BaseModel

from facetlog.batch.rows import COLUMNS, Row, RowRecord, parse_row
from facetlog.errors import InputError, make_missing_extra_error
from facetlog.perception.atomic_write import open_atomically
from facetlog.plain_text import plain_text
from facetlog.safe_read import open_regular

if TYPE_CHECKING:
    import pyarrow

ROWS_AT_ONCE = 1000
"""Rows of a group of Parquet: some megabytes, so that neither side needs memory for the whole."""

MOST_LINE_BYTES = 256_000_000
"""Of a row: all verdicts of a thousand models on a thousand things."""

# Columns that are lists: as JSON in a cell of CSV.
LISTS = ("verdicts", "up", "warnings")
# How a cell begins that spreadsheets take for a formula.
FORMULA = ("=", "+", "-", "@")


def check_format(path: Path) -> None:
    """Raise InputError if no table can be written or read at a path of this suffix."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: tables are written as {', '.join(FORMATS)}: give such a name")
    if path.suffix.lower() == ".parquet":
        import_pyarrow("Parquet")


def write_rows(path: Path, rows: Iterable[Row]) -> None:
    """Write a table in the format of the path's suffix, whole or not at all, in little memory.

    Raise InputError if it cannot be written.
    """
    write, _ = FORMATS[path.suffix.lower()]
    with open_atomically(path) as file:
        write(file, rows)


def read_rows(path: Path) -> Iterator[Row]:
    """Yield the rows of a table, one by one; raise InputError, with the number of the row, at a bad
    one.

    The format is that of the suffix.
    """
    check_format(path)
    _, read = FORMATS[path.suffix.lower()]
    try:
        with open_regular(path) as file:
            for number, data in enumerate(read(file, path), start=1):
                yield parse_row(data, f"{path}: row {number}")
    except OSError as exc:
        raise InputError(f"{path}: cannot be read: {exc.strerror or exc}") from exc


def plain_row(row: Row) -> Row:
    """Return the row with its texts as UTF-8 has them."""
    error = row["error"]
    said = None if error is None else plain_text(error)
    warnings = list(map(plain_text, row["warnings"]))
    return {**row, "path": plain_text(row["path"]), "error": said, "warnings": warnings}


def _escaped(cell: object) -> object:
    r"""Return a cell whose text steers no terminal, and is no formula of a spreadsheet.

    Control characters, as a path may have them, come as \xNN; text that begins as a formula does is
    begun with an apostrophe, which `_unescaped` takes away. Source: OWASP, CSV Injection.

    >>> print(_escaped("a\x1b[31mb"), _escaped("=A1"), _escaped(-1.5))
    a\x1b[31mb '=A1 -1.5
    """
    if not isinstance(cell, str):
        return cell
    if not cell.isprintable():
        cell = "".join(
            c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in cell
        )
    return f"'{cell}" if cell.lstrip("'").startswith(FORMULA) else cell


def _unescaped(cell: str) -> str:
    return cell[1:] if cell[:1] == "'" and cell.lstrip("'").startswith(FORMULA) else cell


def _write_lines(file: BinaryIO, rows: Iterable[Row]) -> None:
    for row in rows:
        clean = plain_row(row)
        file.write(json.dumps(clean, separators=(",", ":"), allow_nan=False).encode() + b"\n")


def _read_lines(file: BinaryIO, path: Path) -> Iterator[object]:
    for number in count(1):
        line = file.readline(MOST_LINE_BYTES + 1)
        if not line:
            return
        if len(line) > MOST_LINE_BYTES:
            raise InputError(f"{path}:{number}: is longer than any line of classify")
        try:
            yield json.loads(line)
        except ValueError as exc:
            raise InputError(f"{path}:{number}: is no line of JSON: {exc}") from exc
        except RecursionError as exc:
            raise InputError(f"{path}:{number}: is no line of JSON: nested too deeply") from exc


def _write_csv(file: BinaryIO, rows: Iterable[Row]) -> None:
    text = io.TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        lists = {k: None if row[k] is None else json.dumps(row[k]) for k in LISTS}
        flag = None if row["metric"] is None else str(row["metric"]).lower()
        cells = {**plain_row(row), **lists, "metric": flag}
        writer.writerow({key: _escaped(cell) for key, cell in cells.items()})
    text.detach()


def _read_csv(file: BinaryIO, path: Path) -> Iterator[object]:
    # A cell holds all verdicts on a scene, which may be long.
    csv.field_size_limit(1 << 30)
    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    try:
        for cells in csv.DictReader(text, strict=True):
            known = {k: v for k, v in cells.items() if v and k in COLUMNS}
            yield {
                **dict.fromkeys(cells),
                **{k: json.loads(v) if k in LISTS else _unescaped(v) for k, v in known.items()},
            }
    except (csv.Error, ValueError, RecursionError) as exc:
        raise InputError(f"{path}: is no table of classify: {exc}") from exc
    finally:
        text.detach()  # the file is its owner's to close


def _write_parquet(file: BinaryIO, rows: Iterable[Row]) -> None:
    import pyarrow.parquet

    source = iter(rows)
    with pyarrow.parquet.ParquetWriter(file, _arrow_schema(), compression="zstd") as writer:
        while some := list(islice(source, ROWS_AT_ONCE)):
            writer.write_table(make_arrow_table(some, pyarrow.Table))


def _read_parquet(file: BinaryIO, path: Path) -> Iterator[object]:
    import pyarrow.parquet

    try:
        table = pyarrow.parquet.ParquetFile(file)
        for batch in table.iter_batches(batch_size=ROWS_AT_ONCE):
            yield from batch.to_pylist()
    except pyarrow.ArrowException as exc:
        raise InputError(f"{path}: is no Parquet file that can be read: {exc}") from exc


def import_pyarrow(user: str) -> Any:
    """Return pyarrow; raise InputError, which names its user, where it is not installed."""
    try:
        import pyarrow.parquet
    except ImportError as exc:
        raise make_missing_extra_error(user, "pyarrow", "batch") from exc
    return pyarrow


def make_arrow_table(rows: Iterable[Row], kind: Any) -> Any:
    """Return rows as an Arrow table of a kind: pyarrow's Table or RecordBatch."""
    return kind.from_pylist([plain_row(row) for row in rows], schema=_arrow_schema())


def _arrow_schema() -> "pyarrow.Schema":
    """Return the columns of a row, typed as pandas and DuckDB take them."""
    import pyarrow

    return pyarrow.schema(_list_arrow_fields(RowRecord))


def _list_arrow_fields(record: type[BaseModel]) -> list[tuple[str, Any]]:
    return [
        (name, _get_arrow_type(field.annotation)) for name, field in record.model_fields.items()
    ]


def _get_arrow_type(kind: Any) -> Any:
    """Return Arrow's type of a field; any value may be missing."""
    import pyarrow as pa

    plain = {str: pa.string(), float: pa.float64(), int: pa.int64(), bool: pa.bool_()}
    if kind in plain:
        return plain[kind]
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return pa.struct(_list_arrow_fields(kind))
    inner = [each for each in get_args(kind) if each is not type(None)]
    if get_origin(kind) is Literal:
        return pa.string()
    return (
        pa.list_(_get_arrow_type(inner[0]))
        if get_origin(kind) is tuple
        else _get_arrow_type(inner[0])
    )


_Write = Callable[[BinaryIO, Iterable[Row]], None]
_Read = Callable[[BinaryIO, Path], Iterator[object]]

FORMATS: Mapping[str, tuple[_Write, _Read]] = MappingProxyType(
    {
        ".parquet": (_write_parquet, _read_parquet),
        ".jsonl": (_write_lines, _read_lines),
        ".csv": (_write_csv, _read_csv),
    }
)
"""How a table of each suffix is written and read."""
