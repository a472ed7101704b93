"""The common form: a report as text, as JSON and as a page; what is missing is said."""

import doctest
import json
from pathlib import Path

import pytest

from benchmarks import common, page
from benchmarks.__main__ import PAGE, main, read_kept_reports
from benchmarks.common import Report, Table
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


def test_a_figure_is_taken_from_the_row_that_is_named() -> None:
    reports = {"accuracy_example": REPORT.to_json()}
    row = "| error | {error:%} of {case} | accuracy_example; Err; case = a|b |"
    assert page.make_headline_page(reports, row) == "| error | 12.3 % of a|b | accuracy_example |"
    with pytest.raises(LookupError, match="accuracy_example has no row"):
        page.make_headline_page(reports, row.replace("a|b |", "d |"))


def test_the_kept_page_is_made_of_the_kept_reports() -> None:
    assert PAGE.read_text(encoding="utf-8") == page.make_headline_page(read_kept_reports())


def test_the_machine_has_no_names_of_hosts_or_folders() -> None:
    said = json.dumps(common.machine())
    assert "/home" not in said
    assert str(Path.home()) not in said
    assert common.platform.node() not in said


def test_an_unknown_benchmark_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["accuracy_of_nothing"])
    assert "there is no benchmark accuracy_of_nothing" in capsys.readouterr().err
