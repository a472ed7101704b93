"""The common form: a report as text, as JSON and as a page; what is missing is said."""

import doctest
import json
from pathlib import Path

import pytest

from benchmarks import common, page
from benchmarks.__main__ import PAGE, kept_reports, main
from benchmarks.common import Report, Table, data_set, text, tree_hash
from benchmarks.pictures import recognition

REPORT = Report(
    "accuracy_example",
    (Table("Errors", ({"case": "a|b", "error": 0.123456}, {"case": "c", "error": None})),),
    {"seeds": 3},
    ("A note.",),
)


@pytest.mark.parametrize("module", [common, recognition])
def test_the_doctests_hold(module: object) -> None:
    assert doctest.testmod(module).failed == 0  # type: ignore[arg-type]


def test_a_report_survives_json() -> None:
    plain = REPORT.to_json()
    assert json.loads(json.dumps(plain)) == plain


def test_text_aligns_its_columns() -> None:
    lines = list(text(REPORT.to_json()))
    assert lines[0] == "accuracy_example  seeds 3"
    assert lines[3:6] == ["case  error", "a|b   0.1235", "c     –"]


def test_a_skipped_report_says_why() -> None:
    lines = list(text(Report("accuracy_example", skipped="no data").to_json()))
    assert "skipped: no data" in lines


def test_all_tables_of_a_report_are_on_the_page() -> None:
    made = page.all_tables(
        {"accuracy_example": REPORT.to_json()}, {"accuracy_example": "How exact?"}
    )
    assert "How exact?" in made
    assert "| a\\|b | 0.1235 |\n| c | – |" in made


def test_a_figure_is_taken_from_the_row_that_is_named() -> None:
    reports = {"accuracy_example": REPORT.to_json()}
    row = "| error | {error:%} of {case} | accuracy_example; Err; case = a|b |"
    assert page.headline_page(reports, row) == "| error | 12.3 % of a|b | accuracy_example |"
    with pytest.raises(LookupError, match="accuracy_example has no row"):
        page.headline_page(reports, row.replace("a|b |", "d |"))


def test_the_kept_page_is_made_of_the_kept_reports() -> None:
    assert PAGE.read_text(encoding="utf-8") == page.headline_page(kept_reports())


def test_the_machine_has_no_names_of_hosts_or_folders() -> None:
    said = json.dumps(common.machine())
    assert "/home" not in said
    assert str(Path.home()) not in said
    assert common.platform.node() not in said


def test_data_that_is_not_there_is_a_reason(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv(common.DATA_VARIABLE, str(tmp_path))
    reason = data_set("images", "cube")
    assert reason == "FACETLOG_DATA has no folder images/cube"
    monkeypatch.delenv(common.DATA_VARIABLE)
    assert "is not set" in str(data_set("images"))


def test_a_hash_names_contents_and_not_the_place(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name / "images").mkdir(parents=True)
        (tmp_path / name / "images" / "a.png").write_bytes(b"picture")
    before = tree_hash(tmp_path / "one")
    assert before == tree_hash(tmp_path / "two")
    (tmp_path / "two" / "images" / "a.png").write_bytes(b"another")
    assert before != tree_hash(tmp_path / "two")


def test_an_unknown_benchmark_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["accuracy_of_nothing"])
    assert "there is no benchmark accuracy_of_nothing" in capsys.readouterr().err
