"""Rows: what they hold is published, and what others hand in is checked."""

from pathlib import Path
from typing import Any

import pytest

from facetlog.batch.engine import SceneEngine
from facetlog.batch.rows import RowRecord, has_run_out, parse_row
from facetlog.batch.settings import Item, Settings
from facetlog.errors import InputError
from tests.batch.fake_worker import fake_row


def test_a_row_comes_back_and_columns_of_others_are_left_out() -> None:
    for path in (__file__, "absent.json"):
        row = fake_row(path, ())
        again = parse_row({**row, "mine": 1}, "t")
        assert RowRecord.model_validate(again) == RowRecord.model_validate(row)
        assert "mine" not in again


@pytest.mark.parametrize(
    ("change", "says"),
    [({"degree": 2}, "t: degree"), ({"path": None}, "t: path"), ({"up": [1]}, "t: up")],
)
def test_a_row_that_is_none_is_told_with_its_field(change: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        parse_row({**fake_row(__file__, ()), **change}, "t")
    with pytest.raises(InputError, match="is it a table of classify"):
        parse_row(3, "t")


@pytest.mark.parametrize(
    ("fault", "says", "spent"),
    [
        (RecursionError("maximum"), "b.json: it is nested too deeply", False),
        (MemoryError(), "b.json: needs more memory than 500 MB: give more by --memory, or", True),
    ],
)
def test_whatever_goes_wrong_with_a_scene_is_one_line_of_its_row(
    fault: BaseException, says: str, spent: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object, **__: object) -> None:
        raise fault

    (tmp_path / "b.json").touch()
    engine = SceneEngine(Settings(memory_mb=500))
    monkeypatch.setattr("facetlog.batch.engine.open_scene", failing)
    row = engine.row(Item("b.json", file=str(tmp_path / "b.json")))
    engine.close()
    assert row["error"].startswith(says)
    assert engine.spent is spent
    assert has_run_out(row) is spent
