"""Text that any encoding can hold: what it cannot is escaped, and no name makes a traceback.

Names of files are bytes. Python has those that are no UTF-8 as half a letter each (PEP 383), which
no file, page or engine takes. This module is one of the lowest, as errors.py is.
"""

import codecs
import io
import os
import sys

__all__ = ["ESCAPED", "open_streams", "plain_text", "to_plain_marks"]

ESCAPED = "facetlog-escaped"
"""Name of the error handler `_escape` for streams."""

RAW_BYTES = range(0xDC80, 0xDD00)

PLAINER = {"─": "-", "–": "-", "…": "..."}
"""Replacements of marks that an encoding lacks."""


def to_plain_marks(text: str) -> str:
    """Return the text with dashes and the like in ASCII.

    >>> to_plain_marks("58–97%")
    '58-97%'
    """
    return "".join(PLAINER.get(letter, letter) for letter in text)


def plain_text(text: str) -> str:
    r"""Return the text with bytes of a name that are no UTF-8 as \xNN.

    >>> print(plain_text("a\udcff"), plain_text("b\ud800"))
    a\xff b\ud800
    """
    return text if text.isascii() else text.encode("utf-8", ESCAPED).decode()


def open_streams() -> None:
    """Make standard input, output and error writable whatever they are, before anything is opened.

    What is closed becomes the null device: a file that is opened later would take its number, and
    what is written there. What their encoding lacks is escaped.
    """
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(descriptor)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free
            if null != descriptor:
                os.dup2(null, descriptor)
                os.close(null)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(descriptor, "w" if descriptor else "r", encoding="utf-8"))
    streams = (sys.stdout, ESCAPED), (sys.stderr, ESCAPED), (sys.stdin, "surrogateescape")
    for stream, errors in streams:
        if isinstance(stream, io.TextIOWrapper):  # not what stands in for it, as in a notebook
            stream.reconfigure(errors=errors)


def _escape(fault: UnicodeError) -> tuple[str, int]:
    if not isinstance(fault, UnicodeEncodeError):
        raise fault
    wrong = fault.object[fault.start : fault.end]
    return "".join(map(_escape_letter, wrong)), fault.end


def _escape_letter(letter: str) -> str:
    if ord(letter) in RAW_BYTES:
        return f"\\x{ord(letter) - 0xDC00:02x}"
    return PLAINER.get(letter) or letter.encode("ascii", "backslashreplace").decode()


codecs.register_error(ESCAPED, _escape)
