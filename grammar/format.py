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
from facetlog.grammar.reading.layout import STATEMENT_WORDS, Statement, Token, laid_out
from facetlog.grammar.reading.parse import LARGEST, Readable, parse
from facetlog.grammar.source import Source

WIDTH = 100
"""Characters of a line; what has no place to be broken at may be longer."""

HANGING = "    "
"""Additional indentation of a statement's continuation lines."""

# Words before an opening bracket that it is no argument list of.
_BEFORE_BRACKET = frozenset(
    ("and", "or", "not", "of", "where", "at", "least", "most", "between", "about", "is", "fading")
)

_NO_GAP_BEFORE = frozenset(",:.)°")
_NO_GAP_AFTER = frozenset("(.")
_NO_REASON = ("use", "model", "example")


def canonical(token: Token) -> Token:
    """Return the token as it is written."""
    return token._replace(text="±") if token.text == "+/-" else token


def has_reason(tokens: Sequence[Token]) -> bool:
    """Return whether a statement ends with a text that says why or what it is."""
    last = tokens[-1]
    return last.kind == "string" and len(tokens) > 1 and tokens[0].text not in _NO_REASON


def space_tokens(tokens: Sequence[Token]) -> str:
    """Return the tokens with a blank where people write one.

    >>> from facetlog.grammar.reading.layout import laid_out
    >>> space_tokens(laid_out(Source("", "angle( a ,b )=90deg±-5 %")).statements[0].tokens)
    'angle(a, b) = 90 deg ± -5 %'
    """
    return "".join(gap + token.text for gap, token in zip(_iter_gaps(tokens), tokens, strict=True))


def _iter_gaps(tokens: Sequence[Token]) -> Iterator[str]:
    """Return the space before each token."""
    before: Token | None = None
    leads = False
    for token in tokens:
        bare = (
            before is None
            or leads
            or token.text in _NO_GAP_BEFORE
            or before.text in _NO_GAP_AFTER
            or (token.text == "(" and before.kind == "word" and before.text not in _BEFORE_BRACKET)
        )
        yield "" if bare else " "
        # A minus that no measure stands before turns the sign of what follows.
        leads = token.text == "-" and (before is None or _wants_measure(before))
        before = token


def _wants_measure(token: Token) -> bool:
    if token.kind == "sign":
        return token.text not in (")", "%", "°")
    return token.kind == "word" and token.text in _BEFORE_BRACKET


# ------------------------------------------------------------------- breaks


@dataclass(frozen=True, slots=True)
class _Break:
    """A place where a line may end: before which token; the loosest binding has the least rank."""

    token: int
    rank: tuple[int, int]


_COMMA, _OR, _AND, _TIGHT = range(4)


def break_into_lines(tokens: Sequence[Token], room: int, tail: str) -> Iterator[str]:
    """Iterate over the tokens in lines of at most `room` characters, as far as there are places to
    break.

    Each line ends at the loosest comma, `or` or `and` that it has room for, the last one of these.
    `tail` stands behind the last token.
    """
    pieces = [gap + token.text for gap, token in zip(_iter_gaps(tokens), tokens, strict=True)]
    places = [0]
    for piece in pieces:
        places.append(places[-1] + len(piece))
    breaks = list(_iter_breaks(tokens))
    start, at, indent = 0, 0, ""
    while True:
        left = places[-1] - places[start] + len(tail)
        if left <= room - len(indent) or at >= len(breaks):
            break
        chosen = at
        for i in range(at + 1, len(breaks)):
            if places[breaks[i].token] - places[start] > room - len(indent):
                break
            if breaks[i].rank <= breaks[chosen].rank:
                chosen = i
        end = breaks[chosen].token
        yield indent + "".join(pieces[start:end]).strip()
        start, at, indent = end, chosen + 1, HANGING
    yield indent + "".join(pieces[start:]).strip() + tail


