"""A verdict as a reader wants it: what it is, and for each condition the reason in one line.

No line is longer than `WIDTH`: what would be is written without what a reader misses least.
"""

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from facetlog.kb.explaining.amounts import choose_unit_for, deviation, measured
from facetlog.kb.explaining.margins import margin
from facetlog.kb.explaining.measure_words import describe_height, replace_faces_by_roles
from facetlog.kb.explaining.near import format_nearest
from facetlog.kb.explaining.proof import MARKS, Comparison, Nearness, Note, State
from facetlog.kb.explaining.reasons import reason
from facetlog.kb.explaining.trace import trace
from facetlog.kb.explaining.wording import (
    CAUSES,
    UNSEEN,
    add_article,
    count_members,
    listed,
    runs,
)

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Condition, Part, Verdict

__all__ = [
    "NO_MODEL",
    "WIDTH",
    "format_holding",
    "format_origin",
    "format_parts",
    "format_sizes",
    "format_summary_line",
    "iter_miss_lines",
    "iter_verdict_lines",
    "mark",
    "summary",
]

WIDTH = 100
"""Characters of a line, except where the author's own words are longer."""

LEAST_ASSUMED = 0.005
"""Least share of unseen space that is mentioned: less would be written as 0 %."""

NO_MODEL = "no model matches"
"""Text where nothing holds."""

# A degree that is written as 100 % says nothing that the verdict does not.
CERTAIN = 0.995

# So many other things are named where a part is missing, the nearest.
OTHERS_SHOWN = 4

# What leaves several conditions open is said once for all of them.
LAPSED = "~"
"""Stands before what a model expects, and is not so: it lowers the degree, and fails nothing."""

_OF_SEVERAL = CAUSES | {UNSEEN: "a part that they need was not seen"}


def format_holding(best: Iterable[str]) -> str:
    """Return a sentence for each verdict that holds, on one line; that no model matches where there
    is none."""
    return "; ".join(best) or NO_MODEL


def summary(verdict: "Verdict") -> str:
    """Return one sentence: what it is, or why it is not, or what is missing."""
    return _list_summaries(verdict)[0]


def format_summary_line(verdict: "Verdict") -> str:
    """Return the summary on one line."""
    return _choose_fitting_text(_list_summaries(verdict))


def _list_summaries(verdict: "Verdict") -> tuple[str, ...]:
    """Return the summaries, the fullest first, then with less and less."""
    one = add_article(verdict.model)
    if not verdict.thing:
        return (f"nothing was found that could be {one}",)
    if verdict.state is State.HOLDS:
        which = listed(tuple(map(add_article, verdict.specialises)))
        general = f", which is {which}" if verdict.specialises else ""
        said = f"{verdict.thing} is {one}"
        sure = f"({verdict.confidence.format(verdict.degree)})"
        return f"{said}{general} {sure}", f"{said} {sure}"
    if verdict.state is State.UNKNOWN:
        head = f"{verdict.thing}: {verdict.model} is unknown"
        return tuple(f"{head}{why}" for group in _list_reason_groups(verdict) for why in group)
    holding = len(verdict.list_conditions_in_state(State.HOLDS))
    head = f"{verdict.thing} is no {verdict.model}"
    counts = f" ({holding} of {len(verdict.conditions)} conditions hold)"
    return tuple(
        f"{head}{why}{end}"
        for group in _list_reason_groups(verdict)
        for why in group
        for end in (counts, "")
    )


