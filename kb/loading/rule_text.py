"""The text of a file of rules: Prolog itself never opens the file."""

from pathlib import Path

from facetlog.errors import RuleSyntaxError
from facetlog.regular_file import read_regular

__all__ = ["LONGEST_BYTES", "rule_text"]

LONGEST_BYTES = 1_000_000
"""No larger file is read; reading.pl, which counts characters, has the tighter limit."""


def rule_text(path: Path) -> str:
    """The text of the file, line ends as they are.

    Raises RuleSyntaxError if it is not there, may not be read, is too large, or is not UTF-8; then
    the message names the line.
    """
    try:
        data = read_regular(path, LONGEST_BYTES)
    except FileNotFoundError:
        raise RuleSyntaxError(f"{path}: there is no such file") from None
    except PermissionError:
        raise RuleSyntaxError(f"{path}: it may not be read") from None
    except OSError as exc:
        raise RuleSyntaxError(f"{path}: it cannot be read: {exc.strerror}") from exc
    try:
        return data.decode()
    except UnicodeDecodeError as exc:
        line = data.count(b"\n", 0, exc.start) + 1
        raise RuleSyntaxError(
            f"{path}:{line}: this is no UTF-8 text: save the file as UTF-8"
        ) from exc
