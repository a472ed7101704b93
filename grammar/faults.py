"""What is wrong with a model file, and how it is shown."""

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from enum import StrEnum

from facetlog.grammar.fixing.fix import Fix
from facetlog.grammar.source import Source, Span

__all__ = ["ALIKE", "MOST_FAULTS", "Fault", "Severity", "nearest", "said"]

MOST_FAULTS = 50
"""Faults listed of one file: who has more has sent the wrong file."""

WIDTH = 140
"""Columns of a line that are shown with a fault."""

# difflib's own measure of likeness; at 0.6, its default, `adjoin` finds `adjoins` and `x` nothing.
ALIKE = 0.6


class Severity(StrEnum):
    """Errors keep a model from being used; warnings do not."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: what it is, where, and the way out.

    `code` is a stable name ("unknown-word"), `hint` a sentence that begins with a small letter, or
    empty. `fixes` are edits that put it right, the likeliest first; one at most is sure.
    """

    code: str
    message: str
    source: Source
    span: Span
    hint: str = ""
    severity: Severity = Severity.ERROR
    fixes: tuple[Fix, ...] = ()

    @property
    def sure_fix(self) -> Fix | None:
        """What puts it right without a question."""
        return next((fix for fix in self.fixes if fix.sure), None)

    @property
    def place(self) -> str:
        """File, line and column."""
        return self.source.place(self.span.start)

    def lines(self) -> Iterable[str]:
        """The fault as text: place and message, the line, carets under the fault, the way out."""
        number, column = self.source.line_and_column(self.span.start)
        hint = f"; {self.hint}" if self.hint else ""
        yield f"{self.place}: {self.severity}: {self.message}{hint} [{self.code}]"
        text = self.source.line(number)
        if text.strip():
            # Of a long line the part round the fault.
            first = max(0, min(column - 1 - WIDTH // 2, len(text) - WIDTH))
            shown = text[first : first + WIDTH]
            at = column - 1 - first
            width = max(1, min(self.span.end - self.span.start, len(shown) - at))
            # Tabs stay tabs, so that the caret stands where the line shows it.
            lead = "".join("\t" if letter == "\t" else " " for letter in shown[:at])
            yield f"  {shown}"
            yield f"  {lead}{'^' * width}"


def nearest(word: str, known: Iterable[str]) -> str:
    """The known word that is spelt most like it, or nothing.

    >>> nearest("adjoin", ["angle", "adjoins"])
    'adjoins'
    """
    found = get_close_matches(word, sorted(set(known)), n=1, cutoff=ALIKE)
    return found[0] if found else ""


def said(word: str, known: Iterable[str]) -> str:
    """The hint that names the nearest known word, or nothing."""
    found = nearest(word, known)
    return f"did you mean `{found}`?" if found else ""
