"""What a worker may take of the memory, and what the processes that it starts may."""

from pathlib import Path

import pytest

from facetlog.batch import memory
from facetlog.batch.memory import memory_mb
from tests.kb.fresh import python


def test_a_container_has_its_own_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limit, none = tmp_path / "limit", tmp_path / "none"
    limit.write_text(f"{512 << 20}\n")
    none.write_text("max\n")
    monkeypatch.setattr(memory, "CONTAINER_LIMITS", (none, tmp_path / "absent", limit))
    assert memory_mb() == 512


def test_what_is_beyond_the_limit_is_not_had_and_what_is_left_is_known() -> None:
    run = python(
        "from facetlog.batch.memory import get_left_mb, limit_memory\n"
        "limit_memory(400)\n"
        "print(200 < get_left_mb() < 400)\n"
        "try:\n"
        "    bytearray(500 << 20)\n"
        "except MemoryError:\n"
        "    print('none')\n"
    )
    assert run.stdout == "True\nnone\n"
