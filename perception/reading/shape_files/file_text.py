"""Text of mesh and cloud files: any usual encoding and line end, and many rows of numbers at once.

Exporters write a byte order mark, UTF-16 (PowerShell, old spreadsheets), Latin-1 in comments, and
line ends of CR LF or CR alone. Readers need one form.
"""

import codecs
import re
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray

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
    rows: Sequence[bytes], columns: int, numbers: Iterable[int], shape: ShapeFile, what: str
) -> FloatArray:
    """Return the first `columns` numbers of each row, (n, columns).

    Raise InputError with the line (of `numbers`) of the first row that has fewer numbers.
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
            raise shape.make_bad_row_error(number, row, what)
    raise shape.error(f"has a {what} that is none; export the mesh again")


# A mark of UTF-32 begins as that of UTF-16 does, so it is looked for first.
BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
# Without a mark UTF-16 is detected by the zero bytes of its ASCII characters, in so many bytes.
LOOKED_AT = 1 << 10
# Of UTF-16 text in digits and Latin letters at least this share of one byte of two is zero.
ZERO_SHARE = 0.7


def to_plain_bytes(data: bytes) -> bytes:
    r"""Return a text file as UTF-8 without a mark and with b"\n" at line ends.

    The encoding is that of the mark, else UTF-16 where every other byte is zero, else UTF-8, else
    Latin-1, in which every byte is a character. The same object where it has this form already:
    large files are not copied.
    """
    encoding = _find_encoding(data)
    plain = without_bom(data)
    if encoding in ("utf-8", None):
        if not plain.isascii():
            try:
                plain.decode("utf-8")
            except UnicodeDecodeError:
                plain = plain.decode("latin-1").encode("utf-8")
    else:
        plain = plain.decode(encoding, "replace").encode("utf-8", "replace")
    if b"\r" in plain:
        plain = plain.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return plain


def without_bom(data: bytes) -> bytes:
    """Return the data without a byte order mark at its start; the same object where it has none."""
    mark = next((mark for mark, _ in BOMS if data.startswith(mark)), b"")
    return data[len(mark) :] if mark else data


def find_line_end(header: bytes) -> bytes:
    r"""Return what the first line of a header ends with: b"\r\n", b"\r", or b"\n".

    In a header before binary data only this tells where the data begins.

    >>> find_line_end(b"ply\rformat binary_little_endian 1.0\r")
    b'\r'
    """
    feed, carriage = header.find(b"\n"), header.find(b"\r")
    if carriage < 0 or 0 <= feed < carriage:
        return b"\n"
    return b"\r\n" if feed == carriage + 1 else b"\r"


def _find_encoding(data: bytes) -> str | None:
    """Return the encoding by the byte order mark or by zero bytes; None where neither says."""
    for mark, encoding in BOMS:
        if data.startswith(mark):
            return encoding
    head = data[:LOOKED_AT]
    even, odd = head[::2], head[1::2]
    if odd and odd.count(0) >= ZERO_SHARE * len(odd) and not even.count(0):
        return "utf-16-le"
    if odd and even.count(0) >= ZERO_SHARE * len(even) and not odd.count(0):
        return "utf-16-be"
    return None
