"""The rules of model.lark as lines that people read, with the comments that stand above them."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

from lark import Lark, Token, Tree

from facetlog.grammar.reading.parse import GRAMMAR

__all__ = ["Rule", "Section", "Terminal", "syntax_sections", "syntax_terminals"]

Node = Tree[Token] | Token | None


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule: what it is called, and the ways in which it can be written.

    Words and signs stand as they are written, `<name>` is another rule, a word in capital letters a
    terminal, `[...]` may be left out, and `X, ...` is one X or several with commas between them.
    """

    name: str
    ways: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Section:
    """Rules that stand together, under a title, with what the grammar says of them."""

    title: str
    comments: tuple[str, ...]
    rules: tuple[Rule, ...]


@dataclass(frozen=True, slots=True)
class Terminal:
    """A word that the author chooses, a number or a text: its name and regular expression."""

    name: str
    pattern: str


FIRST_TITLE = "Statements"
"""The title of the rules before the first title in the grammar."""

_COMMENT = re.compile(r"//\s?(.*)")


def syntax_sections(text: str | None = None) -> tuple[Section, ...]:
    """The rules of the language by sections, in the order of the grammar.

    A comment of one line without a full stop is the title of what follows.

    >>> text = 'start: a\\n// Ways\\n\\n// Both are right.\\na: "x" NAME | "y"\\n'
    >>> syntax_sections(text)[1].rules
    (Rule(name='a', ways=('x NAME', 'y')),)
    """
    text = GRAMMAR.read_text(encoding="utf-8") if text is None else text
    grammar = _Grammar(text)
    sections = [Section(FIRST_TITLE, (), ())]
    pieces: list[tuple[int, Rule | str]] = [*grammar.rules(), *_comments(text)]
    for line, found in sorted(pieces, key=lambda pair: pair[0]):
        last = sections[-1]
        if isinstance(found, Rule):
            sections[-1] = replace(last, rules=(*last.rules, found))
        elif line < grammar.first_line:
            continue  # The head of the file is for those who change the grammar.
        elif "\n" in found or found.endswith("."):
            sections[-1] = replace(last, comments=(*last.comments, " ".join(found.split("\n"))))
        else:
            sections.append(Section(found, (), ()))
    return tuple(sections)


def syntax_terminals() -> tuple[Terminal, ...]:
    """The terminals that are no fixed words."""
    grammar = _Grammar(GRAMMAR.read_text(encoding="utf-8"))
    return tuple(
        Terminal(str(name), pattern)
        for name, body in grammar.terminals.items()
        if (pattern := _pattern(body)) is not None
    )


def _comments(text: str) -> Iterator[tuple[int, str]]:
    """Each comment, with the number of its first line; lines with nothing in between are one."""
    block: list[str] = []
    for number, line in enumerate([*text.split("\n"), ""], start=1):
        match = _COMMENT.match(line)
        if match is not None and match[1]:
            block.append(match[1])
        elif block:
            yield number - len(block), "\n".join(block)
            block = []


@cache
def _reader() -> Lark:
    """Reads grammars: by the grammar of grammars that comes with Lark."""
    return Lark.open_from_package(
        "lark", "lark.lark", ("grammars",), parser="lalr", maybe_placeholders=False
    )


