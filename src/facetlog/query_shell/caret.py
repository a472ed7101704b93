"""A faulty goal with its fault underlined."""

from rich.cells import cell_len

from facetlog.errors import QueryError
from facetlog.query_shell.shown_terms import visible

TAB = "    "

WIDTH = 160
"""Of a longer line the part round the fault is shown, in characters."""


def place_of(error: QueryError) -> tuple[int, int]:
    """Where in its text the fault is; all of the text if the error does not say.

    >>> place_of(QueryError("", text="X is 1/0"))
    (0, 8)
    """
    start = min(max(error.start, 0), len(error.text))
    end = min(max(error.end, start), len(error.text))
    return (start, end) if end > 0 else (0, len(error.text.rstrip()))


def underlined(error: QueryError) -> list[str]:
    """The line of the goal in which the fault begins and a line with ^~~~ under the fault.

    Wide characters count as two cells, and a fault over several lines is underlined in the first.
    All of the goal is at fault if the error does not say where. Empty if it does not hold the goal.

    >>> print("\\n".join(underlined(QueryError("", text="angel(A, B)", start=0, end=5))))
    angel(A, B)
    ^~~~~
    """
    text = error.text
    if not text.strip():
        return []
    start, end = place_of(error)
    # A fault at the very end is where something is missing, not on an empty line below.
    while start == end == len(text) and start > 0 and text[start - 1] == "\n":
        start = end = len(text := text[:-1])
    first = text.rfind("\n", 0, start) + 1
    last = text.find("\n", start)
    line = text[first : last if last >= 0 else len(text)]
    # Of a long line the part round the fault.
    left = max(0, min(start - first - WIDTH // 2, len(line) - WIDTH))
    line, first = line[left : left + WIDTH], first + left
    before, fault = line[: start - first], line[start - first : end - first]
    lines = [_plain(line), " " * cell_len(_plain(before)) + "^"]
    lines[1] += "~" * (cell_len(_plain(fault)) - 1)
    number = text.count("\n", 0, start) + 1
    return lines if "\n" not in text else [f"line {number} of the goal:", *lines]


def _plain(text: str) -> str:
    """The text with tabs as spaces and other control characters made visible."""
    return visible(text.replace("\t", TAB))
