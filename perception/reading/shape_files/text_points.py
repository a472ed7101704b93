"""Points in text: rows of numbers, the names of their columns above them or not."""

import codecs
import io
import warnings

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.point_table import PLACE, PointTable, columns_of

__all__ = ["points_from_text"]

# Lines are looked at this far for their separator and the names of columns.
FIRST_BYTES = 1 << 12
# A remark as numpy.savetxt and most others begin it, and as CloudCompare does.
REMARKS = ("#", "//")
# Names of columns are quoted up to this length.
QUOTED = 100


def points_from_text(name: str, data: bytes, most: int) -> PointTable:
    """The points of rows of numbers: x y z come first unless names above the rows say where.

    Names are in a first row, or in a remark as numpy.savetxt and CloudCompare write them; what is
    between them and numbers is any usual separator.

    Raises InputError for more than `most` points, and for what is no such table.
    """
    file = io.BytesIO(data)
    file.seek(len(codecs.BOM_UTF8) if data.startswith(codecs.BOM_UTF8) else 0)
    names, separator = _head(file)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a table without rows, which is found below
            rows = np.loadtxt(file, delimiter=separator, max_rows=most + 1, ndmin=2)
    except (ValueError, UnicodeDecodeError) as exc:
        said = " ".join(str(exc).split())
        raise InputError(
            f"{name}: is no table of numbers ({said[:100]}); give x, y, z in each row"
        ) from exc
    if len(rows) > most:
        raise InputError(f"{name}: has more than {most} points; thin the cloud")
    if rows.shape[1] < 3:
        raise InputError(f"{name}: has no x, y, z in each row; export the cloud again")
    if not names:
        return PointTable(rows[:, :3], None)
    if not _name_place(names):
        raise InputError(
            f"{name}: has no columns x, y, z but {_quoted(names)}; name those of the place x, y, z"
        )
    if len(names) != rows.shape[1]:
        # names with blanks in them, or a unit after them: the first three are where they are
        if tuple(map(str.lower, names[:3])) != PLACE:
            raise InputError(
                f"{name}: names {len(names)} columns ({_quoted(names)}) of rows of "
                f"{rows.shape[1]} numbers; put x, y, z first, or give each column one name"
            )
        names = PLACE
    return columns_of(name, names, rows)


def _head(file: io.BytesIO) -> tuple[tuple[str, ...], str | None]:
    """The names of the columns, if there are any, and the rows' separator, None for blanks.

    Leaves the file at its first row of numbers.
    """
    remarks: list[str] = []
    names: tuple[str, ...] = ()
    counted = False
    while True:
        start = file.tell()
        line = file.readline()[:FIRST_BYTES].decode("utf-8", "replace")
        text = line.strip()
        if not line or (text and not text.startswith(REMARKS)):
            separator = _separator(text)
            words = _words(text, separator)
            numbers = [word for word in words if _is_number(word)]
            if not names and words and (_name_place(words) or not numbers):
                names = words
            elif len(words) == 1 and numbers and not counted:
                counted = True  # how many rows there are, as .pts have it and CloudCompare may
            else:
                file.seek(start)
                return names or _names_in(remarks, len(words), separator), separator
        elif text:
            remarks.append(text)


def _names_in(remarks: list[str], columns: int, separator: str | None) -> tuple[str, ...]:
    """The names that a remark gives the columns, none if all are remarks indeed."""
    for remark in reversed(remarks):
        text = remark.removeprefix("//").lstrip("#").strip()
        words = _words(text, _separator(text))
        if _name_place(words):
            # as in "columns: x y z"
            return words[1:] if words[0].endswith(":") else words
        if separator is not None and _separator(text) == separator and len(words) == columns:
            return words
    return ()


def _separator(text: str) -> str | None:
    return next((mark for mark in ",;" if mark in text), None)


def _words(text: str, separator: str | None) -> tuple[str, ...]:
    return tuple(word.strip().strip('"') for word in text.split(separator))


def _name_place(words: tuple[str, ...]) -> bool:
    return set(PLACE) <= {word.lower() for word in words}


def _quoted(names: tuple[str, ...]) -> str:
    said = ", ".join(names)
    return said if len(said) <= QUOTED else f"{said[:QUOTED]}…"


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
