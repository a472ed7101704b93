"""Words of the user's own: what a Prolog file that a model uses says of them.

The file declares each word that models may use by a clause

    word(lean(face), angle, "how far it leans from upright").

and defines it as any rule file does: a condition by means/2, a measure by measured/4. Only these
declarations, and the models of the file, are read here; the knowledge base checks and runs the
rest.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from facetlog.grammar.faults import Fault, said
from facetlog.grammar.source import Source, Span
from facetlog.grammar.vocabulary import VOCABULARY, Gives, Kind, Word

_WORD = re.compile(
    r"^word\(\s*(?P<name>[a-z]\w*)\((?P<kinds>[^()]*)\)\s*,\s*(?P<gives>\w+)\s*,"
    r'\s*"(?P<meaning>[^"]*)"\s*\)\s*\.',
    re.MULTILINE,
)
_DECLARES = re.compile(r"^word\(", re.MULTILINE)
_MODEL = re.compile(
    r'^model\(\s*(?P<name>[a-z]\w*)\s*,\s*"[^"]*"\s*,\s*\[(?P<roles>[^\]]*)\]', re.MULTILINE
)


# Clauses that compiled models have themselves; of a model in Prolog only those that name it.
_MADE = re.compile(
    r"^(likely|distant|members|group|written|specialises|rather_than)\("
    r"|^(?=(condition|candidate|model|size)\(\s*[A-Z_])",
    re.MULTILINE,
)
_COMMENT = re.compile(
    r"""/\*.*?(?:\*/|\Z)|%[^\n]*|"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'""", re.DOTALL
)


def _blank_comment(found: re.Match[str]) -> str:
    """Replace a comment by blanks, so that places stay; keep a text as it is."""
    return re.sub(r"[^\n]", " ", found[0]) if found[0][0] in "/%" else found[0]


@dataclass(frozen=True, slots=True)
class OwnWords:
    """The words and models (name to roles) of a Prolog file, and faulty declarations."""

    source: Source
    words: tuple[Word, ...]
    models: Mapping[str, tuple[str, ...]]
    faults: tuple[Fault, ...]


def own_words(source: Source) -> OwnWords:
    """Read the words that a Prolog file adds to the vocabulary."""
    words: list[Word] = []
    faults: list[Fault] = []
    text = _COMMENT.sub(_blank_comment, source.text)
    read = {match.start(): match for match in _WORD.finditer(text)}
    for start in (match.start() for match in _DECLARES.finditer(text)):
        match = read.get(start)
        if match is None:
            hint = 'write word(lean(face), angle, "what it is").'
            span = Span(start, start + 4)
            faults.append(Fault("own-word", "this is no word/3", source, span, hint))
            continue
        word = _read_word(source, match, faults)
        if word is not None:
            words.append(word)
    for match in _MADE.finditer(text):
        hint = "it would stand beside the clauses that models become: choose another name"
        name = match[1] or match[2]
        span = Span(match.start(), match.start() + len(name))
        faults.append(Fault("own-word", f"`{name}` is not for words", source, span, hint))
    models = {
        match["name"]: tuple(role.strip() for role in match["roles"].split(",") if role.strip())
        for match in _MODEL.finditer(text)
    }
    return OwnWords(source, tuple(words), models, tuple(faults))


def _read_word(source: Source, match: re.Match[str], faults: list[Fault]) -> Word | None:
    def fault(group: str, message: str, hint: str) -> None:
        span = Span(match.start(group), match.end(group))
        faults.append(Fault("own-word", message, source, span, hint))

    name = match["name"]
    if name in VOCABULARY:
        fault("name", f"`{name}` is a word of the vocabulary and cannot be redefined", "")
        return None
    if match["gives"] not in set(Gives):
        hint = said(match["gives"], Gives) or f"one of {', '.join(Gives)}"
        fault("gives", f"no word gives a `{match['gives']}`", hint)
        return None
    arguments = []
    for kind in (kind.strip() for kind in match["kinds"].split(",")):
        alternatives = kind.split("/")
        if not all(one in set(Kind) for one in alternatives):
            fault("kinds", f"`{kind}` is no kind", f"one of {', '.join(Kind)}, or face/edge")
            return None
        arguments.append(frozenset(map(Kind, alternatives)))
    gives = Gives(match["gives"])
    span = Span(match.start("name"), match.end("name"))
    return Word(name, tuple(arguments), gives, match["meaning"], source=source, span=span)
