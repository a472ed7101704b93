"""Every kind of fault of the language: what it is, how grave, and an example, as faults.md says.

`facetlog model words faults`, the reports of `model check` and editors are made from it.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from facetlog.grammar.faults import Severity

PAGE = Path(__file__).with_name("faults.md")
"""A heading for each code; beneath it the severity, the meaning, and an example of its text."""

_KIND = re.compile(
    r"^## (?P<code>[a-z-]+)\n\n(?P<severity>Error|Warning)\. (?P<meaning>.+)\n"
    r"(?:\n```model\n(?P<example>[\s\S]*?)\n```\n)?(?=\n##|\Z)",
    re.MULTILINE,
)


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

    @property
    def address(self) -> str:
        """Address of its section in the page of faults, which is installed with facetlog."""
        return f"{PAGE.absolute().as_uri()}#{self.code}"


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


def _read_kinds() -> dict[str, FaultKind]:
    kinds = {}
    for match in _KIND.finditer(PAGE.read_text(encoding="utf-8")):
        code, severity, meaning, example = match.groups()
        kinds[code] = FaultKind(code, Severity(severity.lower()), meaning, example or "")
    return kinds


FAULT_KINDS: Mapping[str, FaultKind] = MappingProxyType(_read_kinds())
"""The kinds of faults by their codes."""