def _list_reason_groups(verdict: "Verdict") -> tuple[tuple[str, ...], ...]:
    """Return why a verdict does not hold: groups of texts from the longest to the shortest.

    It is the condition that the least change would turn, and by how much: the number is the last
    to be left out.
    """
    parts = [part for part in verdict.parts if not part.is_group]
    unseen = [part.role for part in parts if not part.faces]
    if not parts:
        return ((": no face of it was measured",),)
    if verdict.state is State.UNKNOWN and len(unseen) == len(parts):
        roles = " or ".join(unseen)
        return (f": nothing was measured that could be its {roles}",), (": no part was measured",)
    if unseen and any(
        _open_because(c, UNSEEN) for c in verdict.list_conditions_in_state(verdict.state)
    ):
        seen = len(parts) - len(unseen)
        if all(len(role) > 1 for role in unseen):
            return ((f": nothing was measured that could be its {' or '.join(unseen)}",),)
        were = "was" if seen == 1 else "were"
        return ((f": only {seen} of the {len(parts)} parts that it needs {were} measured",),)
    line, *_ = _sort_by_change(verdict, verdict.state)
    known = "; open: " if verdict.state is State.UNKNOWN else "; fails: "
    # Letters for parts that are alike say less than the names, which pictures show.
    played = {part.faces[0]: part.role for part in parts if part.faces and len(part.role) > 1}
    texts = tuple(
        replace_faces_by_roles(text, played)
        for text in _list_reason_texts(line, verdict.length_unit)
    )
    whole = tuple(f"{known}{line.said} – {text}" for text in texts)
    labelled = tuple(f"{known}{line.label} – {text}" for text in texts)
    said = (f"{known}{line.said}",)
    found = reason(line.proof)
    is_measured = found is not None and isinstance(found.step.detail, Comparison)
    shorter = (labelled, said) if is_measured else (said, labelled)
    return (whole, *shorter, (f"{known}{line.label}",))


def iter_verdict_lines(verdict: "Verdict", *, full: bool = False) -> Iterator[str]:
    """Return the verdict as text: parts, sizes and conditions, with `full` the whole proof of each.

    Where members of sets are asked about, these come first, and of the rest only its first lines.
    Conditions that hold because they do not apply to such a thing are counted. Where the verdict
    does not hold, all that hold are.
    """
    for member in verdict.asked:
        yield _choose_fitting_text(member.texts(verdict.length_unit))
        yield from (f"  {line}" for line in trace(member.proof, verdict.length_unit))
    yield summary(verdict) if full else format_summary_line(verdict)
    if verdict.state is State.HOLDS and (origin := format_origin(verdict)):
        yield from _wrap_line(f"  {origin}")
    if verdict.parts:
        yield from _iter_part_lines(verdict, full=full)
    if verdict.asked and not full:
        return
    if verdict.sizes:
        yield from _sizes(verdict)
    if full:
        yield from _iter_assumed_lines(verdict)
        for line in verdict.conditions:
            said = f"{line.label}: {line.said} ({line.proof.low:.0%}){line.origin}"
            yield f"  {MARKS[line.proof.state]} {said}"
            for step in trace(line.proof, verdict.length_unit):
                yield f"      {step}"
        yield from _iter_unseen_lines(verdict)
    elif verdict.state is State.HOLDS:
        reasons = [(c, found) for c in verdict.conditions if (found := reason(c.proof)) is not None]
        yield from _iter_conditions((line for line, _ in reasons), verdict.length_unit)
        unsaid = len(verdict.conditions) - len(reasons)
        if unsaid:
            more = " more" if reasons else ""
            yield f"  + {unsaid}{more} condition{'s hold' if unsaid > 1 else ' holds'}"
    else:
        yield from _iter_open_lines(verdict)


def iter_miss_lines(verdict: "Verdict") -> Iterator[str]:
    """Return why this assignment does not hold: one head line, then only what fails or is open.

    For example 't1 is no table with top = f3: 1 of 8 conditions fails'.
    """
    counts = {state: len(verdict.list_conditions_in_state(state)) for state in State}
    fails, unknown = counts[State.FAILS], counts[State.UNKNOWN]
    of_all = f" of {len(verdict.conditions)} conditions"
    said = []
    if fails:
        said.append(f"{fails}{of_all} fail{'s' * (fails == 1)}")
    if unknown:
        said.append(f"{unknown}{'' if fails else of_all} {'is' if unknown == 1 else 'are'} unknown")
    one = add_article(verdict.model)
    known = f"is no {verdict.model}" if fails else f"may be {one}" if unknown else f"is {one}"
    end = f": {', '.join(said) or 'all hold'}"
    head = f"{verdict.thing} {known}"
    named = tuple(f"{head} with {parts}{end}" for parts in _named(verdict.parts, ", "))
    yield _choose_fitting_text((*named, f"{head}{end}"))
    yield from _iter_open_lines(verdict)


