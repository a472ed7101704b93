"""The journal: nothing is lost, nothing is there twice, and no other run is mixed in."""

import errno
import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from facetlog.batch.journal import Journal, check_not_in_use
from facetlog.batch.rows import COLUMNS
from facetlog.errors import InputError

RUN = {"models": "abc"}
NAMES = tuple("abcdef")


def _line(name: str, **more: object) -> bytes:
    row = dict.fromkeys(COLUMNS) | {"models_hash": "abc", "facetlog": "1", "read_as": "x"}
    return json.dumps(
        row | {"path": name, "verdicts": [], "warnings": [], "seconds": 0.0} | more
    ).encode()


def _written(path: Path, names: tuple[str, ...] = NAMES) -> Journal:
    journal = Journal.opened(path, RUN, {})
    for name in names:
        journal.append(name, _line(name))
    return journal


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cut=st.integers(0, 2200), again=st.booleans())
def test_a_journal_cut_anywhere_goes_on_with_all_whole_rows(
    cut: int, again: bool, tmp_path: Path
) -> None:
    path = tmp_path / "j"
    path.unlink(missing_ok=True)
    _written(path).close()
    data = path.read_bytes()[:cut]
    path.write_bytes(data)
    whole = max(data.count(b"\n") - 1, 0)
    with Journal.opened(path, RUN, {}) as journal:
        assert len(journal) == whole
        for name in NAMES[whole:]:
            journal.append(name, _line(name))
        assert [row["path"] for row in journal.rows(NAMES)] == list(NAMES)
    assert path.read_bytes().count(b"\n") == len(NAMES) + 1


@pytest.mark.parametrize(
    ("run", "read_as", "says"),
    [
        ({"models": "other"}, {}, "begun with other models: abc, now other.*--overwrite"),
        (RUN, {"a": "y"}, "begun with other options: x, now y.*--overwrite"),
    ],
)
def test_another_run_does_not_go_on_with_it(
    run: dict[str, Any], read_as: dict[str, str], says: str, tmp_path: Path
) -> None:
    _written(tmp_path / "j").close()
    before = (tmp_path / "j").read_bytes()
    with pytest.raises(InputError, match=says):
        Journal.opened(tmp_path / "j", run, read_as)
    assert (tmp_path / "j").read_bytes() == before


@pytest.mark.parametrize(
    "line",
    [b"{", b"[]", b'{"path": 3}', b"[" * 100_000, _line("a", seconds="x"), b"\xff\x00"],
)
def test_a_line_that_is_no_row_is_named_in_one_line(line: bytes, tmp_path: Path) -> None:
    path = tmp_path / "j"
    _written(path, ("a",)).close()
    before = path.read_bytes() + line + b"\n"
    path.write_bytes(before)
    with pytest.raises(InputError, match=r"j: row 2: ") as caught:
        Journal.opened(path, RUN, {})
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == before


def test_a_pipe_or_another_file_in_its_place_is_left_alone(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="it is a pipe"):
        Journal.opened(tmp_path / "pipe", RUN, {})
    (tmp_path / "other").write_bytes(b"no end of line")
    with pytest.raises(InputError, match="is no journal of classify"):
        Journal.opened(tmp_path / "other", RUN, {})
    assert (tmp_path / "other").read_bytes() == b"no end of line"


@pytest.mark.parametrize("afresh", [False, True])
def test_two_runs_do_not_write_one_journal(afresh: bool, tmp_path: Path) -> None:
    path = tmp_path / "j"
    with _written(path) as journal:
        with pytest.raises(InputError, match="another run is writing"):
            Journal.opened(path, RUN, {}, afresh=afresh)
        with pytest.raises(InputError, match="another run is writing"):
            check_not_in_use(path)
        assert [row["path"] for row in journal.rows(NAMES)] == list(NAMES)
    check_not_in_use(path)
    with Journal.opened(path, RUN, {}, afresh=afresh) as journal:
        assert len(journal) == (0 if afresh else len(NAMES))


def test_a_run_removes_its_own_journal_alone(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with _written(path) as first:
        path.unlink()
        with _written(path) as second:
            first.remove()
            assert path.exists()
            second.remove()
            assert not path.exists()
            second.remove()


def test_a_full_disk_keeps_the_rows_so_far_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.write

    def half(descriptor: int, data: memoryview) -> int:
        if len(data) < 10:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(descriptor, data[: len(data) // 2])

    with _written(tmp_path / "j") as journal:
        monkeypatch.setattr("facetlog.batch.journal.os.write", half)
        with pytest.raises(InputError, match=r"No space left.*holds 6 rows.*--resume"):
            journal.append("g", _line("g"))
        monkeypatch.undo()
        journal.append("g", _line("g"))
        assert [row["path"] for row in journal.rows("ag")] == ["a", "g"]
    with Journal.opened(tmp_path / "j", RUN, {}) as journal:
        assert len(journal) == 7


def test_rows_come_in_any_order_asked_and_as_often(tmp_path: Path) -> None:
    with _written(tmp_path / "j") as journal:
        for _ in range(2):
            assert [row["path"] for row in journal.rows("cab")] == ["c", "a", "b"]
        assert "a" in journal
        assert "z" not in journal


def test_to_start_over_throws_no_file_of_others_away(tmp_path: Path) -> None:
    (tmp_path / "j").write_text("my thesis\n")
    with pytest.raises(InputError, match="is no journal of classify"):
        Journal.opened(tmp_path / "j", RUN, {}, afresh=True)
    assert (tmp_path / "j").read_text() == "my thesis\n"
