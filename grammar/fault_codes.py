"""Every kind of fault of the language: what it is, how grave, and an example.

`facetlog model words faults`, the reports of `model check` and editors are made from these rows.
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


def build_example_file(kind: FaultKind) -> str:
    """Return the example as a whole file; of `own-word` as a file of Prolog.

    >>> print(build_example_file(FAULT_KINDS["zero-tolerance"]))
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
    FaultKind("empty-file", WARNING, "The file has only comments.", ""),
    FaultKind("misspelt", ERROR, "A word of the language is spelt wrongly.",
              "tilt(top) at leest 5 deg"),
    FaultKind("no-model", ERROR, "A statement stands before the first model.", "let a = 5\nface b"),
    FaultKind("open-text", ERROR, "A text in quotes does not end on its line.",
              'top is level "flat'),
    FaultKind("quote", ERROR, "A text is in typographic quotation marks.", "top is level “flat”"),
    FaultKind("stray-text", ERROR, "A text is not expected here.",
              '"flat"'),
    FaultKind("syntax", ERROR, "A statement cannot be read.", "top is level,, top is upward"),
    FaultKind("too-deep", ERROR, "A statement is too long or nested too deeply.",
              "(" * 45 + "top is level" + ")" * 45),
    FaultKind("too-large", ERROR, "The file is too large for a model file.", ""),
    # Files
    FaultKind("own-word", ERROR, "A Prolog file declares a word wrongly.", "word(lean, 3)."),
    FaultKind("same-name", WARNING, "Another file has a model of that name.", ""),
    FaultKind("unreadable", ERROR, "The file cannot be read.", ""),
    FaultKind("use", ERROR, "A used file cannot be read.", 'use "absent.model"'),
    # Names
    FaultKind("taken", ERROR, "The name is already in use.", "face top"),
    FaultKind("twice", ERROR, "Something is defined twice.", "ok: top is level"),
    FaultKind("unknown-builder", ERROR, "An example names a solid that cannot be built.", ""),
    FaultKind("unknown-kind", ERROR, "There is no such kind of part.", "one tabel other"),
    FaultKind("unknown-line", ERROR, "There is no line with this label.",
              'example "e" of table() fails because okk'),
    FaultKind("unknown-model", ERROR, "There is no such model.", "model a is absent" + _SHORT),
    FaultKind("unknown-name", ERROR, "There is nothing of this name.", "topp is level"),
    FaultKind("unknown-size", ERROR, "The solid has no such size.", ""),
    FaultKind("itself", ERROR, "A word is applied to a part and itself.", "top adjoins top"),
    FaultKind("stated", ERROR, "An option for reading an example's file is wrong.",
              'example "e" from "e.ply" (up w) fails'),
    FaultKind("unknown-unit", ERROR, "There is no such unit.", "tilt(top) at most 5 degs"),
    FaultKind("unknown-word", ERROR, "The vocabulary has no such word.", "top is levl"),
    # Models
    FaultKind("cycle", ERROR, "Something depends on itself.", "define flat(f): flat(f)"),
    FaultKind("drop", ERROR, "The dropped line was not inherited.", "drop ok"),
    FaultKind("mixed", ERROR, "A model mixes parts of one object with objects.", "one table other"),
    FaultKind("no-lines", ERROR, "A model has no required condition.", "model a\n  face b"),
    FaultKind("no-parts", ERROR, "A model has only sets and no single part.",
              "model a\n  at least 3 faces b\n  ok: count(b) at most 5"),
    FaultKind("replaced", ERROR, "A model made with `is` replaces a line or constant.",
              "model a" + _SHORT + "\nmodel b is a\n  ok: a is upright"),
    FaultKind("too-many", ERROR, "A model has too many parts.",
              "face " + ", ".join(f"f{n}" for n in range(20))),
    # Meaning
    FaultKind("arity", ERROR, "A word has too many or too few arguments.",
              "tilt(top, side) at most 5 deg"),
    FaultKind("count", ERROR, "The limits of a count are impossible.",
              "between 4 and 2 faces leg where leg adjoins top"),
    FaultKind("dimension", ERROR, "Measures of different dimensions are mixed.",
              "tilt(top) at most 5 cm"),
    FaultKind("fading", ERROR, "The fading of a model is not a share.",
              "let fading = 5 cm"),
    FaultKind("kind", ERROR, "A word is applied to the wrong kind of part.",
              "share(this) at least 5 %"),
    FaultKind("member", ERROR, "The object before the point has no such part.",
              "tilt(top.rim) at most 5 deg"),
    FaultKind("no-tolerance", ERROR, "A measure is compared without a tolerance.",
              "tilt(top) = 5 deg"),
    FaultKind("not-condition", ERROR, "A condition is expected here.", "tilt(top)"),
    FaultKind("not-constant", ERROR, "A constant depends on a part.", "let high = height(top)"),
    FaultKind("not-measure", ERROR, "A measure is expected here.", "top at most 5 deg"),
    FaultKind("number", ERROR, "A number is too large.", "tilt(top) at most 1e999 deg"),
    FaultKind("separate", ERROR, "Only faces and edges can be separate.",
              "model a\n  one table b\n  any number of separate tables c\n  ok: count(c) = 2"),
    FaultKind("set", ERROR, "A set is used where one part is expected, or the reverse.",
              "each top: top is level"),
    FaultKind("size", ERROR, "The numbers of names and measures differ.",
              "size long, wide: length(top)"),
    FaultKind("weight", ERROR, "A weight is above 100 %.", "expect 300 %: top is level"),
    FaultKind("where", ERROR, "A `where` follows more than one part.",
              "face x, y where x is level"),
    FaultKind("word", ERROR, "A word or definition lacks its arguments.",
              "level and top is upward"),
    # What never holds
    FaultKind("contradiction", ERROR, "Conditions contradict each other.",
              "top is level, top is upright"),
    FaultKind("negative-width", ERROR, "A tolerance is negative.", "tilt(top) = 30 deg ± -5 deg"),
    FaultKind("never-holds", ERROR, "A condition never holds, whatever is measured.",
              "share(top) at least 110 %"),
    # Lint warnings
    FaultKind("in-vain", WARNING, "A name is introduced but not used.",
              "each face x: top is level"),
    FaultKind("said-twice", WARNING, "A condition is repeated.", "side adjoins top"),
    FaultKind("unused-constant", WARNING, "A constant is never used.", "let square = 15 deg"),
    FaultKind("unused-definition", WARNING, "A definition is never used.",
              "define flat(f): f is level"),
    FaultKind("unused-parameter", WARNING, "A definition does not use a parameter.",
              "define flat(f): top is level\n  flat(side)"),
    FaultKind("unused-part", WARNING, "No condition is about a part.", "face back"),
    FaultKind("zero-tolerance", WARNING, "A tolerance is zero.",
              "tilt(top) = 30 deg ± 0 deg"),
)  # fmt: skip

FAULT_KINDS: Mapping[str, FaultKind] = MappingProxyType({kind.code: kind for kind in _KINDS})
"""The kinds of faults by their codes."""
