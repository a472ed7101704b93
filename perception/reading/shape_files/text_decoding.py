"""Text of any usual encoding and line end, as UTF-8 with line feeds.

Exporters write a byte order mark, UTF-16 (PowerShell, old spreadsheets), Latin-1 in comments, and
line ends of CR LF or CR alone. Readers need one form.
"""

import codecs

__all__ = ["decode_text", "find_line_end", "to_plain_bytes", "without_bom"]

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


def decode_text(data: bytes) -> str:
    r"""Return the text of a file, without a byte order mark and with "\n" at line ends.

    The encoding is that of the mark, else UTF-16 where every other byte is zero, else UTF-8, else
    Latin-1, in which every byte is a character.

    >>> decode_text(codecs.BOM_UTF16_LE + "1,5\r2".encode("utf-16-le"))
    '1,5\n2'
    """
    return to_plain_bytes(data).decode("utf-8")


def to_plain_bytes(data: bytes) -> bytes:
    r"""Return a text file as UTF-8 without a mark and with b"\n" at line ends.

    The same object where it has this form already: large files are not copied.
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
    """The encoding by the byte order mark or by zero bytes; None where neither says."""
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
