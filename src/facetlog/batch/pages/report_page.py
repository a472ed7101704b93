"""The parts of the report as HTML: figures, the confusion matrix, and a card for each mistake."""

import html
from collections.abc import Iterator, Sequence
from importlib.resources import files
from typing import TypedDict

from facetlog import __version__
from facetlog.batch.confusion import Confusion, Mistake, Proportion
from facetlog.batch.outcome import Outcome
from facetlog.batch.pages.explain import Reason
from facetlog.batch.rows import HOLDS, Row, closest, sureness
from facetlog.counted import many
from facetlog.page.policy import head_lines
from facetlog.terminal import printable

__all__ = ["Explanation", "card", "foot", "group_head", "head"]

ERRORS_LISTED = 200
"""Scenes with errors that the page lists; the table of results has them all."""

SHADE_LEAST, SHADE_MOST = 0.10, 0.45
"""Opacity of a cell of the matrix with few and with all of its row."""


class Explanation(TypedDict):
    """What explain.py says of a mistake: a PNG in base64, and reasons."""

    picture: str | None
    reasons: list[Reason]


def _escaped(text: str, *, quote: bool = True) -> str:
    """The text as HTML, without control characters that names of files and labels may hold."""
    return html.escape("\n".join(map(printable, text.split("\n"))), quote)


def head(outcome: Outcome, confusion: Confusion) -> Iterator[str]:
    """The page down to the mistakes."""
    style = files("facetlog.batch.pages").joinpath("report.css").read_text(encoding="utf-8")
    yield (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"{head_lines(version=__version__)}\n"
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>facetlog classify</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
    )
    yield "<h1>What was recognised</h1>\n"
    yield f'<p class="soft">{_escaped(outcome.summary)}</p>\n'
    yield from _figures(outcome, confusion)
    yield from _matrix(confusion)
    yield from _shares(confusion)
    yield from _left_out(confusion)
    yield from _errors(outcome)
    yield f'<h2 id="wrong">What went wrong ({len(confusion.mistakes)})</h2>\n'


def _figures(outcome: Outcome, confusion: Confusion) -> Iterator[str]:
    accuracy = confusion.accuracy
    value = "–" if accuracy.value is None else f"{accuracy.value:.1%}"
    interval = accuracy.interval
    spread = "" if interval is None else f", 95 % within {interval[0]:.1%}–{interval[1]:.1%}"
    failed = len(outcome.errors)
    yield '<div class="figures">\n'
    yield _figure(value, f"accuracy: {accuracy.hits} of {accuracy.of}{spread}")
    yield _figure(str(outcome.scenes), "scene" if outcome.scenes == 1 else "scenes")
    yield _figure(str(len(confusion.mistakes)), "answered wrong")
    yield _figure(str(failed), "with an error" if failed == 1 else "with errors")
    yield "</div>\n"


def _figure(value: str, about: str) -> str:
    said = f'<b>{_escaped(value)}</b><span class="soft">{_escaped(about)}</span>'
    return f'<div class="figure">{said}</div>\n'


def _matrix(confusion: Confusion) -> Iterator[str]:
    yield '<h2>Right and answered</h2>\n<div class="scroll"><table>\n'
    yield "<thead><tr><th>right \\ answered</th>"
    yield "".join(f"<th>{_escaped(name)}</th>" for name in confusion.columns)
    yield "<th>all</th></tr></thead>\n<tbody>\n"
    for right in confusion.rows:
        total = sum(confusion.counts[right, given] for given in confusion.columns)
        yield f"<tr><th>{_escaped(right)}</th>"
        for given in confusion.columns:
            yield _cell(confusion.counts[right, given], total, right, given)
        yield f'<td class="soft">{total}</td></tr>\n'
    yield "</tbody></table></div>\n"


def _cell(count: int, total: int, right: str, given: str) -> str:
    if not count:
        return '<td class="soft">·</td>'
    shade = SHADE_LEAST + (SHADE_MOST - SHADE_LEAST) * count / total
    colour = "--good" if right == given else "--bad"
    style = f'style="background: rgb(var({colour}) / {shade:.2f})"'
    if right == given:
        return f"<td {style}>{count}</td>"
    return f'<td {style}><a href="#{_anchor(right, given)}">{count}</a></td>'


def _anchor(right: str, given: str) -> str:
    return _escaped(f"{right}-as-{given}")