def _iter_open_lines(verdict: "Verdict") -> Iterator[str]:
    """Return what fails, what is open (the least change first), then what holds."""
    for state in (State.FAILS, State.UNKNOWN):
        lines = _sort_by_change(verdict, state)
        for cause, why in _OF_SEVERAL.items():
            same = [line for line in lines if _open_because(line, cause)]
            if len(same) > 1:
                lines = [line for line in lines if line not in same]
                which = listed([line.label for line in same])
                yield from _wrap_line(f"  ? {which}: not known, because {why}")
        yield from _iter_conditions(lines, verdict.length_unit)
    if verdict.others:
        shown = tuple(map(str, verdict.others[:OTHERS_SHOWN]))
        more = " …" if len(verdict.others) > len(shown) else ""
        yield from _wrap_line(f"  other objects near it: {', '.join(shown)}{more}")
    yield from _iter_unseen_lines(verdict)
    held = verdict.list_conditions_in_state(State.HOLDS)
    labels = [c.label for c in held if reason(c.proof) is not None]
    if held:
        more = f" (+ {len(held) - len(labels)} more)" if len(held) > len(labels) else ""
        count = f"  + {len(held)} condition{'s hold' if len(held) > 1 else ' holds'}"
        named = (f"  + holds: {', '.join(labels)}{more}",) if labels else ()
        yield _choose_fitting_text((*named, count))


def _iter_conditions(lines: "Iterable[Condition]", length_unit: str | None) -> Iterator[str]:
    """Return the conditions with the reasons for their states, each reason once."""
    given: set[tuple[str, ...]] = set()
    for line in lines:
        texts = _list_reason_texts(line, length_unit)
        if texts in given:
            yield _format_condition(line, ("for the same reason",))
        else:
            yield from _iter_condition_lines(line, texts, length_unit)
        given.add(texts)


def _iter_condition_lines(
    line: "Condition", texts: tuple[str, ...], length_unit: str | None
) -> Iterator[str]:
    """Return the condition and the reason for its state: the whole of one that fails, is open, or
    compares a measure with limits, which may take a line of its own."""
    found = reason(line.proof)
    compares = found is not None and isinstance(found.step.detail, Comparison)
    if line.proof.state is State.HOLDS and not compares:
        yield _format_condition(line, texts)
        return
    in_one = _format_condition(line, texts[:1])
    if line.said in in_one and texts[0] in in_one:
        yield in_one
    else:
        yield _format_condition(line, ())
        yield _choose_fitting_text(f"      {text}" for text in texts)
    nearest = format_nearest(line.nearest, length_unit)
    if nearest:
        yield _choose_fitting_text(f"      {text}" for text in nearest)


def _open_because(line: "Condition", cause: str) -> bool:
    """Return whether what decides a condition is not known for this cause."""
    found = reason(line.proof)
    step = None if found is None else found.step.detail
    return isinstance(step, Note) and step.cause == CAUSES[cause]


def _iter_assumed_lines(verdict: "Verdict") -> Iterator[str]:
    """Return how much of its space nobody saw, and what it counts as."""
    if verdict.assumed >= LEAST_ASSUMED:
        yield from _wrap_line(
            f"  space: {verdict.assumed:.0%} of what {verdict.thing} fills was not seen; it lies "
            "behind what was, and counts as full"
        )


def _iter_unseen_lines(verdict: "Verdict") -> Iterator[str]:
    """Return why parts may have been missed, and from where they could be seen."""
    roles = verdict.unseen_roles
    for found in verdict.unseen:
        for line in found.lines(roles):
            yield from _wrap_line(f"  {line}")
        roles = ()


def _wrap_line(line: str) -> list[str]:
    """Return the line, and what has no room on it beneath it."""
    return textwrap.wrap(line, WIDTH, subsequent_indent=" " * 6)


def _sort_by_change(verdict: "Verdict", state: State) -> "list[Condition]":
    """Return the conditions of this state: first those that miss a part, then those that the least
    change would turn.

    That of one value that turns the whole verdict, which several conditions may ask, comes before
    all others; conditions that no one value turns come last.
    """
    whole = margin(verdict) if state is verdict.state else None

    def rank_by_change(line: "Condition") -> tuple[bool, bool, bool, Nearness]:
        found = margin(replace(verdict, conditions=(line,)))
        decides = whole is not None and whole.label == line.label
        nearness = (False, 0.0) if found is None else found.nearness
        return (not line.misses_part, not decides, found is None, nearness)

    return sorted(verdict.list_conditions_in_state(state), key=rank_by_change)