def _iter_breaks(tokens: Sequence[Token]) -> Iterator[_Break]:
    """Iterate over the places where a line may end and the statement go on: after commas, before
    `and`, `or`.
    """
    # For each open bracket: the number of `between`s whose `and` is still to come.
    pending = [0]
    for i, token in enumerate(tokens):
        depth = len(pending)
        if token.text == "(":
            pending.append(0)
        elif token.text == ")":
            pending.pop()
        elif token.text == "between":
            pending[-1] += 1
        elif token.text == "and" and pending[-1]:
            pending[-1] -= 1
        elif token.text in ("and", "or") and i > 0:
            yield _Break(i, (depth, _AND if token.text == "and" else _OR))
        elif token.text == "," and _can_start_line(tokens, i + 1):
            yield _Break(i + 1, (depth, _TIGHT if _is_name_list(tokens, i) else _COMMA))


def _can_start_line(tokens: Sequence[Token], i: int) -> bool:
    """Return whether a line may begin with this token: not if it would begin a statement."""
    if i + 1 >= len(tokens):
        return i < len(tokens) and tokens[i].text not in STATEMENT_WORDS
    return tokens[i].text not in STATEMENT_WORDS and tokens[i + 1].text != ":"


def _is_name_list(tokens: Sequence[Token], comma: int) -> bool:
    """Return whether a comma stands in a list of names before `:`, `of` or `where`."""
    i = comma
    while i + 2 < len(tokens) and tokens[i].text == "," and tokens[i + 1].kind == "word":
        i += 2
    return tokens[i].text in (":", "of", "where")


# ----------------------------------------------------------------- comments


def iter_lines_with_comments(
    source: Source, tokens: Sequence[Token], comments: Sequence[s.Comment]
) -> Iterator[str]:
    """Iterate over the lines of a statement with comments in it, which keep their places."""
    lines: dict[int, list[Token]] = {}
    for token in tokens:
        lines.setdefault(source.get_line_and_column(token.start)[0], []).append(token)
    behind = {source.get_line_and_column(c.span.start)[0]: c.text for c in comments}
    indent = ""
    for number in sorted(lines.keys() | behind.keys()):
        texts = [space_tokens(lines.get(number, [])), behind.get(number, "")]
        yield indent + "  ".join(text for text in texts if text)
        indent = HANGING


INDENT = "  "
"""Of what stands inside a model."""

APART = "  "
"""What stands before a reason or a comment at the end of a line, at least."""

_CARRIAGE_RETURNS = re.compile(r"\r+(?=\n|\Z)")


def formatted(source: Source) -> str:
    """Return the text of a model file in canonical layout; line ends are those of its first line.

    Its syntax tree is the same, spans apart. A file too large to be parsed comes back as it is.
    """
    if len(source.text) > LARGEST:
        return source.text
    first_end = source.text.find("\n")
    line_end = "\r\n" if source.text[max(first_end - 1, 0) : first_end] == "\r" else "\n"
    plain = Source(source.name, _CARRIAGE_RETURNS.sub("", source.text))
    lines: list[str] = []
    for block in _align(list(_iter_blocks(plain))):
        if lines and (block.apart or block.blank_before):
            lines.append("")
        lines.extend(block.iter_whole_lines())
    return "".join(f"{line}\n" for line in lines).replace("\n", line_end)


def differences(before: str, after: str, name: str) -> str:
    """Return a unified diff of two texts of a file, empty if they are the same."""
    found = difflib.unified_diff(
        _keep_line_ends(before), _keep_line_ends(after), name, f"{name} (formatted)"
    )
    return "".join(found)


def _keep_line_ends(text: str) -> list[str]:
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

    def iter_whole_lines(self) -> Iterator[str]:
        """Iterate over the lines as they stand in the file."""
        *first, last = self.lines
        yield from (self.indent + line for line in first)
        ends = (last, self.reason, self.comment)
        yield self.indent + APART.join(text for text in ends if text)