def _shares(confusion: Confusion) -> Iterator[str]:
    yield "<h2>Class by class</h2>\n"
    yield '<div class="scroll"><table class="shares">\n'
    yield "<thead><tr><th>class</th><th>recall</th><th>precision</th></tr></thead>\n<tbody>\n"
    for name in confusion.rows:
        recall, precision = confusion.recall(name), confusion.precision(name)
        cells = f"<td>{_bar(recall)}</td><td>{_bar(precision)}</td>"
        yield f"<tr><th>{_escaped(name)}</th>{cells}</tr>\n"
    yield "</tbody></table></div>\n"
    for kind, share in confusion.kinds():
        about = f"Of kind {kind or '(none)'}: accuracy {share}"
        yield f'<p class="soft">{_escaped(about)}</p>\n'


def _bar(share: Proportion) -> str:
    if share.value is None:
        return "–"
    width = round(100 * share.value)
    about = f"{share.value:.1%} <span class=soft>({share.hits} of {share.of})</span>"
    return f'<span class="bar"><i style="width: {width}%"></i></span>{about}'


def _left_out(confusion: Confusion) -> Iterator[str]:
    if confusion.left_out:
        counts = sorted(confusion.left_out.items())
        listed = ", ".join(f"{label} → {given} ({n})" for (label, given), n in counts)
        yield f'<p class="soft">Not counted: {_escaped(listed)}</p>\n'
    if confusion.unlabelled:
        yield f'<p class="soft">Without a label: {confusion.unlabelled}</p>\n'


def _errors(outcome: Outcome) -> Iterator[str]:
    if not outcome.errors:
        return
    yield f'<h2>Errors ({len(outcome.errors)})</h2>\n<ul class="errors">\n'
    for path, error in outcome.errors[:ERRORS_LISTED]:
        said = error.removeprefix(f"{path}: ")
        yield f'<li><span class="path">{_escaped(path)}</span>: {_escaped(said)}</li>\n'
    more = len(outcome.errors) - ERRORS_LISTED
    yield (f"<li>and {more} more</li>\n" if more > 0 else "") + "</ul>\n"


def group_head(right: str, given: str, count: int) -> str:
    """What comes before the cards of one kind of mistake."""
    title = f"right: {_escaped(right)}, answered: {_escaped(given)} ({count})"
    return f'<h3 id="{_anchor(right, given)}">{title}</h3>\n<div class="cards">\n'


def card(mistake: Mistake, row: Row, explanation: Explanation, classes: Sequence[str]) -> str:
    """One mistake: its picture, what it is and was taken for, all verdicts, and the reasons."""
    picture = explanation["picture"]
    if picture is None:
        shown = '<div class="nothing">no picture</div>'
    else:
        about = _escaped(f"picture of {mistake.path}", quote=True)
        shown = f'<img alt="{about}" loading="lazy" src="data:image/png;base64,{picture}">'
    answered = f"<b>{_escaped(mistake.answered)}</b>{mistake.percentage}"
    counts = (
        ""
        if row["faces"] is None
        else f" · {many(row['faces'], 'face')}, {many(row['things'], 'thing')}"
    )
    said = (mistake.error or "").removeprefix(f"{mistake.path}: ")
    error = f"<p>{_escaped(said)}</p>" if said else ""
    return (
        f'<article class="card">{shown}<div class="about">'
        f'<p class="path">{_escaped(mistake.path)}</p>'
        f"<p>right: <b>{_escaped(mistake.label)}</b>, answered: {answered}"
        f'<span class="soft">{_escaped(counts)}</span></p>{error}'
        f"<p>{''.join(_chips(row, mistake, classes))}</p>"
        f"{''.join(map(_reason, explanation['reasons']))}</div></article>\n"
    )


def _chips(row: Row, mistake: Mistake, classes: Sequence[str]) -> Iterator[str]:
    """A chip for each model: its nearest thing; models of the mistake first."""
    best = closest(row)
    for model in sorted(best, key=lambda name: name not in classes):
        verdict = best[model]
        holds = verdict["state"] == HOLDS
        kind = ("wrong" if model == mistake.answered else "holds") if holds else ""
        state = f"{sureness(verdict):.0%}" if holds else verdict["state"]
        yield f'<span class="chip {kind}">{_escaped(model)} {_escaped(state)}</span>'


def _reason(reason: Reason) -> str:
    text = _escaped("\n".join(reason["lines"]))
    return f"<details><summary>{_escaped(reason['title'])}</summary><pre>{text}</pre></details>"


def foot() -> str:
    """The end of the page."""
    return f"<footer>Made by facetlog {__version__}</footer>\n</body>\n</html>\n"
