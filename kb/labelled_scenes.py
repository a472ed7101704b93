"""Scenes with labels: a table of what models should say of them."""

import csv
import io
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeAlias

from facetlog.errors import InputError
from facetlog.kb.examples import Case, Expected
from facetlog.kb.explaining.proof import State
from facetlog.kb.loading.encode import Fact
from facetlog.safe_read import read_regular_text

__all__ = ["COLUMNS", "read_labelled_cases"]

COLUMNS = ("scene", "thing", "model", "expected")
"""Columns of the table's first line; `thing` may be left out, or its cells empty."""

MOST_BYTES = 10_000_000
"""Size limit of a table: some hundred thousand labels. A larger file is none."""


SceneReader: TypeAlias = Callable[[Path], Iterable[Fact]]


def read_labelled_cases(
    path: Path,
    facts: SceneReader,
    *,
    known: Iterable[str],
    on_demand: SceneReader | None = None,
) -> tuple[Case, ...]:
    """Return the cases of a table in CSV; scene files are named beside it, and read by `facts` when
    asked.

    `on_demand` makes the facts that `facts` leaves out. Raise InputError, with the line, for what
    is no such table, and for models not `known`.
    """
    reader = csv.DictReader(io.StringIO(_text(path), newline=""))
    try:
        header = tuple(reader.fieldnames or ())
        if not {"scene", "model", "expected"} <= set(header) <= set(COLUMNS):
            raise InputError(f"{path}:1: the first line should be {','.join(COLUMNS)}")
        models = frozenset(known)
        return tuple(
            _build_case(path, reader.line_num, row, facts, on_demand, models)
            for row in reader
            if any(row.values())
        )
    except csv.Error as exc:
        raise InputError(f"{path}:{reader.line_num}: {exc}") from exc


def _text(path: Path) -> str:
    try:
        return read_regular_text(path, MOST_BYTES)
    except OSError as exc:
        raise InputError(f"{path} cannot be read: {exc.strerror or exc}") from exc
    except UnicodeDecodeError as exc:
        raise InputError(f"{path} is no UTF-8 text: give a table in CSV") from exc


def _build_case(
    path: Path,
    line: int,
    row: dict[str, str],
    facts: SceneReader,
    on_demand: SceneReader | None,
    known: frozenset[str],
) -> Case:
    place = f"{path}:{line}"
    # Too many cells stand under None, and missing ones are None.
    cells = {name: (row.get(name) or "").strip() for name in COLUMNS}
    if None in row or not cells["scene"]:
        raise InputError(
            f"{place}: there should be a cell for each column, and a scene in each line"
        )
    if cells["model"] not in known:
        raise InputError(f"{place}: there is no model {cells['model']!r} among those tested")
    try:
        state = State(cells["expected"])
    except ValueError:
        raise InputError(f"{place}: {cells['expected']!r} is none of {', '.join(State)}") from None
    scene = path.parent / cells["scene"]
    thing = cells["thing"] or None
    title = f"{cells['scene']}{f' {thing}' if thing else ''}"
    return Case(
        title,
        place,
        cells["model"],
        Expected(state),
        str(scene),
        lambda: facts(scene),
        thing,
        None if on_demand is None else lambda: on_demand(scene),
    )