def _align(blocks: Sequence[_Block]) -> Iterator[_Block]:
    """Iterate over the blocks, with the reasons of each run of lines in one column if all of them
    fit.
    """
    run: list[_Block] = []
    for block in blocks:
        joins = block.reason and not block.blank_before and not block.apart
        if run and not (joins and block.indent == run[0].indent):
            yield from _align_run(run)
            run = []
        if block.reason:
            run.append(block)
        else:
            yield block
    yield from _align_run(run)


def _align_run(run: Sequence[_Block]) -> Iterable[_Block]:
    if not run:
        return run
    column = max(len(block.lines[0]) for block in run)
    longest = max(len(block.reason) for block in run)
    if len(run[0].indent) + column + len(APART) + longest > WIDTH:
        return run
    return [replace(block, lines=(block.lines[0].ljust(column),)) for block in run]


# ------------------------------------------------------------------- blocks


def _iter_blocks(source: Source) -> Iterator[_Block]:
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
        while at < len(comments) and _is_at(source, comments[at], statement):
            at += 1
        own = comments[own_from:at]
        opens = statement.tokens[0].text == "model"
        begun = False
        for block in _iter_comments(source, between, end, inside, before_model=opens):
            yield block
            begun = begun or block.apart
        if between:
            end = between[-1].span.end
        # Comments before the first model keep the lines that were left blank round them.
        apart = opens and not begun and (inside or not between)
        inside = inside or opens
        indent = INDENT if inside and not opens else ""
        blank = _has_blank(source, end, statement.span.start)
        block = _format_statement(source, statement, own, indent, readable.has(statement.span))
        yield replace(block, blank_before=blank, apart=apart)
        end = max(statement.span.end, own[-1].span.end if own else 0)
    yield from _iter_comments(source, comments[at:], end, inside, before_model=True)


def _is_at(source: Source, comment: s.Comment, statement: Statement) -> bool:
    """Return whether a comment stands within a statement, or behind it on its last line."""
    end = statement.span.end
    return comment.span.start < end or "\n" not in source.text[end : comment.span.start]


def _has_blank(source: Source, end: int, start: int) -> bool:
    """Return whether a line was left blank between two places."""
    return source.text.count("\n", end, start) > 1


def _iter_comments(
    source: Source, comments: Iterable[s.Comment], end: int, inside: bool, *, before_model: bool
) -> Iterator[_Block]:
    """Iterate over comments between statements.

    Behind the last statement of a model, a comment that is not indented is about the next model,
    and so are those after it.
    """
    for comment in comments:
        begins = False
        if inside and before_model:
            begins = source.get_line_and_column(comment.span.start)[1] == 1
            inside = not begins
        blank = _has_blank(source, end, comment.span.start)
        yield _Block((comment.text,), INDENT if inside else "", blank, apart=begins)
        end = comment.span.end


def _format_statement(
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
        lines = tuple(iter_lines_with_comments(source, tokens, inner))
        if _is_one("\n".join(lines), len(tokens)):
            return _Block(lines, indent, False, comment=comment)
    elif readable:
        room = WIDTH - len(indent)
        body, reason = (tokens[:-1], tokens[-1].text) if has_reason(tokens) else (tokens, "")
        line = space_tokens(body)
        if len(line) + (len(APART + reason) if reason else 0) <= room:
            return _Block((line,), indent, False, reason, comment)
        lines = tuple(break_into_lines(body, room, APART + reason if reason else ""))
        return _Block(lines, indent, False, comment=comment)
    start = source.text.rfind("\n", 0, statement.span.start) + 1
    end = statement.span.end if behind is None else behind.span.end
    return _Block((source.text[start:end],), "", False)


def _is_one(text: str, tokens: int) -> bool:
    """Return whether a text is one statement of so many tokens."""
    statements = laid_out(Source("", text)).statements
    return len(statements) == 1 and len(statements[0].tokens) == tokens
