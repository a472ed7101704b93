"""The report: one HTML file with all that went wrong, pictures and reasons inside."""

import json
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

from facetlog.batch.confusion import Confusion, Mistake
from facetlog.batch.outcome import Outcome
from facetlog.batch.pages.explain import Mistaken
from facetlog.batch.pages.report_page import Explanation, card, foot, group_head, head
from facetlog.batch.pool import Task
from facetlog.batch.rows import Row, closest
from facetlog.batch.run import Finished, Progress, Workers
from facetlog.perception.atomic_write import writing_whole

__all__ = ["write_report"]

EXPLAINED_AT_ONCE = 256
"""Mistakes whose pictures are in memory together: some megabytes."""


def write_report(
    path: Path,
    outcome: Outcome,
    confusion: Confusion,
    done: Finished,
    workers: Workers,
    progress: Progress | None = None,
) -> None:
    """Writes the report, whole or not at all; `workers` draw and explain the mistakes."""
    with writing_whole(path) as file:
        for text in _page(outcome, confusion, done, _Explainers(workers, confusion, progress)):
            file.write(text.encode("utf-8", "backslashreplace"))


class _Explainers:
    """Workers that explain mistakes, and report how many they have."""

    def __init__(self, workers: Workers, confusion: Confusion, progress: Progress | None) -> None:
        self._workers, self._progress = workers, progress
        self._done, self._total = 0, len(confusion.mistakes)
        self._report()

    def explanations(self, tasks: Iterable[Task]) -> dict[str, Explanation]:
        """By path; a worker that died at one, or took too long, has said so instead."""
        found: dict[str, Explanation] = {}
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


def _page(
    outcome: Outcome, confusion: Confusion, done: Finished, explainers: _Explainers
) -> Iterator[str]:
    yield from head(outcome, confusion)
    order = {name: i for i, name in enumerate(confusion.columns)}

    def kind(mistake: Mistake) -> tuple[str, str]:
        return mistake.truth, mistake.answered

    def place(mistake: Mistake) -> tuple[int, int]:
        return order[mistake.truth], order[mistake.answered]

    items = {item.path: item for item in done.items}
    for (truth, answered), group in groupby(sorted(confusion.mistakes, key=place), kind):
        mistakes = tuple(group)
        yield group_head(truth, answered, len(mistakes))
        for start in range(0, len(mistakes), EXPLAINED_AT_ONCE):
            some = mistakes[start : start + EXPLAINED_AT_ONCE]
            rows = list(done.journal.rows(m.path for m in some))
            pairs = list(zip(some, rows, strict=True))
            found = explainers.explanations(
                [Task(items[m.path], _mistaken(m, r)) for m, r in pairs]
            )
            for mistake, row in pairs:
                yield card(mistake, row, found[mistake.path], confusion.classes)
        yield "</div>\n"
    yield foot()


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
