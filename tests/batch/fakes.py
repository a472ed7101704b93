"""Pools whose workers are tests/batch/fake_worker.py, and files for them."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from facetlog.batch import pool
from facetlog.batch.settings import Item

PROGRAM = str(Path(__file__).with_name("fake_worker.py"))


@contextmanager
def fake_workers() -> Iterator[None]:
    """Within it, pools start the fake program."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pool, "WORKER", (sys.executable, "-S", PROGRAM))
        yield


def scene_files(folder: Path, *names: str) -> tuple[Item, ...]:
    """Items of files of these names, each with its name as content."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / f"{name}.json").write_text(name)
    return tuple(Item(str(folder / f"{name}.json")) for name in names)
