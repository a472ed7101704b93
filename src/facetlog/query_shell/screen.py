"""Where results and remarks go: results to stdout, remarks and errors to stderr."""

import pydoc
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import chain, islice

from rich.console import Console
from rich.text import Text

from facetlog.errors import FacetlogError, QueryError
from facetlog.query_shell.caret import underlined
from facetlog.query_shell.shown_terms import visible
from facetlog.terminal import error_lines

ERROR = "error: "


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
        """Writes lines of a result."""
        if self._kept is not None:
            self._kept.extend(map(visible, lines))
        elif style and self._out.is_terminal:
            for line in lines:
                self._out.print(Text(_wrapped(line, self._out), style=style))
        elif lines:
            # Past rich, whose care for each line would cost more than finding the answers.
            texts = (_wrapped(visible(line), self._out) for line in lines)
            self._out.file.write("\n".join(texts) + "\n")

    @contextmanager
    def keeping(self) -> Iterator[list[str]]:
        """Keeps the lines of results and remarks instead of writing them."""
        kept: list[str] = []
        self._kept = kept
        try:
            yield kept
        finally:
            self._kept = None

    def begin_answer(self, *, table: bool) -> None:
        """Sets a table apart from what was written before and after it by an empty line."""
        if self._last_was_table is not None and (table or self._last_was_table):
            self.say("")
        self._last_was_table = table

    def begin_line(self) -> None:
        """Forgets what was written: a prompt stands between that and what follows."""
        self._last_was_table = None

    def raw(self, text: str) -> None:
        """Writes a piece of text as it is, without a line's end."""
        self._out.file.write(text)

    def flush(self) -> None:
        """Hands on what was written."""
        self._out.file.flush()

    def page(self, lines: Iterable[str]) -> None:
        """Shows a result page by page on a terminal that it is too long for; else writes it."""
        height = None if self._out.is_dumb_terminal else self.height
        source = iter(lines)
        first = tuple(source if height is None else islice(source, height))
        if height is None or len(first) < height:
            self.say(*first)
            return
        pydoc.pager("\n".join(map(visible, chain(first, source))))

    def remark(self, *lines: str) -> None:
        """Writes lines about what was done."""
        if self._kept is not None:
            self._kept.extend(map(visible, lines))
            return
        for line in lines:
            self._remarks.print(Text(_wrapped(line, self._remarks), style="dim"))

    def report(self, line: str) -> None:
        """Writes a line that only somebody who reads along wants."""
        if self._remarks.is_terminal:
            self.remark(line)

    def complain(self, error: FacetlogError, *, where: str = "") -> None:
        """Writes an error, its place underlined; `where` stands before each line of the message."""
        if isinstance(error, QueryError):
            for line in underlined(error):
                self._remarks.print(Text(f"  {line}"))
        for line in error_lines(error):
            message = Text(_wrapped(f"{ERROR}{where}{line}", self._remarks))
            message.stylize("red", 0, len(ERROR))
            self._remarks.print(message)


def _wrapped(line: str, console: Console) -> str:
    """The line, on a terminal that it is too long for broken between words and indented further."""
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
