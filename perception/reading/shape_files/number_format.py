"""How numbers are written in the rows of a text: separator, decimal mark, trailing separators.

Spreadsheets of half of Europe write 2,39;3,55 and some write 2,39,3,55: where a comma may be either
a decimal mark or a separator, or part of a number of thousands, the text is refused.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from facetlog.errors import InputError

__all__ = ["NumberFormat", "find_number_format", "find_separator", "split_row"]

WITH_COMMA = re.compile(r"[+-]?\d*,?\d+(?:[eE][+-]?\d+)?")
OF_NUMBERS = re.compile(r"[-+]?[\d.,]*\d[\d.,]*(?:[eE][-+]?\d+)?")
OF_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")
INTEGER = re.compile(r"[+-]?\d+")
# The two halves of 1,234.5 where a comma separates columns, too.
THOUSANDS, HUNDREDS = re.compile(r"[+-]?[1-9]\d{0,2}"), re.compile(r"\d{3}(?:\.\d+)?")
DIGITS, LEADING_ZERO = re.compile(r"\d+"), re.compile(r"0\d+")
# Three coordinates whose decimal comma separates columns, too, make six columns.
LEAST_SPLIT = 6

WAY_OUT = "write a point as decimal mark, and columns separated by blanks or semicolons"


@dataclass(frozen=True, slots=True)
class NumberFormat:
    """The separator of columns (None: blanks), the decimal mark, and how rows end."""

    separator: str | None
    is_decimal_comma: bool = False
    ends_with_separator: bool = False

    def to_plain(self, rows: bytes) -> bytes:
        """Return rows of text with decimal points and without trailing separators or quotes."""
        if b'"' in rows:
            rows = rows.replace(b'"', b"")
        if self.is_decimal_comma:
            rows = rows.replace(b",", b".")
        if self.ends_with_separator and self.separator is not None:
            mark = re.escape(self.separator.encode())
            rows = re.sub(rb"[ \t]*(?:" + mark + rb"[ \t]*)+$", b"", rows, flags=re.MULTILINE)
        return rows


def find_separator(text: str) -> str | None:
    """Return what separates the columns of a row of names or numbers, None for blanks.

    >>> find_separator("x;y;z"), find_separator("1,5 2,5 3,5"), find_separator("1, 5, 2")
    (';', None, ',')
    """
    if ";" in text:
        return ";"
    fields = text.split("\t")
    if len(fields) > 2 and not any(" " in field.strip() for field in fields):
        return "\t"
    words = text.split()
    inside = [word for word in words if "," in word]
    if not inside:
        return "," if "," in text else None
    # decimal commas are within the numbers of all columns, separators are not
    is_decimal = len(words) > 2 and all(WITH_COMMA.fullmatch(word) for word in words)
    return None if is_decimal else ","


def split_row(text: str, separator: str | None) -> tuple[str, ...]:
    """Return the words of a row, without quotes and without empty ones at its end."""
    words = [word.strip().strip("\"'").strip() for word in text.split(separator)]
    while words and not words[-1]:
        words.pop()
    return tuple(words)


def find_number_format(name: str, lines: Sequence[str]) -> NumberFormat:
    """Return how the first rows of numbers are written.

    Raises InputError where commas may mean more than one thing.
    """
    separators = {find_separator(line) for line in lines}
    separator = next(iter(separators)) if len(separators) == 1 else _common_of(separators)
    rows = [split_row(line, separator) for line in lines]
    trailing = separator is not None and any(line.rstrip(" ").endswith(separator) for line in lines)
    if separator == ",":
        _check_commas(name, rows)
        return NumberFormat(",", False, trailing)
    words = [word for row in rows for word in row if "," in word]
    if not all(OF_NUMBERS.fullmatch(word) for word in words):
        words = []  # prose has commas, too: the reader of the table says what it is
    if not words:
        return NumberFormat(separator, False, trailing)
    if any("." in word or word.count(",") > 1 for word in words):
        word = next(word for word in words if "." in word or word.count(",") > 1)
        raise InputError(f"{name}: {word:.30}: has thousands separators; {WAY_OUT}")
    if all(OF_THOUSANDS.fullmatch(word) for word in words):
        raise InputError(
            f"{name}: {words[0]:.30}: may be a decimal number or one of thousands; {WAY_OUT}"
        )
    return NumberFormat(separator, True, trailing)


def _common_of(separators: set[str | None]) -> str | None:
    """The separator of rows that do not all show the same, as 0 0 0 beside 0,5 0 0."""
    return next((mark for mark in (";", "\t") if mark in separators), None)


def _check_commas(name: str, rows: Sequence[tuple[str, ...]]) -> None:
    """Raise InputError where commas between columns are those within numbers, too."""
    width = len(rows[0]) if rows else 0
    if width < LEAST_SPLIT or width % 2 or any(len(row) != width for row in rows):
        return
    before = [word for row in rows for word in row[::2]]
    after = [word for row in rows for word in row[1::2]]
    is_decimal = (
        all(INTEGER.fullmatch(word) for word in before)
        and all(DIGITS.fullmatch(word) for word in after)
        and any(LEADING_ZERO.fullmatch(word) for word in after)
    )
    if is_decimal:
        raise InputError(f"{name}: has commas as decimal marks and between columns; {WAY_OUT}")
    if all(THOUSANDS.fullmatch(word) for word in before) and all(
        HUNDREDS.fullmatch(word) for word in after
    ):
        raise InputError(f"{name}: has commas between thousands and between columns; {WAY_OUT}")
