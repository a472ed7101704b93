"""The figures that are wanted of the eyes, found in the kept reports."""

import pytest

from benchmarks.__main__ import kept_reports
from benchmarks.wanted import WANTED, Place, Wanted, wanted_rows
from benchmarks.wanted_of_the_judge import BEFORE, WANTED_OF_THE_JUDGE

REPORT = {"tables": [{"title": "Seen by day", "rows": [{"view": 1, "n": 3}, {"view": 2, "n": 5}]}]}


def test_a_place_is_a_row_of_the_table_whose_title_begins_so() -> None:
    assert Place("eyes", "Seen", ("n",), (("view", 2),)).cells({"eyes": REPORT}) == (5,)
    assert Place("eyes", "Seen", ("n",), (("view", 3),)).cells({"eyes": REPORT}) is None
    assert Place("eyes", "Heard", ("n",)).cells({"eyes": REPORT}) is None
    assert Place("ears", "Seen", ("n",)).cells({"eyes": REPORT}) is None


def test_a_cell_stands_with_its_column_s_name_or_another_also_where_it_is_missing() -> None:
    assert Place("eyes", "Seen", ("view", "n")).shown({"eyes": REPORT}) == "view 1; n 3"
    assert Place("eyes", "Seen", ("n",), name="things").shown({"eyes": REPORT}) == "things 3"
    assert Place("eyes", "Seen", ("view", "n")).shown({}) == "view –; n –"


def test_without_reports_there_is_no_table() -> None:
    assert wanted_rows({}) == ()


def test_what_was_measured_before_stands_beside_each_figure_of_the_judge() -> None:
    assert set(BEFORE) == {one.figure for one in WANTED_OF_THE_JUDGE}
    reports = {str(report["benchmark"]): report for _, report in kept_reports()}
    rows = wanted_rows(reports, WANTED_OF_THE_JUDGE, BEFORE)
    assert [row["before"] for row in rows] == [BEFORE[str(row["figure"])] for row in rows]


@pytest.mark.parametrize("one", [*WANTED, *WANTED_OF_THE_JUDGE], ids=lambda one: one.figure)
def test_each_wanted_figure_stands_in_a_kept_report(one: Wanted) -> None:
    reports = {str(report["benchmark"]): report for _, report in kept_reports()}
    for place in one.places:
        cells = place.cells(reports)
        assert cells is not None, place
        assert None not in cells, place
