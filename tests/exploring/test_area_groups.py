"""How the places of an area ended, written to collect.jsonl and read back."""

import json

from facetlog.exploring.area_groups import End, ends_json, ends_of


def test_ends_are_read_back_as_they_were_written() -> None:
    ends = {1: End("it is settled", 7), 3: End("nothing promises more")}
    lines = [{"looks_at": 1}, {"looks_at": 4, **json.loads(json.dumps(ends_json(ends)))}]
    assert ends_of(lines) == ends
    assert ends_json({}) == {}


def test_a_place_that_was_looked_at_again_has_not_ended() -> None:
    first = {"looks_at": 0, **ends_json({2: End("no view is reached", 3)})}
    again = {"looks_at": 2}
    assert ends_of([first, again]) == {2: End(retried=True)}
    last = {"result": "explored", **ends_json({2: End("it is settled", 9)})}
    assert ends_of([first, again, last]) == {2: End("it is settled", 9, retried=True)}


def test_older_records_do_not_say_what_was_offered() -> None:
    assert ends_of([{"looks_at": 0, "ended": {"1": "it is settled"}}]) == {1: End("it is settled")}
