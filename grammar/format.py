"""The canonical layout of a model file.

Only blanks and line ends change, and `+/-` becomes `±`: no word, text or comment is touched, and
what cannot be read stays exactly as it stands. The layout follows from the tokens, from which lines
were blank, and from where comments stood; so laying out twice changes nothing more.
"""

import difflib
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from facetlog.grammar import syntax as s
from facetlog.grammar.reading.layout import Statement, laid_out
from facetlog.grammar.reading.parse import LARGEST, parse
from facetlog.grammar.reading.readable import Readable
from facetlog.grammar.source import Source
from facetlog.grammar.statement_lines import (
    WIDTH,
    canonical,
    has_reason,
    kept_lines,
    one_line,
    over_lines,
)

__all__ = ["differences", "formatted"]

INDENT = "  "
"""Of what stands inside a model."""

APART = "  "
"""What stands before a reason or a comment at the end of a line, at least."""

_CARRIAGE_RETURNS = re.compile(r"\r+(?=\n|\Z)")


def formatted(source: Source) -> str:
    """The text of a model file in canonical layout; line ends are those of its first line.

    Its syntax tree is the same, spans apart. A file too large to be parsed comes back as it is.
    """
    if len(source.text) > LARGEST:
        return source.text
    first_end = source.text.find("\n")
    line_end = "\r\n" if source.text[max(first_end - 1, 0) : first_end] == "\r" else "\n"
    plain = Source(source.name, _CARRIAGE_RETURNS.sub("", source.text))
    lines: list[str] = []
    for block in _aligned(list(_blocks(plain))):
        if lines and (block.apart or block.blank_before):
            lines.append("")
        lines.extend(block.whole_lines())
    return "".join(f"{line}\n" for line in lines).replace("\n", line_end)


def differences(before: str, after: str, name: str) -> str:
    """A unified diff of two texts of a file, empty if they are the same."""
    found = difflib.unified_diff(_with_ends(before), _with_ends(after), name, f"{name} (formatted)")
    return "".join(found)


def _with_ends(text: str) -> list[str]:
    lines = [line + "\n" for line in text.split("\n")]
    if lines[-1] == "\n":
        return lines[:-1]
    lines[-1] += "\\ No newline at end of file\n"
    return lines


@dataclass(frozen=True, slots=True)
class _Block:
    """A statement, or a comment that stands alone, in lines without their indentation.

    `reason` is apart from the lines as long as it may move into a column with those of neighbours.
    `apart`: a model begins here, one line is left blank.
    """

    lines: tuple[str, ...]
    indent: str
    blank_before: bool
    reason: str = ""
    comment: str = ""
    apart: bool = False

    def whole_lines(self) -> Iterator[str]:
        """The lines as they stand in the file."""
        *first, last = self.lines
        yield from (self.indent + line for line in first)
        ends = (last, self.reason, self.comment)
        yield self.indent + APART.join(text for text in ends if text)


def _aligned(blocks: Sequence[_Block]) -> Iterator[_Block]:
    """The blocks, with the reasons of each run of lines in one column if all of them fit."""
    run: list[_Block] = []
    for block in blocks:
        joins = block.reason and not block.blank_before and not block.apart
        if run and not (joins and block.indent == run[0].indent):
            yield from _in_column(run)
            run = []
        if block.reason:
            run.append(block)
        else:
            yield block
    yield from _in_column(run)


def _in_column(run: Sequence[_Block]) -> Iterable[_Block]:
    if not run:
        return run
    column = max(len(block.lines[0]) for block in run)
    longest = max(len(block.reason) for block in run)
    if len(run[0].indent) + column + len(APART) + longest > WIDTH:
        return run
    return [replace(block, lines=(block.lines[0].ljust(column),)) for block in run]


# ------------------------------------------------------------------- blocks


def _blocks(source: Source) -> Iterator[_Block]:
    layout = laid_out(source)
    readable = Readable(parse(source).file)
    comments = list(layout.comments)
    at, end, inside = 0, 0, False
    for statement in layout.statements:
        first = at
        while at < len(comments) and comments[at].span.start < statement.span.start:
            at += 1
        between = comments[first:at]
        own_from = at
        while at < len(comments) and _belongs(source, comments[at], statement):
            at += 1
        own = comments[own_from:at]
        opens = statement.tokens[0].text == "model"
        begun = False
        for block in _comments(source, between, end, inside, before_model=opens):
            yield block
            begun = begun or block.apart
        if between:
            end = between[-1].span.end
        # Comments before the first model keep the lines that were left blank round them.
        apart = opens and not begun and (inside or not between)
        inside = inside or opens
        indent = INDENT if inside and not opens else ""
        blank = _blank(source, end, statement.span.start)
        block = _statement(source, statement, own, indent, readable.has(statement.span))
        yield replace(block, blank_before=blank, apart=apart)
        end = max(statement.span.end, own[-1].span.end if own else 0)
    yield from _comments(source, comments[at:], end, inside, before_model=True)


def _belongs(source: Source, comment: s.Comment, statement: Statement) -> bool:
    """Whether a comment stands within a statement, or behind it on its last line."""
    end = statement.span.end
    return comment.span.start < end or "\n" not in source.text[end : comment.span.start]


def _blank(source: Source, end: int, start: int) -> bool:
    """Whether a line was left blank between two places."""
    return source.text.count("\n", end, start) > 1


def _comments(
    source: Source, comments: Iterable[s.Comment], end: int, inside: bool, *, before_model: bool
) -> Iterator[_Block]:
    """Comments between statements.

    Behind the last statement of a model, a comment that is not indented is about the next model,
    and so are those after it.
    """
    for comment in comments:
        begins = False
        if inside and before_model:
            begins = source.line_and_column(comment.span.start)[1] == 1
            inside = not begins
        blank = _blank(source, end, comment.span.start)
        yield _Block((comment.text,), INDENT if inside else "", blank, apart=begins)
        end = comment.span.end


def _statement(
    source: Source,
    statement: Statement,
    comments: Sequence[s.Comment],
    indent: str,
    readable: bool,
) -> _Block:
    inner = [c for c in comments if c.span.start < statement.span.end]
    behind = comments[-1] if len(comments) > len(inner) else None
    comment = "" if behind is None else behind.text
    tokens = tuple(canonical(token) for token in statement.tokens)
    if readable and inner:
        lines = tuple(kept_lines(source, tokens, inner))
        if _is_one("\n".join(lines), len(tokens)):
            return _Block(lines, indent, False, comment=comment)
    elif readable:
        room = WIDTH - len(indent)
        body, reason = (tokens[:-1], tokens[-1].text) if has_reason(tokens) else (tokens, "")
        line = one_line(body)
        if len(line) + (len(APART + reason) if reason else 0) <= room:
            return _Block((line,), indent, False, reason, comment)
        lines = tuple(over_lines(body, room, APART + reason if reason else ""))
        return _Block(lines, indent, False, comment=comment)
    start = source.text.rfind("\n", 0, statement.span.start) + 1
    end = statement.span.end if behind is None else behind.span.end
    return _Block((source.text[start:end],), "", False)


def _is_one(text: str, tokens: int) -> bool:
    """Whether a text is one statement of so many tokens."""
    statements = laid_out(Source("", text)).statements
    return len(statements) == 1 and len(statements[0].tokens) == tokens
