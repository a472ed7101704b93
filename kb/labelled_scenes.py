"""Scenes with labels: a table of what models should say of them."""

import csv
import io
import logging
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TypeAlias

from facetlog.errors import InputError
from facetlog.kb.examples import Case, Expected
from facetlog.kb.explaining.proof import State
from facetlog.kb.loading.encode import Fact
from facetlog.safe_read import read_regular_text

__all__ = ["COLUMNS", "is_labelled_folder", "read_labelled_cases"]

COLUMNS = ("scene", "thing", "model", "expected")
"""Columns of the table's first line; `scene` may be called `file`, and `thing` left out, or its
cells empty."""

MOST_BYTES = 10_000_000
"""Size limit of a table: some hundred thousand labels. A larger file is none."""


_LOG = logging.getLogger(__name__)

SceneReader: TypeAlias = Callable[[Path], Iterable[Fact]]

TABLE = "expected.csv"
"""The table in a folder of labelled scenes."""

MISSPELT = 0.7
"""difflib's ratio above which a name is that of a tested model, misspelt: one letter of four."""

SIGNS = {"+": State.HOLDS, "-": State.FAILS}
"""Sign after a model's name in a file's: what the model should say of it."""

_NAME = re.compile(r"(\w+)([+-])")


def is_labelled_folder(path: Path, suffixes: Collection[str]) -> bool:
    """Return whether there is a folder with a table, or with files of these suffixes named NAME+…
    or NAME-….
    """
    try:
        return path.is_dir() and any(
            file.name == TABLE or _split_name(file, suffixes) is not None for file in path.iterdir()
        )
    except (OSError, ValueError):  # too long for a file's name, or with a NUL
        return False


def _split_name(file: Path, suffixes: Collection[str]) -> tuple[str, State] | None:
    """Return the model and the state that a file's name states."""
    match = _NAME.match(file.stem) if file.suffix.lower() in suffixes else None
    return None if match is None else (match[1], SIGNS[match[2]])


def read_labelled_cases(
    path: Path,
    facts: SceneReader,
    *,
    known: Iterable[str],
    on_demand: SceneReader | None = None,
    suffixes: Collection[str] = (".json",),
) -> tuple[Case, ...]:
    """Return the cases of a table in CSV; scene files are named beside it, and read by `facts` when
    asked.

    Of a folder it is the table `expected.csv` in it, without the lines of models not `known`; or,
    where there is none, its files of these `suffixes` are named after models: `NAME+….ply` should
    hold as NAME, `NAME-….ply` fail.

    `on_demand` makes the facts that `facts` leaves out. Raise InputError, with the line, for what
    is no such table, and for models not `known`.
    """
    models = frozenset(known)
    table = path / TABLE if path.is_dir() else path
    if table is not path and not table.exists():
        return _list_named_cases(path, facts, on_demand, models, suffixes)
    reader = csv.DictReader(io.StringIO(_text(table), newline=""))
    try:
        header = ["scene" if name == "file" else name for name in reader.fieldnames or ()]
        if len(set(header)) < len(header) or not (
            {"scene", "model", "expected"} <= set(header) <= set(COLUMNS)
        ):
            raise InputError(f"{table}:1: the first line should be {','.join(COLUMNS)}")
        reader.fieldnames = header
        rows = [(reader.line_num, row) for row in reader if any(row.values())]
    except csv.Error as exc:
        raise InputError(f"{table}:{reader.line_num}: {exc}") from exc
    if table is not path:
        _warn_of_others(path, [(row["model"] or "").strip() for _, row in rows], models)
        rows = [(line, row) for line, row in rows if (row["model"] or "").strip() in models]
    return tuple(_read_row(table, line, row, facts, on_demand, models) for line, row in rows)


def _list_named_cases(
    folder: Path,
    facts: SceneReader,
    on_demand: SceneReader | None,
    known: frozenset[str],
    suffixes: Collection[str],
) -> tuple[Case, ...]:
    try:
        named = {path: _split_name(path, suffixes) for path in sorted(folder.iterdir())}
    except OSError as exc:
        raise InputError(f"{folder} cannot be read: {exc.strerror or exc}") from exc
    stated = {path: name for path, name in named.items() if name is not None}
    _warn_of_others(folder, [model for model, _ in stated.values()], known)
    return tuple(
        _build_case(str(path), path, model, state, facts, on_demand)
        for path, (model, state) in stated.items()
        if model in known
    )


def _warn_of_others(folder: Path, models: Sequence[str], known: Collection[str]) -> None:
    """Warn of the files of a folder that are left out, though a model of almost that name is known.

    Raise InputError if no file is of a model that is tested.
    """
    others = [model for model in models if model not in known]
    if len(others) == len(models):
        raise InputError(
            f"{folder}: no file is of a model that is tested: list them in {TABLE} (first line "
            "file,model,expected), or name them MODEL+… (should hold) and MODEL-… (should fail)"
        )
    for name in sorted(set(others)):
        if near := get_close_matches(name, known, n=1, cutoff=MISSPELT):
            count = others.count(name)
            _LOG.warning("%s: left out (%d), %r: did you mean %s?", folder, count, name, near[0])


def _text(path: Path) -> str:
    try:
        return read_regular_text(path, MOST_BYTES)
    except OSError as exc:
        raise InputError(f"{path} cannot be read: {exc.strerror or exc}") from exc
    except UnicodeDecodeError as exc:
        raise InputError(f"{path} is no UTF-8 text: give a table in CSV") from exc


def _read_row(
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
    return _build_case(place, scene, cells["model"], state, facts, on_demand, thing)


def _build_case(
    place: str,
    file: Path,
    model: str,
    state: State,
    facts: SceneReader,
    on_demand: SceneReader | None,
    thing: str | None = None,
) -> Case:
    return Case(
        f"{file.name}{f' {thing}' if thing else ''}",
        place,
        model,
        Expected(state),
        str(file),
        lambda: facts(file),
        thing,
        None if on_demand is None else lambda: on_demand(file),
        file=file,
        is_labelled=True,
    )
