"""Points in text: rows of numbers, the names of their columns above them or not."""

import io
import re
import warnings
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.file_damage import describe_truncation
from facetlog.perception.reading.shape_files.number_format import (
    NumberFormat,
    find_number_format,
    find_separator,
    split_row,
)
from facetlog.perception.reading.shape_files.point_table import (
    NORMALS,
    PLACE,
    PointTable,
    columns_of,
)
from facetlog.perception.reading.shape_files.text_decoding import to_plain_bytes
from facetlog.perception.types import FloatArray

__all__ = ["points_from_text"]

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


def points_from_text(name: str, data: bytes, most: int) -> PointTable:
    """Return the points of rows of numbers.

    Names in a first row, or in a remark as numpy.savetxt and CloudCompare write them, say where
    x, y, z are; without names they come first, or after an index. What is between names and
    numbers is any usual separator; decimal commas are read where only they can be meant.

    Raises InputError for more than `most` points, for what is no such table, and where it is not
    sure which columns x, y and z are.
    """
    file = io.BytesIO(to_plain_bytes(data))
    names, count, lines = _head(file, name)
    form = find_number_format(name, lines)
    body = form.to_plain(file.read())
    width = len(split_row(lines[0], form.separator)) if lines else 0
    try:
        rows = _load(body, form, most)
    except (ValueError, UnicodeDecodeError) as exc:
        if len(names) != width or not _name_place(names):
            said = " ".join(str(exc).split()).partition("; use")[0]
            raise InputError(
                f"{name}: is no table of numbers ({said[:100]}); give x, y, z in each row"
            ) from exc
        names, rows = _load_named(name, body, form, names, most)
    if len(rows) > most:
        raise InputError(f"{name}: has more than {most} points; thin the cloud")
    if rows.shape[1] < 3:
        raise InputError(f"{name}: has no x, y, z in each row; export the cloud again")
    if count > len(rows):
        raise describe_truncation(name, f"has {len(rows)} of {count} points that it claims")
    if not names:
        return _without_names(name, rows)
    if not _name_place(names):
        raise InputError(f"{name}: has no columns x, y, z but {_quoted(names)}; {_advice(names)}")
    return _with_names(name, names, rows, form)


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
    name: str, body: bytes, form: NumberFormat, names: tuple[str, ...], most: int
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
            raise InputError(
                f"{name}: row {number} is not as its names ({exc!s:.60}; {_quoted(names)}); "
                "export the cloud again"
            ) from exc
        if len(rows) > most:
            break
    return tuple(wanted), np.array(rows, dtype=np.float64).reshape(len(rows), len(at))


def _head(file: io.BytesIO, name: str) -> tuple[tuple[str, ...], int, list[str]]:
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
            if not names and words and (_name_place(words) or not numbers):
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
        raise InputError(
            f"{name}: is a PTX scan (its size and the scanner's place before the points); "
            "export it as PLY or PTS"
        )
    if not names and lines:
        separator = find_separator(lines[0])
        names = _names_in(remarks, len(split_row(lines[0], separator)), separator)
    return names, count, lines


def _names_in(remarks: list[str], columns: int, separator: str | None) -> tuple[str, ...]:
    """The names that a remark gives the columns, none if all are remarks indeed."""
    for remark in reversed(remarks):
        text = remark.removeprefix("//").lstrip("#").strip()
        words = split_row(text, find_separator(text))
        if _name_place(words):
            # as in "columns: x y z"
            return words[1:] if words[0].endswith(":") else words
        if separator is not None and find_separator(text) == separator and len(words) == columns:
            return words
    return ()


def _with_names(
    name: str, names: tuple[str, ...], rows: FloatArray, form: NumberFormat
) -> PointTable:
    """The columns by their names; rows may have an index before them, as R writes it."""
    width = rows.shape[1]
    if len(names) == width:
        return columns_of(name, names, rows)
    if len(names) == width - 1 and _counts(rows[:, 0]):
        return columns_of(name, names, rows[:, 1:])
    # names with blanks in them, or a unit after them: the first three are where they are
    if form.separator is None and len(names) > width and tuple(map(str.lower, names[:3])) == PLACE:
        return columns_of(name, PLACE, rows)
    raise InputError(
        f"{name}: names {len(names)} columns ({_quoted(names)}) of rows of {width} numbers; "
        "give each column one name, and write decimal points"
    )


def _without_names(name: str, rows: FloatArray) -> PointTable:
    """The first three columns, or those after an index; InputError where that is not sure."""
    width = rows.shape[1]
    if width < 4 or not len(rows):
        return PointTable(rows[:, :3], None)
    first = rows[:, 0]
    if _counts(first):
        return replace(PointTable(rows[:, 1:4], None), warnings=(INDEX_FIRST.format(width),))
    whole = np.array([_is_whole(rows[:, k]) for k in range(width)])
    if (whole[0] and not whole[1:4].any()) or (whole[:3].all() and not whole[3:6].any()):
        raise InputError(
            f"{name}: the first of {width} columns has whole numbers alone, as a label, an index "
            f"or a colour has: {NAME_THEM}"
        )
    others_first = width >= 6 and _are_others(rows[:, :3]) and not _are_others(rows[:, 3:6])
    if others_first:
        raise InputError(
            f"{name}: the first three of {width} columns may be colours or normals: {NAME_THEM}"
        )
    never_falls = bool((np.diff(first) >= 0.0).all()) and float(first[-1]) > float(first[0])
    if never_falls and not _is_colour_or_normal(rows[:, 3:6]) and not whole[3:].all():
        raise InputError(
            f"{name}: the first of {width} columns never falls, as a time or an index does: "
            f"{NAME_THEM}"
        )
    return PointTable(rows[:, :3], None)


def _counts(values: FloatArray) -> bool:
    """Whether values are whole numbers with the same step, 1 or more, from row to row."""
    steps = np.diff(values)
    if not len(steps) or not _is_whole(values[:2]):
        return False
    return bool(steps[0] >= 1.0 and (steps == steps[0]).all())


def _is_whole(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return bool((known == np.rint(known)).all())


def _is_colour_or_normal(columns: FloatArray) -> bool:
    """Whether columns (n, 3) are colours of 0 to 255, or unit normals."""
    if columns.shape[1] < 3:
        return False
    lengths = np.linalg.norm(columns, axis=1)
    known: NDArray[np.bool_] = np.isfinite(lengths) & (lengths > 0.0)
    if known.any() and (np.abs(lengths[known] - 1.0) < NORMAL_ERROR).all():
        return True
    return _is_whole(columns) and bool(((columns >= 0.0) & (columns <= MOST_COLOUR)).all())


def _are_others(columns: FloatArray) -> bool:
    """Whether columns (n, 3) may be colours, also of 0 to 1, or unit normals."""
    return _is_colour_or_normal(columns) or bool(((columns >= 0.0) & (columns <= 1.0)).all())


def _name_place(words: tuple[str, ...]) -> bool:
    return set(PLACE) <= {word.lower() for word in words}


def _advice(names: tuple[str, ...]) -> str:
    if {each.lower() for each in names} & set(DEGREES):
        return "degrees are no lengths: project them to metres, as UTM, and name these x, y, z"
    return "name those of the place x, y, z"


def _quoted(names: tuple[str, ...]) -> str:
    said = ", ".join(names)
    return said if len(said) <= QUOTED else f"{said[:QUOTED]}…"


def _is_number(word: str) -> bool:
    try:
        float(word.replace(",", "."))
    except ValueError:
        return False
    return True
