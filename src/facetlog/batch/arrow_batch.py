"""Tables of scenes into tables of rows, for programs that distribute tables themselves.

The work is done by a process with an engine of its own, as on one machine, so that limits, retries
and rows are the same. It is kept for the next table.
"""

import atexit
import json
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from facetlog.batch.memory import compute_share_mb
from facetlog.batch.output import import_pyarrow, make_arrow_table
from facetlog.batch.pool import Pool, Task
from facetlog.batch.rows import Row, error_row
from facetlog.batch.settings import Item, Settings
from facetlog.errors import InputError
from facetlog.kb.recognize import list_rule_files

if TYPE_CHECKING:
    import pyarrow

Arrow: TypeAlias = "pyarrow.Table | pyarrow.RecordBatch"

OPTIONAL = {"up": "string", "unit": "string", "override": "bool"}
"""Columns besides `path`, and their types: what an Item has of its own."""

NO_PATH = "a row of the table has no path: give one, or leave the row out"

# Processes of this process that wait for work, by what they were opened for, latest last.
_idle: list[tuple[object, Pool]] = []
_lock = threading.Lock()


@contextmanager
def borrow_pool(settings: Settings) -> Iterator[Pool]:
    """Return a process with an engine for these settings: one that nobody uses, or a new one.

    As many are kept as the machine has cores.
    """
    key = (settings, _stamp_models(settings))
    with _lock:
        found = next((each for each in reversed(_idle) if each[0] == key), None)
        if found is not None:
            _idle.remove(found)
    pool = found[1] if found is not None else Pool(settings)
    try:
        yield pool
    except BaseException:
        pool.close()
        raise
    with _lock:
        _idle.append((key, pool))
        surplus = _idle.pop(0)[1] if len(_idle) > len(os.sched_getaffinity(0)) else None
    if surplus is not None:
        surplus.close()


@atexit.register
def close_idle_pools() -> None:
    """End the processes that are kept."""
    while _idle:
        _idle.pop()[1].close()


def _forget_pools() -> None:
    """Leave the parent's processes to it: a forked process must neither use nor end them."""
    _idle.clear()
    _lock.release()


os.register_at_fork(
    before=_lock.acquire, after_in_parent=_lock.release, after_in_child=_forget_pools
)


def _stamp_models(settings: Settings) -> tuple[object, ...]:
    """Return what changes when a file of the models, or one beside it that it may need, does."""
    named = map(Path, settings.models)
    folders = dict.fromkeys(path if path.is_dir() else path.parent for path in named)
    files = [file for folder in folders if folder.is_dir() for file in list_rule_files(folder)]
    stats = [(file, file.stat()) for file in files if file.exists()]
    return tuple((file, stat.st_mtime_ns, stat.st_size) for file, stat in stats)


def classify_arrow(table: "Arrow", settings: Settings) -> "Arrow":
    """Return the rows of a table's scenes, in its order, as `classify -o` writes them to Parquet.

    Raise InputError for a table that cannot be used.
    """
    pyarrow = import_pyarrow("classify_batch")
    if not isinstance(table, pyarrow.Table | pyarrow.RecordBatch):
        raise InputError(
            f"classify_batch: a {type(table).__name__} is no pyarrow.Table or RecordBatch: convert "
            "it (pyarrow.table, pyarrow.Table.from_pandas)"
        )
    kind = type(table)
    items = _read_items(table)
    if not items:  # as who asks for the schema gives it
        return make_arrow_table([], kind)
    if settings.memory_mb is None:
        share = compute_share_mb(len(os.sched_getaffinity(0)))
        settings = replace(settings, memory_mb=share)
    with borrow_pool(settings) as pool:
        tasks = [Task(item) for item in dict.fromkeys(items) if item.path]
        rows: dict[Item, Row] = {
            answer.task.item: json.loads(answer.line) for answer in pool.answers(tasks)
        }
        without = {"models_hash": pool.models_hash}
    return make_arrow_table(
        [rows.get(item) or error_row(item, settings, NO_PATH, **without) for item in items], kind
    )


def _read_items(table: "Arrow") -> list[Item]:
    if "path" not in table.column_names:
        names = ", ".join(map(str, table.column_names)) or "none"
        raise InputError(
            f"classify_batch: the table has no column `path` (columns: {names:.200}): rename the "
            "one with the paths of the scenes"
        )
    columns = {"path": _read_column(table, "path", "string")} | {
        name: _read_column(table, name, kind)
        for name, kind in OPTIONAL.items()
        if name in table.column_names
    }
    columns["path"] = [path or "" for path in columns["path"]]
    return [
        Item(**dict(zip(columns, cells, strict=True)))
        for cells in zip(*columns.values(), strict=True)
    ]


def _read_column(table: "Arrow", name: str, kind: str) -> list[Any]:
    """Return the values of a column; InputError unless it is there once, as text or as flags."""
    import pyarrow

    if table.column_names.count(name) > 1:
        raise InputError(f"classify_batch: the table has two columns `{name}`: leave one out")
    column = table.column(name)
    given = column.type.value_type if pyarrow.types.is_dictionary(column.type) else column.type
    wanted = pyarrow.string() if kind == "string" else pyarrow.bool_()
    texts = (pyarrow.string(), pyarrow.large_string(), pyarrow.string_view())
    if given not in (pyarrow.null(), *(texts if kind == "string" else (wanted,))):
        raise InputError(f"classify_batch: the column `{name}` is {given}: make it {kind}")
    values: list[Any] = column.to_pylist()
    return values
