"""All words that models and questions are written in, with their meanings.

The entries are made from the tables that the program itself uses; `facetlog model words` prints
them, and `make docs` writes them as a page.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby

from facetlog.grammar.checking.model import MOST_PARTS, MOST_SINGULAR
from facetlog.grammar.compiling.lines import WEIGHTS
from facetlog.grammar.fading import ABOUT, FADING, SHARE
from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.library import MOST_FILES
from facetlog.grammar.phrase_hints import SPOKEN_WORDS
from facetlog.grammar.reading.layout import DEEPEST
from facetlog.grammar.reading.parse import LARGEST, LONGEST
from facetlog.grammar.units import UNITS
from facetlog.grammar.vocabulary import VOCABULARY, Gives, Kinds, Word
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.fact_schema import FACT_SCHEMA, Solutions
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, Parameter

__all__ = ["TOPICS", "Entry", "format_markdown", "list_entries"]

TOPICS: Mapping[str, str] = {
    "conditions": "Conditions of the model language",
    "measures": "Measures of the model language",
    "units": "Units",
    "numbers": "Defaults and limits of the language",
    "solids": "Solids that examples build; sizes that are not given have the value shown",
    "faults": "Faults that `facetlog model check` reports",
    "hints": "Words of everyday English, and what to write instead",
    "facts": "Facts of a scene, for questions and models in Prolog",
    "searches": "Searches of questions and models in Prolog",
    "tests": "Tests of models in Prolog, besides the conditions",
}
"""The topics in the order of the page, with their titles."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A word: how it is written, what it means, and further remarks by their labels."""

    topic: str
    name: str
    usage: str
    meaning: str
    notes: Mapping[str, str] = field(default_factory=dict)


def list_entries() -> tuple[Entry, ...]:
    """Return the entries of all topics, in the order of `TOPICS`."""
    entries = (
        *_iter_vocabulary(),
        *_iter_constants(),
        *_iter_solids_and_faults(),
        *_iter_facts(),
        *_iter_prolog_words(),
    )
    order = list(TOPICS)
    return tuple(sorted(entries, key=lambda entry: order.index(entry.topic)))


def format_markdown(entries: Iterable[Entry]) -> str:
    """Return the entries as a Markdown page with a table for each topic."""
    lines = ["# Words"]
    for topic, group in groupby(entries, key=lambda entry: entry.topic):
        rows = list(group)
        labels = list(dict.fromkeys(label for row in rows for label in row.notes))
        lines += ["", f"## {topic.capitalize()}", "", f"{TOPICS[topic]}.", ""]
        lines += [
            _format_row("write", "meaning", *labels),
            _format_row(*["---"] * (2 + len(labels))),
        ]
        lines += [
            _format_row(
                f"`{row.usage}`", row.meaning, *(row.notes.get(label, "") for label in labels)
            )
            for row in rows
        ]
    return "\n".join(lines) + "\n"


def _format_row(*cells: str) -> str:
    return f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"


def _iter_vocabulary() -> Iterator[Entry]:
    for word in VOCABULARY.values():
        notes = {"of": _format_arguments(word)}
        if not word.is_condition:
            notes["gives"] = _format_range(word)
        if word.unknown_when:
            notes["unknown when"] = word.unknown_when
        topic = "conditions" if word.is_condition else "measures"
        yield Entry(topic, word.name, _format_usage(word), word.meaning, notes)


_AMOUNTS = {
    Gives.ANGLE: "15 deg",
    Gives.LENGTH: "5 cm",
    Gives.AREA: "2 cm2",
    Gives.RATIO: "5 %",
    Gives.COUNT: "3",
}
"""An amount of each kind, for a word whose last argument is one."""


def _format_usage(word: Word) -> str:
    """Return a word as models write it: `A is level`, `A adjoins B`, `tilt(A)`."""
    letters = list("ABC"[: len(word.arguments)])
    if word.many:
        letters += ["B", "C", "..."]
    if word.number_last is not None:
        letters.append(_AMOUNTS[word.number_last])
    if word.is_condition and len(letters) == len(word.arguments) == 1:
        return f"{letters[0]} is {word.name}"
    if word.is_condition and len(letters) == len(word.arguments) == 2:
        return f"{letters[0]} {word.name} {letters[1]}"
    return f"{word.name}({', '.join(letters)})"


