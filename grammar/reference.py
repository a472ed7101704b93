"""The reference of the language as Markdown, made from what the program itself reads.

The syntax comes from model.lark, words and units from their tables, numbers from the constants that
the compiler uses. What the language does not know, the things that examples build, is handed in.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from facetlog.grammar.checking.model import MOST_PARTS, MOST_SINGULAR
from facetlog.grammar.compiling.lines import WEIGHTS
from facetlog.grammar.fading import ABOUT, FADING, SHARE
from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.library import MOST_FILES
from facetlog.grammar.reading.layout import DEEPEST, STATEMENT_WORDS
from facetlog.grammar.reading.parse import LARGEST, LONGEST
from facetlog.grammar.syntax_lines import Rule, syntax_sections, syntax_terminals
from facetlog.grammar.units import UNITS, Dimension, Unit
from facetlog.grammar.vocabulary import VOCABULARY, Gives, Kinds, Word

__all__ = ["TERMINALS", "BuiltThing", "reference"]

TERMINALS: Mapping[str, str] = {
    "PIECE": "`piece`, `board`, `bar`, `block` or `opening`, where names follow, and then `where`,"
    " a text, `:` or nothing; elsewhere these are names like others",
    "NAME": "a word of letters, digits and `_` that does not begin with a digit",
    "NUMBER": "`3`, `0.5` or `1e-3`",
    "STRING": 'a text in `"…"`, on one line',
}
"""What the terminals of the grammar are, for those who do not read regular expressions."""

WIDTH = 100
"""Characters of a line of syntax."""


@dataclass(frozen=True, slots=True)
class BuiltThing:
    """A thing that examples can build; its sizes have a default in metres, degrees or pieces."""

    name: str
    meaning: str
    sizes: tuple[tuple[str, Dimension, float], ...]


def reference(things: Iterable[BuiltThing]) -> str:
    """The reference in Markdown, its headings of the third level.

    The things are those of `example ... of ...`.
    """
    sections = (
        _syntax(),
        _vocabulary(),
        _units(),
        _numbers(),
        _things(things),
        _faults(),
    )
    return "\n\n".join("\n".join(lines) for lines in sections) + "\n"


# ------------------------------------------------------------------- syntax


def _syntax() -> Iterator[str]:
    yield "### Syntax"
    yield ""
    yield (
        "Words and signs are written as they stand. `<conditions>` is what the line of that name"
        " says; `[…]` may be left out; `|` parts what can be written instead; `X, ...` is one X or"
        " several with commas between them."
    )
    yield ""
    for terminal in syntax_terminals():
        yield f"- `{terminal.name}`: {TERMINALS[terminal.name]}."
    yield ""
    reserved = ", ".join(f"`{word}`" for word in sorted(STATEMENT_WORDS))
    yield f"A statement begins with {reserved}, or it is a line; nothing may be called so."
    for section in syntax_sections():
        yield ""
        yield f"#### {section.title}"
        for comment in section.comments:
            yield ""
            yield comment
        yield ""
        yield "```"
        for rule in section.rules:
            yield from _rule(rule)
        yield "```"


def _rule(rule: Rule) -> Iterator[str]:
    """A rule in one line if it has room there, or a line for each way."""
    line = f"<{rule.name}>: {' | '.join(rule.ways)}"
    short = all(" " not in way or len(rule.ways) == 1 for way in rule.ways)
    if len(line) <= WIDTH and short:
        yield line
    else:
        yield f"<{rule.name}>:"
        yield from (f"    {way}" for way in rule.ways)


# --------------------------------------------------------------- vocabulary

_LETTERS = "ABC"


def _vocabulary() -> Iterator[str]:
    yield "### Words: conditions"
    yield ""
    conditions = [word for word in VOCABULARY.values() if word.is_condition]
    yield from _table(
        ("write", "of", "which says", "unknown when"),
        (
            (_written(word), _of(word), word.meaning, word.unknown_when or "–")
            for word in conditions
        ),
    )
    yield ""
    yield (
        "A condition of one is also written `level(A)`, one of two `adjoins(A, B)`. `not` and"
        " `is not` turn it round. A model of objects may say `A is table`, and `is` takes a"
        " definition of one parameter as well."
    )
    yield ""
    yield "### Words: measures"
    yield ""
    yield from _table(
        ("write", "of", "gives", "which is", "unknown when"),
        (
            (_written(word), _of(word), _gives(word), word.meaning, word.unknown_when or "–")
            for word in VOCABULARY.values()
            if not word.is_condition
        ),
    )
    yield ""
    yield (
        "`count(SET)` is how many members a set has; `sum`, `mean`, `lowest` and `highest` `of` a"
        " measure of its members, and `smallest gap` and `largest gap` `of` a set of things, are of"
        " the kind of what they are made of."
    )


def _written(word: Word) -> str:
    letters = list(_LETTERS[: len(word.arguments)])
    if word.many:
        letters += ["B", "C", "..."]
    if word.number_last is not None:
        letters.append(_SOME[word.number_last])
    if word.is_condition and len(letters) == len(word.arguments) == 1:
        return f"`{letters[0]} is {word.name}`"
    if word.is_condition and len(letters) == len(word.arguments) == 2:
        return f"`{letters[0]} {word.name} {letters[1]}`"
    return f"`{word.name}({', '.join(letters)})`"


_SOME = {
    Gives.ANGLE: "15 deg",
    Gives.LENGTH: "5 cm",
    Gives.AREA: "2 cm2",
    Gives.RATIO: "5 %",
    Gives.COUNT: "3",
}
"""An amount of each kind, as it is written."""


def _of(word: Word) -> str:
    kinds = [_kinds(argument) for argument in word.arguments]
    if word.many:
        return f"{kinds[0]}s"
    if len(kinds) == 1:
        return kinds[0]
    either_way = ", either way round" if word.symmetric else ""
    if word.alike:
        return f"{', or '.join(f'two {kind}s' for kind in sorted(word.arguments[0]))}{either_way}"
    return (
        f"A: {kinds[0]}, B: {kinds[1]}" if kinds[0] != kinds[1] else f"two {kinds[0]}s{either_way}"
    )


def _kinds(kinds: Kinds) -> str:
    *others, last = sorted(kind.value for kind in kinds)
    return f"{', '.join(others)} or {last}" if others else last


def _gives(word: Word) -> str:
    """What a measure is of, and between which values, as far as these are bounded."""
    unit = {Gives.ANGLE: "°"}.get(word.gives, "")
    match word.low, word.high:
        case (float(low), float(high)):
            return f"{word.gives}, {low:g}{unit} to {high:g}{unit}"
        case (float(low), None) if low > 0:
            return f"{word.gives}, from {low:g}{unit} on"
        case (None, None):
            return f"{word.gives}, with its sign"
    return str(word.gives)


# ------------------------------------------------------- units and constants


def _units() -> Iterator[str]:
    yield "### Units"
    yield ""
    dimensions: dict[Dimension, list[Unit]] = {}
    for unit in UNITS.values():
        dimensions.setdefault(unit.dimension, []).append(unit)
    yield from _table(
        ("of", "units", "in the compiled program"),
        (
            (
                dimension.value,
                ", ".join(f"`{unit.name}`" for unit in units),
                _BASES[dimension],
            )
            for dimension, units in dimensions.items()
        ),
    )
    yield ""
    yield (
        "Numbers, shares and counts need no unit. Lengths multiply to areas, and an area by a"
        " length is a length; what is of different kinds is neither compared nor added."
    )


_BASES = {
    Dimension.LENGTH: "metres",
    Dimension.AREA: "square metres",
    Dimension.ANGLE: "degrees",
    Dimension.NUMBER: "numbers",
}


def _numbers() -> Iterator[str]:
    yield "### Numbers of the language"
    yield ""
    weights = [
        (f"`expect {name}:`" if name else "`expect:`", f"weight {weight:.0%}".replace("%", " %"))
        for name, weight in WEIGHTS.items()
    ]
    about = f"{ABOUT:.0%}".replace("%", " %")
    yield from _table(
        ("what", "is"),
        (
            *weights,
            ("`about x`", f"`= x ± {about} fading {about}`"),
            (f"`let {FADING}`", f"{SHARE:.0%}".replace("%", " %") + ", where a model does not say"),
            ("singular parts of a model", f"{MOST_SINGULAR} at most"),
            ("parts and sets of a model", f"{MOST_PARTS} at most"),
            ("brackets within brackets", f"{DEEPEST} at most"),
            ("words and signs of a statement", f"{LONGEST} at most"),
            ("files that one uses, directly or not", f"{MOST_FILES} at most"),
            ("a file", f"{LARGEST / 1e6:.0f} million characters at most"),
        ),
    )


# ------------------------------------------------------- examples and faults


def _things(things: Iterable[BuiltThing]) -> Iterator[str]:
    yield "### Things that examples build"
    yield ""
    yield "A size that is not given has the value shown. Up and the scale are known."
    yield ""
    yield from _table(
        ("write", "is"),
        (
            (
                f"`{thing.name}({', '.join(f'{n} {_amount(d, v)}' for n, d, v in thing.sizes)})`",
                thing.meaning,
            )
            for thing in things
        ),
    )


METRE = 1.0
"""Lengths from here on are written in metres, shorter ones in centimetres."""


def _amount(dimension: Dimension, value: float) -> str:
    """A value as a person would write it.

    >>> _amount(Dimension.LENGTH, 0.254), _amount(Dimension.LENGTH, 1.2)
    ('25.4 cm', '1.2 m')
    """
    match dimension:
        case Dimension.LENGTH:
            return f"{value:.6g} m" if value >= METRE else f"{value * 100:.6g} cm"
        case Dimension.ANGLE:
            return f"{value:.6g} deg"
    return f"{value:.6g}"


LONGEST_EXAMPLE = 60
"""Characters; longer ones, and those of several lines, would spoil a table."""


def _faults() -> Iterator[str]:
    yield "### Faults"
    yield ""
    yield (
        "The code stands behind each message. Errors keep a file from being used, warnings do not."
        " The examples stand in a model with `face top, side`."
    )
    yield ""
    yield from _table(
        ("code", "is", "says", "for example"),
        (
            (f"`{kind.code}`", kind.severity.value, kind.meaning, _example(kind.example))
            for kind in FAULT_KINDS.values()
        ),
    )


def _example(text: str) -> str:
    short = text and "\n" not in text and len(text) <= LONGEST_EXAMPLE
    return f"`{text}`" if short else "–"


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    for row in (head, ("---",) * len(head), *rows):
        yield f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |"
