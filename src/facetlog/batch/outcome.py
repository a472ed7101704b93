"""Summary of a run: counts, confusion, changes; as text and as data."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from facetlog.batch.compare import Comparison
from facetlog.batch.confusion import Confusion, answer
from facetlog.batch.labels import NONE
from facetlog.batch.profile import Profile
from facetlog.batch.rows import HOLDS, Row
from facetlog.kb.overlaps import Overlaps
from facetlog.plurals import many

SCHEMA = "facetlog-classify/1"


@dataclass(slots=True)
class Outcome:
    """Filled row by row, as they are written out.

    `models` counts what scenes were answered: as the confusion matrix does where there is one, of
    the classes that it has.
    """

    confusion: Confusion | None = None
    comparison: Comparison | None = None
    overlaps: Overlaps | None = None
    scenes: int = 0
    kept: int = 0
    seconds: float = 0.0
    models: Counter[str] = field(default_factory=Counter)
    profile: Profile | None = None
    errors: list[tuple[str, str]] = field(default_factory=list)
    warnings: list[tuple[str, str]] = field(default_factory=list)
    """The warnings of scenes, a line each."""

    def noting(self, rows: Iterable[Row]) -> Iterator[Row]:
        """Count rows and yield them."""
        for row in rows:
            self.scenes += 1
            if row["error"] is not None:
                self.errors.append((row["path"], row["error"]))
            else:
                self.models[self._answer(row)] += 1
                self.warnings += ((row["path"], line) for line in row["warnings"])
            if self.overlaps is not None:
                self.overlaps.add(
                    (v["thing"], v["model"], v["degree"])
                    for v in row["verdicts"]
                    if v["state"] == HOLDS
                )
            if self.confusion is not None:
                self.confusion.add(row)
            if self.comparison is not None:
                self.comparison.add(row)
            yield row

    def _answer(self, row: Row) -> str:
        if self.confusion is not None:
            return answer(row, self.confusion.classes)[0]
        return NONE if row["model"] is None else str(row["model"])

    def lines(self) -> Iterator[str]:
        """Yield the summary as text."""
        if self.confusion is not None:
            yield from self.confusion.lines()
        if self.comparison is not None:
            yield from self.comparison.lines()

    @property
    def summary(self) -> str:
        """One line: how many scenes, how long, what they are, and how many have errors."""
        new = self.scenes - self.kept
        rate = f", {new / self.seconds:.3g}/s" if new and self.seconds > 0 else ""
        kept = f" ({self.kept} of them before)" if self.kept else ""
        found = ", ".join(f"{name} {count}" for name, count in self.models.most_common())
        failed = len(self.errors)
        errors = f"{failed} with {'an error' if failed == 1 else 'errors'}" if failed else ""
        said = "; ".join(filter(None, (found, errors)))
        return f"{many(self.scenes, 'scene')}{kept} in {self.seconds:.1f} s{rate}: {said}"

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data, with the schema's name."""
        return {
            "schema": SCHEMA,
            "scenes": self.scenes,
            "kept": self.kept,
            "seconds": round(self.seconds, 3),
            "models": dict(self.models.most_common()),
            "errors": [{"path": path, "error": error} for path, error in self.errors],
            "confusion": None if self.confusion is None else self.confusion.to_json(),
            "changed": None if self.comparison is None else self.comparison.to_json(),
            "profile": None if self.profile is None else self.profile.to_json(),
        }
