"""Which verdicts differ between two tables of results of the same scenes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from facetlog.batch.output import read_rows
from facetlog.batch.rows import Row
from facetlog.batch.settings import CRISP, Item, Settings, parse_read_as
from facetlog.errors import InputError
from facetlog.plain_text import plain_text
from facetlog.plurals import many

DEGREE_STEP = 0.005
"""Degrees that differ by less are the same in any text: they are given in per cent."""


@dataclass(frozen=True, slots=True)
class Change:
    """A verdict on a thing in both tables; empty where one of them says nothing of it."""

    path: str
    model: str
    thing: str
    before: str
    now: str

    def to_json(self) -> dict[str, Any]:
        """Return the change as plain data."""
        return {
            "path": self.path,
            "model": self.model,
            "thing": self.thing,
            "before": self.before or None,
            "now": self.now or None,
        }


def read_older_rows(path: Path) -> dict[str, Row]:
    """Return the rows of a table by path; raise InputError if it cannot be read or has none."""
    rows = {row["path"]: row for row in read_rows(path)}
    if not rows:
        raise InputError(f"{path}: has no rows to compare with")
    return rows


def is_table_crisp(old: Mapping[str, Row]) -> bool:
    """Return whether the rows of an older table, which has some, were all judged with --crisp."""
    return bool(old) and all(row["read_as"].split()[-1:] == [CRISP] for row in old.values())


def keep_older_options(
    items: Sequence[Item], old: Mapping[str, Row], *, up: bool, unit: bool
) -> tuple[Item, ...]:
    """Return the items with the options that their older rows tell, but for `up` or `unit` if
    given.
    """
    return tuple(
        item
        if (row := old.get(plain_text(item.path))) is None
        else _as_then(item, row, up=up, unit=unit)
        for item in items
    )


def _as_then(item: Item, row: Row, *, up: bool, unit: bool) -> Item:
    then_up, then_unit = parse_read_as(row["read_as"])
    return replace(
        item,
        up=item.up if up or item.up else then_up,
        unit=item.unit if unit or item.unit else then_unit,
        override=item.override or "override" in row["read_as"].split() or None,
    )


def check_same_options(items: Sequence[Item], settings: Settings, old: Mapping[str, Row]) -> None:
    """Raise InputError if none of the scenes of older rows is read as then: nothing to compare."""
    pairs = [
        (row["read_as"], item.read_as(settings))
        for item in items
        if (row := old.get(plain_text(item.path))) is not None
    ]
    if pairs and all(then != now for then, now in pairs):
        then, now = pairs[0]
        raise InputError(
            f"--changed-since: all scenes were read with other options: {then}, now {now}: leave "
            "those out, to have them as then"
        )


@dataclass(slots=True)
class Comparison:
    """Rows compared with the older ones of the same path; filled row by row.

    Rows that were read with other options are not compared, only counted: `otherwise`.
    """

    old: Mapping[str, Row]
    changes: list[Change] = field(default_factory=list)
    compared: int = 0
    otherwise: int = 0
    new: int = 0

    def add(self, row: Row) -> None:
        """Compare a row with the older one of its scene, if there is one."""
        before = self.old.get(plain_text(row["path"]))
        if before is None:
            self.new += 1
            return
        if before["read_as"] != row["read_as"]:
            self.otherwise += 1
            return
        self.compared += 1
        self.changes.extend(_changes(before, row))

    def lines(self) -> Iterator[str]:
        """Yield the changes as text, by scene."""
        last = ""
        for change in self.changes:
            if change.path != last:
                last = change.path
                yield last
            subject = " ".join(filter(None, (change.model, change.thing)))
            yield f"  {subject}: {change.before or '–'} → {change.now or '–'}"
        scenes = len({change.path for change in self.changes})
        verdicts = many(len(self.changes), "verdict")
        differ = "differs" if len(self.changes) == 1 else "differ"
        said = f"{verdicts} of {many(scenes, 'scene')} {differ}, of {self.compared} compared"
        new = f"; {many(self.new, 'scene is', 'scenes are')} new" if self.new else ""
        yield said + new
        if self.otherwise:
            were = many(self.otherwise, "scene was", "scenes were")
            yield f"{were} read with other options than then, and not compared"

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return {
            "compared": self.compared,
            "read_otherwise": self.otherwise,
            "new": self.new,
            "changes": [change.to_json() for change in self.changes],
        }


def _changes(before: Row, now: Row) -> Iterator[Change]:
    path = now["path"]
    if before["error"] or now["error"]:
        if before["error"] != now["error"]:
            yield Change(path, "", "", before["error"] or "verdicts", now["error"] or "verdicts")
        return
    then = {(v["thing"], v["model"]): v for v in before["verdicts"]}
    here = {(v["thing"], v["model"]): v for v in now["verdicts"]}
    for key in dict.fromkeys((*then, *here)):
        old, new = then.get(key), here.get(key)
        if old is None or new is None or _differ(old, new):
            thing, model = key
            yield Change(path, model, thing, _said(old), _said(new))


def _differ(old: Row, new: Row) -> bool:
    bounds = ("degree", "degree_at_most")
    return old["state"] != new["state"] or any(
        abs(old[bound] - new[bound]) >= DEGREE_STEP for bound in bounds
    )


def _said(verdict: Row | None) -> str:
    """Return a verdict in a word: 'holds 93 %', 'unknown 0–87 %'."""
    if verdict is None:
        return ""
    low, high = 100 * verdict["degree"], 100 * verdict["degree_at_most"]
    degree = f"{low:.3g} %" if high - low < 100 * DEGREE_STEP else f"{low:.3g}–{high:.3g} %"
    return f"{verdict['state']} {degree}"
