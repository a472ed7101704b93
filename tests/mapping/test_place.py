"""Places of an explored area: from the log, and the thing at each."""

from facetlog.mapping.place import Place, places_of, thing_at
from tests.mapping.rooms import box_thing


def test_the_places_of_a_log_have_their_views_and_views_on_the_way_are_of_none() -> None:
    lines = [
        {"result": "chosen", "image": "a.png", "looks_at": 0},
        {"result": "chosen", "image": "c.png", "looks_at": 2, "target": [3, 1.0, 0.2]},
        {"result": "chosen", "image": "b.png", "looks_at": 1, "target": [1.0, 0.5, 0.3]},
        {"result": "blocked", "image": "b.png"},
        {"result": "chosen", "image": "b.png", "looks_at": 1, "target": [1.0, 0.5, 0.3]},
        {"result": "taken", "image": "b.png"},
    ]
    one, two = places_of(lines)
    assert one == Place(1, 1.0, 0.5, 0.3, ("b.png",))
    assert (two.number, two.names) == (2, ("c.png",))
    assert dict(two.to_json()) == {"looks_at": 2, "target": [3.0, 1.0, 0.2]}
    assert places_of(lines[:1]) == ()


def test_the_thing_at_a_place_is_the_one_that_stands_there_or_is_nearest() -> None:
    here, there = box_thing(1.0, 0.0), box_thing(3.0, 0.0)
    found = thing_at(Place(4, 1.1, 0.0, 0.2), (there, here))
    assert found is not None
    assert (found.pose[0], found.place) == (here.pose[0], 4)
    # A leg of it was heard, half a metre beside.
    assert thing_at(Place(1, 3.7, 0.0, 0.1), (there, here)) is not None
    assert thing_at(Place(1, 5.0, 0.0, 0.1), (there, here)) is None
    assert thing_at(Place(1, 1.0, 0.0, 0.1), ()) is None