def _format_arguments(word: Word) -> str:
    kinds = [_format_kinds(argument) for argument in word.arguments]
    if word.many:
        return f"{kinds[0]}s"
    if len(kinds) == 1:
        return kinds[0]
    order = ", in either order" if word.symmetric else ""
    if word.alike:
        return f"{', or '.join(f'two {kind}s' for kind in sorted(word.arguments[0]))}{order}"
    return f"A: {kinds[0]}; B: {kinds[1]}" if kinds[0] != kinds[1] else f"each {kinds[0]}{order}"


def _format_kinds(kinds: Kinds) -> str:
    *others, last = sorted(kind.value for kind in kinds)
    return f"{', '.join(others)} or {last}" if others else last


def _format_range(word: Word) -> str:
    """Return the kind of a measure, and its bounds as far as it has any."""
    unit = "°" if word.gives is Gives.ANGLE else ""
    match word.low, word.high:
        case (float(low), float(high)):
            return f"{word.gives}, {low:g}{unit} to {high:g}{unit}"
        case (float(low), None) if low > 0:
            return f"{word.gives}, at least {low:g}{unit}"
        case (None, None):
            return f"{word.gives}, of either sign"
    return str(word.gives)


def _iter_constants() -> Iterator[Entry]:
    for unit in UNITS.values():
        yield Entry("units", unit.name, unit.name, f"unit of {unit.dimension.value}")
    values = {
        **{
            f"expect {name}".strip(): f"lowers the degree by {_format_percent(weight)}"
            for name, weight in WEIGHTS.items()
        },
        "about": f"`about x` is `= x ± {_format_percent(ABOUT)} fading {_format_percent(ABOUT)}`",
        f"let {FADING}": f"{_format_percent(SHARE)} unless a model gives another share",
        "single parts": f"at most {MOST_SINGULAR} in a model",
        "parts and sets": f"at most {MOST_PARTS} in a model",
        "brackets": f"nested at most {DEEPEST} deep",
        "statement": f"at most {LONGEST} words and signs",
        "use": f"at most {MOST_FILES} files, directly or not",
        "file": f"at most {LARGEST / 1e6:.0f} million characters",
    }
    for usage, meaning in values.items():
        yield Entry("numbers", usage, usage, meaning)


def _format_percent(share: float) -> str:
    return f"{100 * share:g} %"


def _iter_solids_and_faults() -> Iterator[Entry]:
    for builder in BUILDERS.values():
        sizes = ", ".join(f"{size.name} {_format_size(size)}" for size in builder.parameters)
        yield Entry("solids", builder.name, f"{builder.name}({sizes})", builder.meaning)
    for kind in FAULT_KINDS.values():
        notes = {"severity": kind.severity.value}
        if kind.example and "\n" not in kind.example:
            notes["for example"] = f"`{kind.example}`"
        yield Entry("faults", kind.code, kind.code, kind.meaning, notes)
    for word, hint in SPOKEN_WORDS.items():
        yield Entry("hints", word, word, hint)


def _format_size(size: Parameter) -> str:
    """Return the default of a size as a person would write it, such as `25.4 cm`."""
    if size.kind == "angle":
        return f"{math.degrees(size.default):.6g} deg"
    if size.kind == "count":
        return f"{size.default:.6g}"
    return f"{size.default:.6g} m" if size.default >= 1.0 else f"{size.default * 100:.6g} cm"


_COUNTS = {
    Solutions.ONE: "exactly one",
    Solutions.AT_MOST_ONE: "at most one",
    Solutions.ANY: "any number",
}


def _iter_facts() -> Iterator[Entry]:
    for kind in FACT_SCHEMA:
        names = [
            ("+" if i < kind.keys else "") + argument.name
            for i, argument in enumerate(kind.arguments)
        ]
        units = dict.fromkeys(a.kind.value for a in kind.arguments if not a.kind.is_name)
        notes = {"facts for given + arguments": _COUNTS[kind.solutions]}
        if units:
            notes["units"] = ", ".join(units)
        if kind.absent:
            notes["absent when"] = kind.absent
        usage = f"{kind.functor}({', '.join(names)})"
        yield Entry("facts", kind.functor, usage, kind.meaning, notes)


def _iter_prolog_words() -> Iterator[Entry]:
    topics = {"search": "searches", "question": "searches", "test": "tests"}
    with KnowledgeBase() as base:
        for word in sorted(base.words(), key=lambda word: word.signature):
            if word.kind in topics:
                yield Entry(topics[word.kind], word.name, word.signature, word.meaning)
