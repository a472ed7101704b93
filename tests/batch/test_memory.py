"""What a worker may take of the memory, and what the processes that it starts may."""

import resource
from pathlib import Path

import pytest

from facetlog.batch import memory
from facetlog.batch.memory import LEAST_MB, left_mb, memory_mb, share_mb, took_all
from tests.kb.fresh import python


def test_workers_share_four_fifths_and_none_gets_less_than_it_needs() -> None:
    assert share_mb(2, of_mb=10_000) == 4_000
    assert share_mb(1000, of_mb=10_000) == LEAST_MB
    assert share_mb(1) == pytest.approx(0.8 * memory_mb(), abs=1)


def test_a_container_has_its_own_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limit, none = tmp_path / "limit", tmp_path / "none"
    limit.write_text(f"{512 << 20}\n")
    none.write_text("max\n")
    monkeypatch.setattr(memory, "CONTAINER_LIMITS", (none, tmp_path / "absent", limit))
    assert memory_mb() == 512


def test_what_is_beyond_the_limit_is_not_had_and_what_is_left_is_known() -> None:
    run = python(
        "from facetlog.batch.memory import left_mb, limit_memory\n"
        "limit_memory(400)\n"
        "print(200 < left_mb() < 400)\n"
        "try:\n"
        "    bytearray(500 << 20)\n"
        "except MemoryError:\n"
        "    print('none')\n"
    )
    assert run.stdout == "True\nnone\n"


def test_without_a_limit_anything_is_left() -> None:
    if resource.getrlimit(resource.RLIMIT_DATA)[0] == resource.RLIM_INFINITY:
        assert left_mb() == float("inf")


def test_a_process_that_had_most_of_its_limit_resident_died_of_it() -> None:
    assert took_all(450, 500)
    assert not took_all(200, 500)
