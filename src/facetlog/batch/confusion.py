"""Confusion matrix: right answers against answers given, and the mistakes."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from facetlog.batch.labels import ERROR, NONE, Label, Truth
from facetlog.batch.rows import HOLDS, Row, read_confidence

"""What a scene without verdicts was answered; never right."""

CONFIDENCE = 0.95


class Proportion(NamedTuple):
    """A share of counted things: so many of so many."""

    hits: int
    of: int

    @property
    def value(self) -> float | None:
        """The share, if there is anything to count."""
        return self.hits / self.of if self.of else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's interval of the share, 95 %."""
        if not self.of:
            return None
        from scipy.stats import binomtest

        found = binomtest(self.hits, self.of).proportion_ci(CONFIDENCE, method="wilson")
        return float(found.low), float(found.high)

    def __str__(self) -> str:
        if self.value is None or self.interval is None:
            return "–"
        low, high = self.interval
        return f"{self.value:.3f} ({self.hits} of {self.of}, 95 % {low:.3f}–{high:.3f})"

    def to_json(self) -> dict[str, Any]:
        """Return the share as plain data."""
        return {"hits": self.hits, "of": self.of, "share": self.value, "interval": self.interval}


@dataclass(frozen=True, slots=True)
class Mistake:
    """A scene that was answered wrong; `sure` is its confidence, or its degree if it has none, in
    words; empty without an answer."""

    path: str
    label: str
    truth: str
    answered: str
    degree: float | None
    sure: str
    error: str | None
    kind: str = ""

    def __str__(self) -> str:
        why = f": {self.error.removeprefix(f'{self.path}: ')}" if self.error else ""
        return f"{self.path}: {self.label}, answered {self.answered}{self.percentage}{why}"

    @property
    def percentage(self) -> str:
        """Confidence of the answer in brackets; empty without one."""
        return f" ({self.sure})" if self.sure else ""

    def to_json(self) -> dict[str, Any]:
        """Return the mistake as plain data."""
        return {
            "path": self.path,
            "label": self.label,
            "right": self.truth,
            "answered": self.answered,
            "degree": self.degree,
            "error": self.error,
            "kind": self.kind,
        }


def answer(row: Row, classes: Sequence[str]) -> tuple[str, Row | None]:
    """Return which of the classes the row is answered, and its verdict.

    That is the first that holds: rows list verdicts in the order of best_first.py. NONE if none of
    the classes holds, ERROR if there are no verdicts.
    """
    if row["error"] is not None:
        return ERROR, None
    holding = (v for v in row["verdicts"] if v["state"] == HOLDS and v["model"] in classes)
    best = next(holding, None)
    return (NONE, None) if best is None else (best["model"], best)


@dataclass(slots=True)
class Confusion:
    """Rows counted by right answer and answer given; filled row by row.

    `labels` are by the path of the row. `classes` are the models asked for; `counted_as` says how
    labels count that are none of them; others count as NONE.
    """

    labels: Mapping[str, Label]
    classes: tuple[str, ...]
    counted_as: Mapping[str, Truth] = field(default_factory=dict)
    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    by_kind: Counter[tuple[str, bool]] = field(default_factory=Counter)
    left_out: Counter[tuple[str, str]] = field(default_factory=Counter)
    mistakes: list[Mistake] = field(default_factory=list)
    unlabelled: int = 0

    def add(self, row: Row) -> None:
        """Count a row by the label of its scene."""
        label = self.labels.get(row["path"])
        if label is None:
            self.unlabelled += 1
            return
        given, verdict = answer(row, self.classes)
        truth = self.truth(label.label)
        if truth.answer is None or given in truth.doubtful:
            self.left_out[label.label, given] += 1
            return
        right = given == truth.answer
        self.counts[truth.answer, given] += 1
        self.by_kind[label.kind, right] += 1
        if not right:
            self.mistakes.append(
                Mistake(
                    row["path"],
                    label.label,
                    truth.answer,
                    given,
                    None if verdict is None else verdict["degree"],
                    "" if verdict is None else read_confidence(verdict).format(verdict["degree"]),
                    row["error"],
                    label.kind,
                )
            )

    def truth(self, label: str) -> Truth:
        """Return how a label counts."""
        known = self.counted_as.get(label)
        return known or Truth(label if label in self.classes else NONE)

    @property
    def rows(self) -> tuple[str, ...]:
        """Right answers: the rows of the matrix."""
        return (*self.classes, NONE)

    @property
    def columns(self) -> tuple[str, ...]:
        """Answers: the columns of the matrix; errors only if there were any."""
        failed = any(given == ERROR for _, given in self.counts)
        return (*self.rows, ERROR) if failed else self.rows

    @property
    def accuracy(self) -> Proportion:
        """How many of the counted scenes were answered right."""
        hits = sum(n for (truth, given), n in self.counts.items() if truth == given)
        return Proportion(hits, self.counts.total())

    def recall(self, name: str) -> Proportion:
        """Return how many of those that are one were answered so."""
        of = sum(n for (truth, _), n in self.counts.items() if truth == name)
        return Proportion(self.counts[name, name], of)

    def precision(self, name: str) -> Proportion:
        """Return how many of those answered so are one."""
        of = sum(n for (_, given), n in self.counts.items() if given == name)
        return Proportion(self.counts[name, name], of)

    def kinds(self) -> Iterator[tuple[str, Proportion]]:
        """Yield the accuracy for each kind of scene, if the labels tell several."""
        names = sorted({kind for kind, _ in self.by_kind})
        if len(names) > 1:
            for kind in names:
                right, wrong = self.by_kind[kind, True], self.by_kind[kind, False]
                yield kind, Proportion(right, right + wrong)

    def lines(self) -> Iterator[str]:
        """Yield the matrix, the shares, and the names of what went wrong, as text."""
        if not self.counts:
            yield "no scene with a label was counted"
            return
        wide = max(len("right \\ answered"), *map(len, self.rows)) + 2
        yield "right \\ answered".ljust(wide) + "".join(f"{c:>9}" for c in self.columns)
        for name in self.rows:
            cells = "".join(f"{self.counts[name, c]:>9}" for c in self.columns)
            yield name.ljust(wide) + cells
        yield ""
        yield f"accuracy {self.accuracy}"
        for name in self.rows:
            yield f"{name}: recall {self.recall(name)}, precision {self.precision(name)}"
        for kind, share in self.kinds():
            yield f"of kind {kind or '(none)'}: accuracy {share}"
        if self.left_out:
            listed = (f"{label} → {given} {n}" for (label, given), n in self.left_out.items())
            yield f"not counted: {', '.join(sorted(listed))}"
        if self.unlabelled:
            yield f"without a label: {self.unlabelled}"
        if self.mistakes:
            yield ""
            yield f"wrong ({len(self.mistakes)}):"
            for mistake in self.mistakes:
                yield f"  {mistake}"

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return {
            "classes": list(self.classes),
            "matrix": {t: {g: self.counts[t, g] for g in self.columns} for t in self.rows},
            "accuracy": self.accuracy.to_json(),
            "recall": {name: self.recall(name).to_json() for name in self.rows},
            "precision": {name: self.precision(name).to_json() for name in self.rows},
            "kinds": {kind: share.to_json() for kind, share in self.kinds()},
            "not_counted": [
                {"label": label, "answered": given, "count": n}
                for (label, given), n in sorted(self.left_out.items())
            ],
            "unlabelled": self.unlabelled,
            "mistakes": [mistake.to_json() for mistake in self.mistakes],
        }
