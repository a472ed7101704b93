"""Numbers in the text of mesh files: many rows at once, and the first row that has none."""

import re
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.file_damage import describe_bad_row
from facetlog.perception.types import FloatArray

__all__ = ["parse_numbers", "parse_rows", "without_comments"]

# So C of Windows writes numbers that are none.
WINDOWS_NAN = re.compile(rb"[-+]?1\.#(?:QNAN|SNAN|IND|INF)\w*")
# Numbers that are none have this character, too.
COMMENT = re.compile(rb"(?<!1\.)#[^\n]*")


def without_comments(text: bytes) -> bytes:
    """Return text without what follows a # in its lines."""
    return COMMENT.sub(b"", text) if b"#" in text else text


def parse_numbers(text: bytes, kind: type[np.float64 | np.int64] = np.float64) -> Any:
    """Return the numbers (n,) of text between blanks; None where a word is no number."""
    if not text.strip():
        return np.zeros(0, dtype=kind)
    if b".#" in text:
        text = WINDOWS_NAN.sub(b"nan", text)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy only warns of words that are no numbers
            return np.fromstring(text, dtype=kind, sep=" ")
    except (DeprecationWarning, ValueError, OverflowError):
        return None


def parse_rows(
    rows: Sequence[bytes], columns: int, numbers: Iterable[int], name: str, what: str
) -> FloatArray:
    """Return the first `columns` numbers of each row, (n, columns).

    Raises InputError with the line (of `numbers`) of the first row that has fewer numbers.
    """
    if not rows:
        return np.zeros((0, columns))
    width = len(rows[0].split())
    if all(len(row.split()) == width for row in rows) and width >= columns:
        flat = parse_numbers(b" ".join(rows))
        if flat is not None:
            return np.asarray(flat.reshape(-1, width)[:, :columns], dtype=np.float64)
    cut = [row.split(None, columns)[:columns] for row in rows]
    flat = parse_numbers(b" ".join(b" ".join(words) for words in cut))
    if flat is not None and all(len(words) == columns for words in cut):
        return np.asarray(flat.reshape(-1, columns), dtype=np.float64)
    for number, words, row in zip(numbers, cut, rows, strict=False):
        if len(words) < columns or parse_numbers(b" ".join(words)) is None:
            raise describe_bad_row(name, number, row, what)
    raise InputError(f"{name}: has a {what} that is none; export the mesh again")
