"""Write results to stdout, and remarks and errors to stderr, with the fault underlined."""

import pydoc
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import chain, islice

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from facetlog.errors import FacetlogError, QueryError
from facetlog.query_shell.shown_terms import visible
from facetlog.terminal import error_lines

ERROR = "error: "
TAB = "    "

WIDTH = 160
"""Number of characters shown of a longer line, around the fault."""


class Screen:
    """Writes plain lines; styles only on a terminal that has them (rich heeds NO_COLOR, TERM)."""

    def __init__(self) -> None:
        self._out = Console(highlight=False, markup=False, emoji=False, soft_wrap=True)
        self._remarks = Console(
            stderr=True, highlight=False, markup=False, emoji=False, soft_wrap=True
        )
        self._kept: list[str] | None = None
        self._last_was_table: bool | None = None

    @property
    def width(self) -> int | None:
        """Cells in a line of the terminal; None if results go into a file or pipe."""
        return self._out.width if self._out.is_terminal else None

    @property
    def height(self) -> int | None:
        """Lines of the terminal, None without one."""
        return self._out.height if self._out.is_terminal else None

    def say(self, *lines: str, style: str = "") -> None:
        """Write lines of a result."""
        if self._kept is not None:
            self._kept.extend(map(visible, lines))
        elif style and self._out.is_terminal:
            for line in lines:
                self._out.print(Text(_wrap(line, self._out), style=style))
        elif lines:
            # Past rich, whose care for each line would cost more than finding the answers.
            texts = (_wrap(visible(line), self._out) for line in lines)
            self._out.file.write("\n".join(texts) + "\n")

    @contextmanager
    def keeping(self) -> Iterator[list[str]]:
        """Keep the lines of results and remarks instead of writing them."""
        kept: list[str] = []
        self._kept = kept
        try:
            yield kept
        finally:
            self._kept = None

    def begin_answer(self, *, table: bool) -> None:
        """Set a table apart from what was written before and after it by an empty line."""
        if self._last_was_table is not None and (table or self._last_was_table):
            self.say("")
        self._last_was_table = table

    def begin_line(self) -> None:
        """Forget what was written: a prompt separates it from what follows."""
        self._last_was_table = None

    def raw(self, text: str) -> None:
        """Write a piece of text as it is, without a line's end."""
        self._out.file.write(text)

    def flush(self) -> None:
        """Flush what was written."""
        self._out.file.flush()

    def page(self, lines: Iterable[str]) -> None:
        """Show a result page by page on a terminal that it is too long for; else write it."""
        height = None if self._out.is_dumb_terminal else self.height
        source = iter(lines)
        first = tuple(source if height is None else islice(source, height))
        if height is None or len(first) < height:
            self.say(*first)
            return
        pydoc.pager("\n".join(map(visible, chain(first, source))))

    def remark(self, *lines: str) -> None:
        """Write lines about what was done."""
        if self._kept is not None:
            self._kept.extend(map(visible, lines))
            return
        for line in lines:
            self._remarks.print(Text(_wrap(line, self._remarks), style="dim"))

    def report(self, line: str) -> None:
        """Write a line to a terminal, but not to a file or pipe."""
        if self._remarks.is_terminal:
            self.remark(line)

    def complain(self, error: FacetlogError, *, where: str = "") -> None:
        """Write an error with its place underlined, and `where` before each line of the message."""
        if isinstance(error, QueryError):
            for line in underlined(error):
                self._remarks.print(Text(f"  {line}"))
        for line in error_lines(error):
            message = Text(_wrap(f"{ERROR}{where}{line}", self._remarks))
            message.stylize("red", 0, len(ERROR))
            self._remarks.print(message)


def _wrap(line: str, console: Console) -> str:
    """Break a line that is too long for the terminal between words."""
    if not console.is_terminal or len(line) <= console.width:
        return line
    indent = line[: len(line) - len(line.lstrip())]
    return "\n".join(
        textwrap.wrap(
            line,
            console.width,
            subsequent_indent=f"{indent}    ",
            break_on_hyphens=False,
            break_long_words=False,
        )
    )


def find_fault_place(error: QueryError) -> tuple[int, int]:
    """Return where in its text the fault is; all of the text if the error does not say.

    >>> find_fault_place(QueryError("", text="X is 1/0"))
    (0, 8)
    """
    start = min(max(error.start, 0), len(error.text))
    end = min(max(error.end, start), len(error.text))
    return (start, end) if end > 0 else (0, len(error.text.rstrip()))


def underlined(error: QueryError) -> list[str]:
    """Return the line of the goal in which the fault begins, and a line with ^~~~ under the fault.

    Wide characters count as two cells, and a fault over several lines is underlined in the first.
    All of the goal is at fault if the error does not say where. Empty if it does not hold the goal.

    >>> print("\\n".join(underlined(QueryError("", text="angel(A, B)", start=0, end=5))))
    angel(A, B)
    ^~~~~
    """
    text = error.text
    if not text.strip():
        return []
    start, end = find_fault_place(error)
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
    lines = [_make_visible(line), " " * cell_len(_make_visible(before)) + "^"]
    lines[1] += "~" * (cell_len(_make_visible(fault)) - 1)
    number = text.count("\n", 0, start) + 1
    return lines if "\n" not in text else [f"line {number} of the goal:", *lines]


def _make_visible(text: str) -> str:
    """Replace tabs by spaces, and make other control characters visible."""
    return visible(text.replace("\t", TAB))
