"""Clouds in text: rows of numbers, with or without the names of their columns above them.

Spreadsheets of half of Europe write 2,39;3,55 and some write 2,39,3,55: where a comma may be either
a decimal mark or a separator, or part of a number of thousands, the text is refused.
"""

import io
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.clouds.point_table import (
    NORMALS,
    PLACE,
    PointTable,
    extract_point_columns,
)
from facetlog.perception.reading.shape_files.file_text import to_plain_bytes
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray

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


def find_number_format(shape: ShapeFile, lines: Sequence[str]) -> NumberFormat:
    """Return how the first rows of numbers are written.

    Raise InputError where commas may mean more than one thing.
    """
    separators = {find_separator(line) for line in lines}
    if len(separators) == 1:
        (separator,) = separators
    else:  # rows that do not all show the same, as 0 0 0 beside 0,5 0 0
        separator = next((mark for mark in (";", "\t") if mark in separators), None)
    rows = [split_row(line, separator) for line in lines]
    trailing = separator is not None and any(line.rstrip(" ").endswith(separator) for line in lines)
    if separator == ",":
        _check_commas(shape, rows)
        return NumberFormat(",", False, trailing)
    words = [word for row in rows for word in row if "," in word]
    if not all(OF_NUMBERS.fullmatch(word) for word in words):
        words = []  # prose has commas, too: the reader of the table says what it is
    if not words:
        return NumberFormat(separator, False, trailing)
    if any("." in word or word.count(",") > 1 for word in words):
        word = next(word for word in words if "." in word or word.count(",") > 1)
        raise shape.error(f"{word:.30}: has thousands separators; {WAY_OUT}")
    if all(OF_THOUSANDS.fullmatch(word) for word in words):
        raise shape.error(f"{words[0]:.30}: may be a decimal number or one of thousands; {WAY_OUT}")
    return NumberFormat(separator, True, trailing)


def _check_commas(shape: ShapeFile, rows: Sequence[tuple[str, ...]]) -> None:
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
        raise shape.error(f"has commas as decimal marks and between columns; {WAY_OUT}")
    if all(THOUSANDS.fullmatch(word) for word in before) and all(
        HUNDREDS.fullmatch(word) for word in after
    ):
        raise shape.error(f"has commas between thousands and between columns; {WAY_OUT}")


# The format of numbers is found from so many rows, the names of columns in lines up to this long.
FIRST_ROWS = 1000
FIRST_BYTES = 1 << 12
# A remark as numpy.savetxt and most others begin it, and as CloudCompare does.
REMARKS = ("#", "//")
# Names of columns are quoted up to this length.
QUOTED = 100
# PTX (Leica): columns, rows, the scanner's place and axes, and a matrix go before the points.
PTX_WIDTHS = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
DEGREES = ("lat", "latitude", "lon", "long", "longitude", "lng")
# Colours and unit normals after x, y, z.
MOST_COLOUR = 255
NORMAL_ERROR = 0.01

NAME_THEM = 'write the names of the columns above them, as "time x y z"'
INDEX_FIRST = (
    "the first of {} columns counts the rows: it was taken for an index, the next three for x, y, z"
)


def read_text(shape: ShapeFile) -> Cloud:
    """Return the cloud of a text file."""
    table = read_text_points(shape, shape.path.read_bytes())
    cloud = Cloud.of(table.points, normals=table.normals, name=shape.name)
    return replace(cloud, warnings=(*table.warnings, *cloud.warnings))


