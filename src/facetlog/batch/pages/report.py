"""The report: one HTML file with all that went wrong, pictures and reasons inside."""

import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from facetlog.batch.confusion import Confusion, Mistake
from facetlog.batch.outcome import Outcome
from facetlog.batch.pages.explain import Mistaken
from facetlog.batch.pages.render import render_page
from facetlog.batch.pool import Task
from facetlog.batch.rows import HOLDS, Row, closest, read_confidence
from facetlog.batch.run import Finished, Progress, Workers
from facetlog.perception.atomic_write import open_atomically
from facetlog.plurals import many

EXPLAINED_AT_ONCE = 256
"""Mistakes whose pictures are in memory together: some megabytes."""

MOST_ERRORS = 200
"""Scenes with errors that the page lists; the table of results has them all."""

SHADE_LEAST, SHADE_MOST = 0.10, 0.45
"""Opacity of a cell of the matrix with few and with all of its row."""


def write_report(
    path: Path,
    outcome: Outcome,
    confusion: Confusion,
    done: Finished,
    workers: Workers,
    progress: Progress | None = None,
) -> None:
    """Write the report, whole or not at all; `workers` draw and explain the mistakes."""
    interval = confusion.accuracy.interval
    spread = "" if interval is None else f", 95 % within {interval[0]:.1%}–{interval[1]:.1%}"

    def count_row(right: str) -> int:
        return sum(confusion.counts[right, given] for given in confusion.columns)

    def shade(count: int, right: str) -> str:
        return f"{SHADE_LEAST + (SHADE_MOST - SHADE_LEAST) * count / count_row(right):.2f}"

    pieces = render_page(
        "report.html.jinja",
        outcome=outcome,
        confusion=confusion,
        spread=spread,
        total=count_row,
        shade=shade,
        percent=lambda share: "–" if share is None else f"{share:.1%}",
        most_errors=MOST_ERRORS,
        groups=_groups(confusion, done, _Explainers(workers, confusion, progress)),
    )
    with open_atomically(path) as file:
        file.writelines(pieces)


class _Explainers:
    """Workers that explain mistakes, and report how many they have."""

    def __init__(self, workers: Workers, confusion: Confusion, progress: Progress | None) -> None:
        self._workers, self._progress = workers, progress
        self._done, self._total = 0, len(confusion.mistakes)
        self._report()

    def explain(self, tasks: Iterable[Task]) -> dict[str, dict[str, Any]]:
        """Return picture and reasons by path; a failed worker's error is the reason."""
        found: dict[str, dict[str, Any]] = {}
        for answer in self._workers.answers(tasks):
            explanation = json.loads(answer.line)
            if answer.failed:
                reason = {"title": "No reasons", "lines": [explanation["error"]]}
                explanation = {"picture": None, "reasons": [reason]}
            found[answer.task.item.path] = explanation
            self._done += 1
            self._report()
        return found

    def _report(self) -> None:
        if self._progress is not None:
            self._progress(self._done, self._total, 0)


def _groups(
    confusion: Confusion, done: Finished, explainers: _Explainers
) -> Iterator[tuple[str, str, int, Iterator[dict[str, Any]]]]:
    """Yield right and given answer, how many mistakes there are of that kind, and their cards."""
    order = {name: i for i, name in enumerate(confusion.columns)}
    mistakes = sorted(confusion.mistakes, key=lambda m: (order[m.truth], order[m.answered]))
    for (truth, answered), group in groupby(mistakes, lambda m: (m.truth, m.answered)):
        some = tuple(group)
        yield truth, answered, len(some), _cards(some, confusion.classes, done, explainers)


def _cards(
    mistakes: Sequence[Mistake], classes: Sequence[str], done: Finished, explainers: _Explainers
) -> Iterator[dict[str, Any]]:
    items = {item.path: item for item in done.items}
    for start in range(0, len(mistakes), EXPLAINED_AT_ONCE):
        some = mistakes[start : start + EXPLAINED_AT_ONCE]
        pairs = list(zip(some, done.journal.rows(m.path for m in some), strict=True))
        found = explainers.explain([Task(items[m.path], _mistaken(m, row)) for m, row in pairs])
        for mistake, row in pairs:
            counts = ""
            if row["faces"] is not None:
                counts = f" · {many(row['faces'], 'face')}, {many(row['things'], 'thing')}"
            yield {
                "mistake": mistake,
                "counts": counts,
                "chips": list(_chips(row, mistake, classes)),
                **found[mistake.path],
            }


def _chips(row: Row, mistake: Mistake, classes: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield kind and text of a chip for each model on its nearest thing, the classes first."""
    best = closest(row)
    for model in sorted(best, key=lambda name: name not in classes):
        verdict = best[model]
        holds = verdict["state"] == HOLDS
        kind = ("wrong" if model == mistake.answered else "holds") if holds else ""
        yield (
            kind,
            f"{model} {_format_confidence(verdict) if holds else verdict['state']}",
        )


def _format_confidence(verdict: Row) -> str:
    return read_confidence(verdict).format(verdict["degree"])


def _mistaken(mistake: Mistake, row: Row) -> dict[str, Any]:
    best = closest(row)
    named = dict.fromkeys((mistake.truth, mistake.answered))
    return dict(
        Mistaken(
            right=mistake.truth,
            answered=mistake.answered,
            verdicts={model: best[model] for model in named if model in best},
        )
    )