class _Grammar:
    """The rules and terminals of a grammar, and how their parts are written."""

    def __init__(self, text: str) -> None:
        self.bodies: dict[str, tuple[int, Node]] = {}
        self.terminals: dict[str, Node] = {}
        for item in _reader().parse(text + "\n").children:
            if isinstance(item, Tree) and item.data in ("rule", "token"):
                first = item.children[0]
                assert isinstance(first, Token)  # noqa: S101  the grammar of grammars says so
                if item.data == "token":
                    self.terminals[str(first)] = item.children[-1]
                else:
                    self.bodies[first.lstrip("!?")] = first.line or 0, item.children[-1]
        self.first_line = min(line for line, _ in self.bodies.values())
        # A rule that only stands for an inner one is that one.
        self.same = {
            str(name): rule
            for rule, (_, body) in self.bodies.items()
            if (name := _single_name(body)) is not None and name.startswith("_")
        }

    def rules(self) -> Iterator[tuple[int, Rule]]:
        """The rules with their lines, but for the first, which says where to begin."""
        for name, (line, body) in self.bodies.items():
            if name == "start" or name in self.same:
                continue
            inner = _single_name(body)
            if inner in self.same and self.same[inner] == name:
                line, body = line, self.bodies[inner][1]
            yield line, Rule(self._shown(name), tuple(map(self._way, _alternatives(body))))

    def _shown(self, name: str) -> str:
        return self.same.get(name, name).lstrip("_").replace("_", " ")

    def _way(self, node: Node) -> str:
        return _joined(self._words(node))

    def _words(self, node: Node) -> list[str]:
        """The words and signs of a piece of a rule."""
        if not isinstance(node, Tree):
            return []
        match node.data:
            case "name":
                return self._name(str(node.children[0]))
            case "literal":
                return [_literal(str(node.children[0]))]
            case "maybe":
                return ["[", *self._choice(node.children), "]"]
            case "expr":
                repeated, sign = node.children[0], node.children[1]
                return ["{", *self._choice([repeated]), "}", str(sign)]
            case "expansion":
                return self._sequence(node.children)
            case "alias":
                return self._words(node.children[0])
            case "expansions":
                return ["{", *self._choice([node]), "}"]
        raise ValueError(f"{node.data} has no way to be shown")

    def _choice(self, children: Sequence[Node]) -> list[str]:
        found: list[str] = []
        for number, way in enumerate(w for child in children for w in _alternatives(child)):
            found += ["|"] * (number > 0) + self._words(way)
        return found

    def _sequence(self, children: Sequence[Node]) -> list[str]:
        found: list[str] = []
        for number, child in enumerate(children):
            repeated = _after_commas(child)
            if repeated is not None and number and repeated == children[number - 1]:
                found += [",", "..."]
            else:
                words = self._words(child)
                found += ["{", *words, "}"] if _is_choice(words, child) else words
        return found

    def _name(self, name: str) -> list[str]:
        if name in self.bodies:
            return [f"<{self._shown(name)}>"]
        body = self.terminals.get(name)
        literals = [_fixed(way) for way in _alternatives(body)]
        if body is None or None in literals:
            return [name]
        if name.startswith("_"):  # Of a sign that can be written in two ways the first is shown.
            return [str(literals[0])]
        return " | ".join(map(str, literals)).split()


def _is_choice(words: Sequence[str], node: Node) -> bool:
    """Whether a name stands for several words, of which one is to be written."""
    return "|" in words and isinstance(node, Tree) and node.data == "name"


def _alternatives(node: Node) -> tuple[Node, ...]:
    if isinstance(node, Tree) and node.data == "expansions":
        return tuple(node.children)
    return (node,)


def _single(node: Node) -> Node:
    """What a piece consists of, if of one thing only."""
    while isinstance(node, Tree) and node.data in ("alias", "expansion"):
        inner = [child for child in node.children if isinstance(child, Tree)]
        if len(inner) != 1:
            return None
        node = inner[0]
    return node


def _single_name(node: Node) -> str | None:
    found = _single(node)
    return str(found.children[0]) if isinstance(found, Tree) and found.data == "name" else None


def _fixed(node: Node) -> str | None:
    found = _single(node)
    if not isinstance(found, Tree) or found.data != "literal":
        return None
    text = str(found.children[0])
    return _literal(text) if text.startswith('"') else None


def _pattern(node: Node) -> str | None:
    """The regular expression that a terminal is, if it is one."""
    found = _single(node)
    if not isinstance(found, Tree) or found.data != "literal":
        return None
    text = str(found.children[0])
    return text.strip("/") if text.startswith("/") else None


def _after_commas(node: Node) -> Node:
    """X, of a piece `("," X)*`."""
    if not isinstance(node, Tree) or node.data != "expr" or str(node.children[1]) != "*":
        return None
    group = node.children[0]
    while isinstance(group, Tree) and group.data == "alias":
        group = group.children[0]
    if not isinstance(group, Tree) or len(group.children) != 2:
        return None
    comma, repeated = group.children
    return repeated if _fixed(comma) == "," else None


def _literal(text: str) -> str:
    return text[1:-1].replace('\\"', '"')


_NO_BLANK_BEFORE = frozenset(",:.)]}")
_NO_BLANK_AFTER = frozenset("([{.")


def _joined(words: Sequence[str]) -> str:
    """Words and signs with blanks as people write them."""
    text = ""
    for before, word in zip(["", *words], words, strict=False):
        close = (
            not text
            or word in _NO_BLANK_BEFORE
            or before in _NO_BLANK_AFTER
            or (word == "(" and before.isupper())
            or (before == "}" and word in "*+?")
        )
        text += word if close else f" {word}"
    return text