def read_text_points(shape: ShapeFile, data: bytes) -> PointTable:
    """Return the points of rows of numbers.

    Names in a first row, or in a remark as numpy.savetxt and CloudCompare write them, say where
    x, y, z are; without names they come first, or after an index. What is between names and
    numbers is any usual separator; decimal commas are read where only they can be meant.

    Raise InputError for too many points, for what is no such table, and where it is not
    sure which columns x, y and z are.
    """
    file = io.BytesIO(to_plain_bytes(data))
    names, count, lines = _head(file, shape)
    form = find_number_format(shape, lines)
    body = form.to_plain(file.read())
    most = shape.limits.points
    width = len(split_row(lines[0], form.separator)) if lines else 0
    try:
        rows = _load(body, form, most)
    except (ValueError, UnicodeDecodeError) as exc:
        if len(names) != width or not _has_coordinate_names(names):
            said = " ".join(str(exc).split()).partition("; use")[0]
            raise shape.error(
                f"is no table of numbers ({said[:100]}); give x, y, z in each row"
            ) from exc
        names, rows = _load_named(shape, body, form, names, most)
    if len(rows) > most:
        raise shape.error(f"has more than {most} points; thin the cloud")
    if rows.shape[1] < 3:
        raise shape.error("has no x, y, z in each row; export the cloud again")
    if count > len(rows):
        raise shape.make_truncation_error(f"has {len(rows)} of {count} points that it claims")
    if not names:
        return _without_names(shape, rows)
    if not _has_coordinate_names(names):
        advice = "name those of the place x, y, z"
        if {each.lower() for each in names} & set(DEGREES):
            advice = (
                "degrees are no lengths: project them to metres, as UTM, and name these x, y, z"
            )
        raise shape.error(f"has no columns x, y, z but {_quoted(names)}; {advice}")
    return _with_names(shape, names, rows, form)


def _load(body: bytes, form: NumberFormat, most: int) -> FloatArray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a table without rows, which is found by the caller
        return np.loadtxt(
            io.BytesIO(body),
            delimiter=form.separator,
            comments=REMARKS,
            max_rows=most + 1,
            ndmin=2,
        )


def _load_named(
    shape: ShapeFile, body: bytes, form: NumberFormat, names: tuple[str, ...], most: int
) -> tuple[tuple[str, ...], FloatArray]:
    """Return the columns of places and normals, and their names, of rows with words in others."""
    lower = [each.lower() for each in names]
    wanted = [n for n in (*PLACE, *NORMALS[0], *NORMALS[1]) if n in lower]
    at = [lower.index(each) for each in wanted]
    rows: list[list[float]] = []
    for number, line in enumerate(body.decode().split("\n"), 1):
        text = line.strip()
        if not text or text.startswith(REMARKS):
            continue
        words = split_row(text, form.separator)
        try:
            if len(words) != len(names):
                raise ValueError(f"{len(words)} columns")
            rows.append([float(words[k]) for k in at])
        except ValueError as exc:
            raise shape.error(
                f"row {number} is not as its names ({exc!s:.60}; {_quoted(names)}); "
                "export the cloud again"
            ) from exc
        if len(rows) > most:
            break
    return tuple(wanted), np.array(rows, dtype=np.float64).reshape(len(rows), len(at))


def _head(file: io.BytesIO, shape: ShapeFile) -> tuple[tuple[str, ...], int, list[str]]:
    """Return the names of the columns, the number of points, and the first rows of numbers.

    Without names, or a number, they are () and 0. Leaves the file at its first row of numbers.
    """
    remarks: list[str] = []
    names: tuple[str, ...] = ()
    count = 0
    while True:
        start = file.tell()
        line = file.readline()[:FIRST_BYTES].decode("utf-8", "replace")
        text = line.strip()
        if not line or (text and not text.startswith(REMARKS)):
            words = split_row(text, find_separator(text))
            numbers = [word for word in words if _is_number(word)]
            if not names and words and (_has_coordinate_names(words) or not numbers):
                names = words
            elif len(words) == 1 and numbers and not count and not names:
                # how many rows there are, as .pts have it and CloudCompare may
                count = int(float(text)) if re.fullmatch(r"\d{1,15}", text) else 0
                if not count:
                    break
            else:
                break
        elif text:
            remarks.append(text)
    file.seek(start)
    lines = [each.decode("utf-8", "replace").strip(" \n") for each in islice(file, FIRST_ROWS)]
    file.seek(start)
    lines = [each for each in lines if each and not each.startswith(REMARKS)]
    if tuple(len(each.split()) for each in lines[: len(PTX_WIDTHS) - 1]) == PTX_WIDTHS[1:]:
        raise shape.error(
            "is a PTX scan (its size and the scanner's place before the points); "
            "export it as PLY or PTS"
        )
    if not names and lines:
        separator = find_separator(lines[0])
        names = _names_in(remarks, len(split_row(lines[0], separator)), separator)
    return names, count, lines


