"""Errors of files that are truncated, or whose parts do not fit together: one wording for all."""

import re

from facetlog.errors import InputError

__all__ = [
    "describe_bad_row",
    "describe_claim",
    "describe_inconsistency",
    "describe_truncation",
    "quote_line",
]

DECIMAL_COMMA = re.compile(rb"^[-+]?\d*,\d+(?:[eE][-+]?\d+)?$")
# Lines are quoted up to so many characters.
QUOTED = 60


def describe_truncation(name: str, what: str) -> InputError:
    """Return the error of a file that ends too early."""
    return InputError(f"{name}: {what}; it is truncated: export or copy it again")


def describe_claim(name: str, claim: str) -> InputError:
    """Return the error of a header whose counts are larger than the file."""
    return describe_truncation(name, f"claims {claim}, more than it holds")


def describe_inconsistency(name: str, what: str) -> InputError:
    """Return the error of a file whose counts or indices contradict its contents."""
    return InputError(f"{name}: {what}; it is truncated or inconsistent, export it again")


def quote_line(name: str, number: int, row: bytes) -> str:
    """Return the place and the text of a line, as a message begins."""
    shown = row.decode("utf-8", "replace").strip()
    return f"{name}: line {number}: {shown:.{QUOTED}}"


def describe_bad_row(name: str, number: int, row: bytes, what: str) -> InputError:
    """Return the error of a row, in line `number`, that is not the numbers of a `what`."""
    place = quote_line(name, number, row)
    if any(DECIMAL_COMMA.match(word) for word in row.split()):
        return InputError(f"{place}: has decimal commas; export with decimal points")
    if b"," in row:
        return InputError(f"{place}: has commas between numbers; export with blanks")
    return describe_inconsistency(place, f"is no {what}")
