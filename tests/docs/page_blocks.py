"""The blocks of a page that can be tried: models, Prolog, Python, and commands with their output.

A block says by the words behind its three backquotes what it is:

- `model FILE` is a whole file, `model FILE +` lines to be added to it, and `model FILE + mistaken`
  lines that are there only until the commands that follow have been run;
- `model` alone are lines of a model that has the parts of the comment before the block,
  `<!-- with: face top -->`;
- `prolog FILE` is a file, `python` is run; `python slow` takes long, or needs what took long;
- `console` are commands after `$`, each with what it prints; `console slow` takes long.

In an output a line of `…` stands for any lines, and `…` in a line for any text.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["Block", "Command", "blocks", "commands", "matches"]

_FENCE = re.compile(
    r"(?:^<!-- with: (?P<with>[^>]*?) -->\n+)?^```(?P<info>[^\n`]*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class Block:
    """A block: the line that it begins in, its words, its text, and the parts it speaks of."""

    line: int
    info: tuple[str, ...]
    text: str
    parts: str

    @property
    def language(self) -> str:
        """Its first word; empty if it has none."""
        return self.info[0] if self.info else ""

    @property
    def file(self) -> str | None:
        """The file that it is, or is added to."""
        named = [word for word in self.info[1:] if "." in word]
        return named[0] if named else None


@dataclass(frozen=True, slots=True)
class Command:
    """A command of a console block, and what the page says that it prints."""

    line: int
    words: str
    output: str
    slow: bool


def blocks(page: str) -> Iterator[Block]:
    """The blocks of a page in their order."""
    for match in _FENCE.finditer(page):
        line = page.count("\n", 0, match.start("text")) + 1
        yield Block(line, tuple(match["info"].split()), match["text"], match["with"] or "")


def commands(block: Block) -> Iterator[Command]:
    """The commands of a console block; ValueError if text stands before the first."""
    pieces = re.split(r"^\$ (.*)\n", block.text, flags=re.MULTILINE)
    if pieces[0]:
        raise ValueError(f"line {block.line}: a console block begins with a command")
    line = block.line
    for words, output in zip(pieces[1::2], pieces[2::2], strict=True):
        yield Command(line, words, output, "slow" in block.info)
        line += 1 + output.count("\n")


def matches(wanted: str, got: str) -> bool:
    """Whether an output is what a page says, which may leave out lines and texts by `…`.

    >>> matches("a\\n…\\nb … c\\n", "a\\nx\\ny\\nb 1 c\\n")
    True
    """
    pattern = []
    for line in wanted.rstrip("\n").split("\n"):
        if line.strip() == "…":
            pattern.append(r"(?:[^\n]*\n)*?")
        else:
            pattern.append(".*".join(map(re.escape, line.split("…"))) + r"\n")
    return re.fullmatch("".join(pattern), got.rstrip("\n") + "\n") is not None