def _names_in(remarks: list[str], columns: int, separator: str | None) -> tuple[str, ...]:
    """Return the names that a remark gives the columns, none if all are remarks indeed."""
    for remark in reversed(remarks):
        text = remark.removeprefix("//").lstrip("#").strip()
        words = split_row(text, find_separator(text))
        if _has_coordinate_names(words):
            # as in "columns: x y z"
            return words[1:] if words[0].endswith(":") else words
        if separator is not None and find_separator(text) == separator and len(words) == columns:
            return words
    return ()


def _with_names(
    shape: ShapeFile, names: tuple[str, ...], rows: FloatArray, form: NumberFormat
) -> PointTable:
    """Return the columns by their names; rows may have an index before them, as R writes it."""
    width = rows.shape[1]
    if len(names) == width:
        return extract_point_columns(shape, names, rows)
    if len(names) == width - 1 and _counts(rows[:, 0]):
        return extract_point_columns(shape, names, rows[:, 1:])
    # names with blanks in them, or a unit after them: the first three are where they are
    if form.separator is None and len(names) > width and tuple(map(str.lower, names[:3])) == PLACE:
        return extract_point_columns(shape, PLACE, rows)
    raise shape.error(
        f"names {len(names)} columns ({_quoted(names)}) of rows of {width} numbers; "
        "give each column one name, and write decimal points"
    )


def _without_names(shape: ShapeFile, rows: FloatArray) -> PointTable:
    """Return the first three columns, or those after an index; InputError if unsure."""
    width = rows.shape[1]
    if width < 4 or not len(rows):
        return PointTable(rows[:, :3], None)
    first = rows[:, 0]
    if _counts(first):
        return replace(PointTable(rows[:, 1:4], None), warnings=(INDEX_FIRST.format(width),))
    whole = np.array([_is_whole(rows[:, k]) for k in range(width)])
    if (whole[0] and not whole[1:4].any()) or (whole[:3].all() and not whole[3:6].any()):
        raise shape.error(
            f"the first of {width} columns has whole numbers alone, as a label, an index "
            f"or a colour has: {NAME_THEM}"
        )
    others_first = (
        width >= 6
        and _may_be_colour_or_normal(rows[:, :3])
        and not _may_be_colour_or_normal(rows[:, 3:6])
    )
    if others_first:
        raise shape.error(
            f"the first three of {width} columns may be colours or normals: {NAME_THEM}"
        )
    never_falls = bool((np.diff(first) >= 0.0).all()) and float(first[-1]) > float(first[0])
    if never_falls and not _is_colour_or_normal(rows[:, 3:6]) and not whole[3:].all():
        raise shape.error(
            f"the first of {width} columns never falls, as a time or an index does: {NAME_THEM}"
        )
    return PointTable(rows[:, :3], None)


def _counts(values: FloatArray) -> bool:
    """Return whether values are whole numbers with the same step, 1 or more, from row to row."""
    steps = np.diff(values)
    if not len(steps) or not _is_whole(values[:2]):
        return False
    return bool(steps[0] >= 1.0 and (steps == steps[0]).all())


def _is_whole(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return bool((known == np.rint(known)).all())


def _is_colour_or_normal(columns: FloatArray) -> bool:
    """Return whether columns (n, 3) are colours of 0 to 255, or unit normals."""
    if columns.shape[1] < 3:
        return False
    lengths = np.linalg.norm(columns, axis=1)
    known: NDArray[np.bool_] = np.isfinite(lengths) & (lengths > 0.0)
    if known.any() and (np.abs(lengths[known] - 1.0) < NORMAL_ERROR).all():
        return True
    return _is_whole(columns) and bool(((columns >= 0.0) & (columns <= MOST_COLOUR)).all())


def _may_be_colour_or_normal(columns: FloatArray) -> bool:
    """Return whether columns (n, 3) may be colours, also of 0 to 1, or unit normals."""
    return _is_colour_or_normal(columns) or bool(((columns >= 0.0) & (columns <= 1.0)).all())


def _has_coordinate_names(words: tuple[str, ...]) -> bool:
    return set(PLACE) <= {word.lower() for word in words}


def _quoted(names: tuple[str, ...]) -> str:
    said = ", ".join(names)
    return said if len(said) <= QUOTED else f"{said[:QUOTED]}…"


def _is_number(word: str) -> bool:
    try:
        float(word.replace(",", "."))
    except ValueError:
        return False
    return True
