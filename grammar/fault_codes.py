"""Every kind of fault of the language: what it is, how grave, and an example.

The reference, the reports of `model check` and editors are made from these rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from facetlog.grammar.faults import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING


@dataclass(frozen=True, slots=True)
class FaultKind:
    """A kind of fault; `severity` is the gravest that it has.

    `example` is a statement that has it in a model with the faces `top` and `side`, or a whole
    file; empty where no text can show it.
    """

    code: str
    severity: Severity
    meaning: str
    example: str


def example_file(kind: FaultKind) -> str:
    """The example as a whole file; of `own-word` as a file of Prolog.

    >>> print(example_file(FAULT_KINDS["zero-tolerance"]))
    model made_up
      "An example."
      face top, side
      ok: top is measured, top adjoins side
      tilt(top) = 30 deg ± 0 deg
      example "a table" of table() fails
    <BLANKLINE>
    """
    if kind.code in ("own-word", "no-model") or kind.example.startswith(("model ", "use ")):
        return f"{kind.example}\n"
    return (
        'model made_up\n  "An example."\n  face top, side\n'
        "  ok: top is measured, top adjoins side\n"
        f'  {kind.example}\n  example "a table" of table() fails\n'
    )


_SHORT = '\n  "It."\n  face a\n  ok: a is level\n  example "e" of table() fails'

_KINDS = (
    # Text
    FaultKind("bracket", ERROR, "A bracket is not closed, or closes nothing.",
              "tilt(top at most 5 deg"),
    FaultKind("decimal-comma", ERROR, "A number has a decimal comma.", "tilt(top) at most 2,5 deg"),
    FaultKind("empty-file", WARNING, "The file has nothing but comments.", ""),
    FaultKind("misspelt", ERROR, "A word of the language is spelt wrongly.",
              "tilt(top) at leest 5 deg"),
    FaultKind("no-model", ERROR, "A statement stands before the first model.", "let a = 5\nface b"),
    FaultKind("open-text", ERROR, "A text in quotes does not end on its line.",
              'top is level "flat'),
    FaultKind("quote", ERROR, "A text stands in other quotation marks.", "top is level “flat”"),
    FaultKind("stray-text", ERROR, "A text stands alone where no description is expected.",
              '"flat"'),
    FaultKind("syntax", ERROR, "A statement cannot be read.", "top is level,, top is upward"),
    FaultKind("too-deep", ERROR, "A statement is too long or nested too deeply.",
              "(" * 45 + "top is level" + ")" * 45),
    FaultKind("too-large", ERROR, "The file is too large for a model file.", ""),
    # Files
    FaultKind("own-word", ERROR, "A Prolog file declares a word wrongly.", "word(lean, 3)."),
    FaultKind("unreadable", ERROR, "The file cannot be read.", ""),
    FaultKind("use", ERROR, "A file that is used cannot be.", 'use "absent.model"'),
    # Names
    FaultKind("taken", ERROR, "A name is taken already.", "face top"),
    FaultKind("twice", ERROR, "Something is defined or given twice.", "ok: top is level"),
    FaultKind("unknown-builder", ERROR, "An example asks for a thing that cannot be built.", ""),
    FaultKind("unknown-kind", ERROR, "A part is of a kind that there is not.", "one tabel other"),
    FaultKind("unknown-line", ERROR, "No line has this label.",
              'example "e" of table() fails because okk'),
    FaultKind("unknown-model", ERROR, "There is no such model.", "model a is absent" + _SHORT),
    FaultKind("unknown-name", ERROR, "Nothing has this name.", "topp is level"),
    FaultKind("unknown-size", ERROR, "A thing that is built has no such size.", ""),
    FaultKind("itself", ERROR, "A word is said of one part and itself.", "top adjoins top"),
    FaultKind("unknown-unit", ERROR, "There is no such unit.", "tilt(top) at most 5 degs"),
    FaultKind("unknown-word", ERROR, "The vocabulary has no such word.", "top is levl"),
    # Models
    FaultKind("cycle", ERROR, "Something depends on itself.", "define flat(f): flat(f)"),
    FaultKind("drop", ERROR, "A line is dropped that is not inherited.", "drop ok"),
    FaultKind("mixed", ERROR, "A model mixes parts of a thing with objects.", "one table other"),
    FaultKind("no-lines", ERROR, "A model has no condition that decides it.", "model a\n  face b"),
    FaultKind("no-parts", ERROR, "A model has no single part to begin from.",
              "model a\n  at least 3 faces b\n  ok: count(b) at most 5"),
    FaultKind("replaced", ERROR, "A line or constant is replaced that must stay.",
              "model a" + _SHORT + "\nmodel b is a\n  ok: a is upright"),
    FaultKind("too-many", ERROR, "A model has too many parts.",
              "face " + ", ".join(f"f{n}" for n in range(20))),
    # Meaning
    FaultKind("arity", ERROR, "A word has too many or too few arguments.",
              "tilt(top, side) at most 5 deg"),
    FaultKind("count", ERROR, "A number of members is impossible.",
              "between 4 and 2 faces leg where leg adjoins top"),
    FaultKind("dimension", ERROR, "Measures of different kinds are mixed up.",
              "tilt(top) at most 5 cm"),
    FaultKind("fading", ERROR, "A model's fading is no share of its limits.",
              "let fading = 5 cm"),
    FaultKind("kind", ERROR, "A word is said of what it cannot be said of.",
              "share(this) at least 5 %"),
    FaultKind("member", ERROR, "What stands before the point has no such part.",
              "tilt(top.rim) at most 5 deg"),
    FaultKind("no-tolerance", ERROR, "A measure is compared without a tolerance.",
              "tilt(top) = 5 deg"),
    FaultKind("not-condition", ERROR, "A condition is wanted here.", "tilt(top)"),
    FaultKind("not-constant", ERROR, "A constant depends on a part.", "let high = height(top)"),
    FaultKind("not-measure", ERROR, "A measure is wanted here.", "top at most 5 deg"),
    FaultKind("number", ERROR, "A number is too large.", "tilt(top) at most 1e999 deg"),
    FaultKind("separate", ERROR, "Only faces and edges can be separate.",
              "model a\n  one table b\n  any number of separate tables c\n  ok: count(c) = 2"),
    FaultKind("set", ERROR, "A set stands where one is wanted, or the other way about.",
              "each top: top is level"),
    FaultKind("size", ERROR, "A size has not as many names as measures.",
              "size long, wide: length(top)"),
    FaultKind("weight", ERROR, "A weight is more than all.", "expect 300 %: top is level"),
    FaultKind("where", ERROR, "A condition after `where` is said of more than one part.",
              "face x, y where x is level"),
    FaultKind("word", ERROR, "A word or definition lacks what it is said of.",
              "level and top is upward"),
    # What never holds
    FaultKind("contradiction", ERROR, "Conditions cannot hold together.",
              "top is level, top is upright"),
    FaultKind("negative-width", ERROR, "A tolerance is negative.", "tilt(top) = 30 deg ± -5 deg"),
    FaultKind("never-holds", ERROR, "A condition fails whatever is measured.",
              "share(top) at least 110 %"),
    # Lint warnings
    FaultKind("in-vain", WARNING, "A local name is never used.", "each face x: top is level"),
    FaultKind("said-twice", WARNING, "A condition stands there twice.", "side adjoins top"),
    FaultKind("unused-constant", WARNING, "A constant is never used.", "let square = 15 deg"),
    FaultKind("unused-definition", WARNING, "A definition is never used.",
              "define flat(f): f is level"),
    FaultKind("unused-parameter", WARNING, "A definition does not use a parameter.",
              "define flat(f): top is level\n  flat(side)"),
    FaultKind("unused-part", WARNING, "Nothing is said of a part.", "face back"),
    FaultKind("zero-tolerance", WARNING, "A measure must be exactly so.",
              "tilt(top) = 30 deg ± 0 deg"),
)  # fmt: skip

FAULT_KINDS: Mapping[str, FaultKind] = MappingProxyType({kind.code: kind for kind in _KINDS})
"""The kinds of faults by their codes."""
