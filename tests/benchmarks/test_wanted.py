"""The figures that are wanted of the eyes, found in the kept reports."""

import pytest

from benchmarks.__main__ import kept_reports
from benchmarks.wanted import WANTED, Place, Wanted, wanted_rows

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


@pytest.mark.parametrize("one", WANTED, ids=lambda one: one.figure)
def test_each_wanted_figure_stands_in_a_kept_report(one: Wanted) -> None:
    reports = {str(report["benchmark"]): report for _, report in kept_reports()}
    for place in one.places:
        cells = place.cells(reports)
        assert cells is not None, place
        assert None not in cells, place
