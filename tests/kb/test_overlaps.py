"""Users' models that never hold without a built-in one."""

from facetlog.kb.overlaps import Overlaps

TROLLEY = ("t1", "trolley", 0.9)


def list_hints(*scenes: tuple[tuple[str, str, float], ...], stated: tuple[str, ...] = ()) -> str:
    overlaps = Overlaps({"trolley": stated})
    for holding in scenes:
        overlaps.add(holding)
    return "\n".join(overlaps.iter_lines())


def test_a_built_in_model_that_always_holds_as_well_is_named() -> None:
    both = (TROLLEY, ("t1", "table", 0.9))
    assert "rather than table`" in list_hints(both, both, (("t1", "table", 1.0),))
    assert list_hints(both, both, stated=("table",)) == ""
    assert list_hints(both) == ""  # of one thing "all" says too much


def test_no_hint_where_it_once_fails_is_of_another_thing_or_stands_behind() -> None:
    both = (TROLLEY, ("t1", "table", 0.9))
    for other in ((TROLLEY,), (TROLLEY, ("t2", "table", 1.0)), (TROLLEY, ("t1", "table", 0.8))):
        assert list_hints(both, other) == ""
