"""What is shown of words, units, constants, parts and models, in Markdown."""

from collections.abc import Mapping

from facetlog.grammar import syntax as s
from facetlog.grammar.constants import constant
from facetlog.grammar.reading.layout import laid_out
from facetlog.grammar.resolve import FlatModel, Owned
from facetlog.grammar.source import Source
from facetlog.grammar.statement_lines import one_line
from facetlog.grammar.units import UNITS, Dimension
from facetlog.grammar.vocabulary import Word

__all__ = [
    "code",
    "constant_value",
    "model_documentation",
    "statement_text",
    "unit_documentation",
    "word_documentation",
]

_BASE_UNITS = {
    Dimension.LENGTH: " m",
    Dimension.AREA: " m²",
    Dimension.ANGLE: "°",
    Dimension.NUMBER: "",
}


def code(text: str) -> str:
    """A piece of a model file, to be shown as such."""
    return f"```facetlog-model\n{text}\n```"


def word_documentation(word: Word) -> str:
    """What a word of the vocabulary means, when a scene does not know it, who brought it."""
    lines = [f"{word.meaning[:1].upper()}{word.meaning[1:]}."]
    if word.low is not None or word.high is not None:
        bounds = [f"at least {word.low:g}" if word.low is not None else ""]
        bounds.append(f"at most {word.high:g}" if word.high is not None else "")
        lines.append(f"Always {' and '.join(b for b in bounds if b)}.")
    if word.symmetric:
        lines.append("The order of its arguments means nothing.")
    if word.unknown_when:
        lines.append(f"Not known if {word.unknown_when}.")
    if word.source is not None:
        lines.append(f"A word of `{word.source.name.rpartition('/')[2]}`.")
    return "\n\n".join(lines)


def unit_documentation(name: str) -> str:
    """What a unit is; empty if there is none of the name."""
    unit = UNITS.get(name)
    if unit is None:
        return ""
    return f"{unit.dimension}: {unit.factor:g}{_BASE_UNITS[unit.dimension]}"


def constant_value(let: s.Let, lets: Mapping[str, Owned[s.Let]]) -> str:
    """The value of a constant in metres, degrees or ones; empty if it is none."""
    value = constant(let.value, lets)
    return "" if value is None else f"{value.value:.6g}{_BASE_UNITS[value.dimension]}"


def model_documentation(model: FlatModel) -> str:
    """What a model says of itself."""
    doc = model.written.doc
    return "" if doc is None else doc.value


def statement_text(source: Source, offset: int) -> str:
    """The statement at a place, on one line; empty if there is none."""
    for statement in laid_out(source).statements:
        if offset in statement.span:
            return one_line(statement.tokens)
    return ""
