"""Why structure from motion placed nothing, or not all pictures, in words to act on."""

import re

import pytest

from facetlog.perception.reading.sfm.outcome import Outcome, Pair, explain_failure, left_out
from facetlog.perception.reading.skipped_images import LeftOut, lines_of

PLACES = {name: f"photos/{name}" for name in "abcdefg"}
TEXTURED = dict.fromkeys("abcd", 900)


@pytest.mark.parametrize(
    ("outcome", "line"),
    [
        (Outcome({"a": 900, "b": 900}), "without one at least 3 pictures are needed"),
        (
            Outcome({"a": 900}, (LeftOut("b", "picture photos/b is damaged", "photos/b"),)),
            "1 can be read: picture photos/b is damaged",
        ),
        (
            Outcome(dict.fromkeys("abcd", 60)),
            "too little texture, 60 features in a usual one: lay printed paper under the thing, or "
            r"use a printed mat \(facetlog mat",
        ),
        (
            Outcome(TEXTURED, pairs=(Pair("a", "b", 31),)),
            "only 1 of 6 pairs of pictures have points in common, 31 at most: take one every",
        ),
        (Outcome(TEXTURED), "only 0 of 6 pairs of pictures have points in common: take one every"),
        (
            Outcome(TEXTURED, pairs=(Pair("a", "b", 500),)),
            "up to 500 points, was taken from places that do not lie apart: walk round the thing",
        ),
    ],
)
def test_why_nothing_was_placed_comes_with_the_way_out(outcome: Outcome, line: str) -> None:
    assert re.search(line, explain_failure(outcome))


def test_pictures_that_do_not_join_are_named_group_by_group() -> None:
    features = dict.fromkeys("abcdef", 900)
    broken = LeftOut("g", "picture photos/g is damaged", "photos/g")
    outcome = Outcome(features, (broken,), (), (("a", "b", "c"), ("c", "d", "e")), 0.4)
    assert lines_of(left_out(outcome, PLACES)) == (
        "picture photos/g is damaged; left out",
        "picture photos/d is one of 2 that do not join the 3 that are used: take some between; "
        "left out, and so is e",
        "picture photos/f has too few points in common with the others: take some between; "
        "left out",
    )