def _format_condition(line: "Condition", texts: tuple[str, ...]) -> str:
    """Return the condition and the reason for its state, as far as there is room."""
    head = f"  {mark(line)} {line.label}"
    asks = "" if line.said == line.label else f": {line.said}"
    sure = line.proof.low >= CERTAIN or line.proof.state is not State.HOLDS
    degree = "" if sure else f" ({line.proof.low:.0%})"
    place = f" [{line.place}]" if line.place else ""
    whole = [f"{head}{asks}{degree} – {text}" for text in texts] or [f"{head}{asks}{degree}"]
    short = [f"{head}{degree} – {text}" for text in texts]
    return _choose_fitting_text((f"{whole[0]}{place}", *whole, *short, f"{head}{degree}"))


def mark(line: "Condition") -> str:
    """`+` before what holds, `-` fails, `?` is open; `~` before what is expected and not so."""
    return LAPSED if _is_lapsed(line) else MARKS[line.proof.state]


def _is_lapsed(line: "Condition") -> bool:
    """Return whether a condition holds though what it expects is not so."""
    found = reason(line.proof)
    holds = line.proof.state is State.HOLDS
    return holds and found is not None and found.is_wanted and found.step.state is State.FAILS


def _list_reason_texts(line: "Condition", length_unit: str | None) -> tuple[str, ...]:
    found = reason(line.proof)
    return ("it does not apply to such a thing",) if found is None else found.texts(length_unit)


def format_origin(verdict: "Verdict") -> str:
    """Return where the confidence comes from, or why there is none; empty where none was asked
    for."""
    confidence = verdict.confidence
    if confidence.value is not None:
        return f"confidence: {confidence.origin}"
    return f"no confidence: {confidence.reason}" if confidence.reason else ""


def format_parts(verdict: "Verdict") -> str:
    """Return which faces play which parts, all of them: 'top = f1; leg = f2, f3'."""
    return _named(verdict.parts, "; ")[0]


def _iter_part_lines(verdict: "Verdict", *, full: bool) -> Iterator[str]:
    named = [f"  parts: {parts}" for parts in _named(verdict.parts, "; ")]
    yield named[0] if full else _choose_fitting_text(named)


def _named(parts: Iterable["Part"], between: str) -> tuple[str, ...]:
    """Return parts with their faces, from the longest text to the shortest.

    First each face, then those that follow one another as one, then their number, then no parts
    that are groups.
    """
    parts = tuple(parts)
    if not parts:
        return ("no part",)
    many = [p for p in parts if len(p.faces) > 1]
    ranges = {p: f"{p.role} = {runs(p.faces, ', ')}" for p in many}
    counts = {p: f"{p.role} = {count_members(p.faces)}" for p in many}
    forms = tuple(between.join(form.get(p, str(p)) for p in parts) for form in ({}, ranges, counts))
    single = [str(part) for part in parts if not part.is_group]
    return (*forms, between.join(single)) if single else forms


def format_sizes(verdict: "Verdict") -> tuple[str, ...]:
    """Return the sizes, each in a unit of its own, in which its deviation can be read as well.

    Of heights, of which a thing has several, it is said what they are the height of.
    """
    said = []
    for size in verdict.sizes:
        unit = choose_unit_for(verdict.length_unit or "", size.value, size.sd)
        value, sd = unit.of(size.value), size.sd / unit.size
        number, spread = measured(value, sd), deviation(value, sd)
        name = f" {unit.name}" if unit.name else ""
        which = f" ({words})" if (words := describe_height(size.measure)) else ""
        said.append(f"{size.name} {number}{f' ± {spread}' if spread else ''}{name}{which}")
    if said and not verdict.length_unit:
        said[-1] += " (units of the scene)"
    return tuple(said)


def _sizes(verdict: "Verdict") -> Iterator[str]:
    first, *others = format_sizes(verdict)
    text = f"  sizes: {first}"
    for one in others:
        if len(text) + len(f", {one},") > WIDTH:
            yield f"{text},"
            text = f"{' ' * len('  sizes:')} {one}"
        else:
            text += f", {one}"
    yield text


def _choose_fitting_text(texts: Iterable[str]) -> str:
    """Return the first text that fits on a line; of none the shortest."""
    found = tuple(texts)
    return next((text for text in found if len(text) <= WIDTH), min(found, key=len))
