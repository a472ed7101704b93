"""Assemblies: what touches goes on to touch, and what is put under a part carries it."""

import numpy as np
import pytest

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.surfaces.exact_solids.cuboid_union import cuboid_union
from facetlog.prototype.forms import (
    HUNG,
    between,
    borne,
    hung,
    iter_grown_forms,
    iter_starting_forms,
    pair,
    single,
    under,
)


def test_a_union_is_closed_and_faces_outwards() -> None:
    scene = cuboid_union([[0, 0, 0.4], [0.2, 0.2, 0]], [[0.6, 0.6, 0.5], [0.4, 0.4, 0.4]], "T")

    # by the divergence theorem the volume is a third of what flows out of (x, y, z)
    volume = 0.0
    for face in scene.faces:
        for ring in (face.outline, *face.holes):
            points = scene.points[list(ring)]
            area = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) / 2.0
            volume += float(area @ points[0]) / 3.0
    assert volume == pytest.approx(0.6 * 0.6 * 0.1 + 0.2 * 0.2 * 0.4)


def test_parts_that_do_not_touch_are_no_solid() -> None:
    with pytest.raises(ValueError, match="touch"):
        cuboid_union([[0, 0, 0], [0, 0, 0.4]], [[0.2, 0.2, 0.3], [0.2, 0.2, 0.5]], "two")


def test_four_legs_carry_a_board_as_pieces_have_it() -> None:
    table = under(single("board"), 0, "four legs")
    carried = fact_rows(table.scene(table.sizes), {"carries"})["carries"]

    assert len(carried) == 4
    assert len({above for _, above in carried}) == 1


@pytest.mark.parametrize("count", [1, 2, 4, 8])
def test_boards_between_posts_and_between_legs_touch_both_and_nothing_else(count: int) -> None:
    for start, first, second in (
        (pair("upright bar"), 0, 1),
        (under(single("board"), 0, "four legs"), 1, 4),
    ):
        made = between(start, first, second, count)
        low, high = made.ends(made.sizes)
        boards = np.arange(len(start.parts), len(low))

        assert len(boards) == count
        assert len(made.scene(made.sizes).faces) > 0
        assert low[boards, 0] == pytest.approx(high[first, 0])
        assert high[boards, 0] == pytest.approx(low[second, 0])
        assert (low[boards[1:], 2] > high[boards[:-1], 2]).all()
        assert (low[boards, 2] > 0.0).all()
        assert (high[boards, 2] < high[first, 2]).all()


@pytest.mark.parametrize("kind", HUNG)
def test_what_hangs_between_legs_is_inside_the_opening_there(kind: str) -> None:
    made = hung(under(single("board"), 0, "four legs"), 0, kind)
    within = fact_rows(made.scene(made.sizes), {"inside"})["inside"]

    assert {(one[0], other[0]) for one, other, known in within if known == "yes"} == {("p", "o")}


def test_a_seat_on_ropes_hangs_from_them_and_stands_on_nothing() -> None:
    swing = borne(hung(under(single("bar"), 0, "two posts"), 0, "bar", 2), 3, 4)
    low, high = swing.ends(swing.sizes)
    hangs = fact_rows(swing.scene(swing.sizes), {"hangs_from"})["hangs_from"]

    assert high[5, 2] == pytest.approx(low[3:5, 2])
    assert low[5, 2] > 0.0
    assert len({one for one, _ in hangs}) == 2


def test_all_forms_have_names_of_their_own_and_most_can_be_built() -> None:
    forms = [*iter_starting_forms()]
    grown = [*iter_grown_forms(single("board"), single("board").sizes)]
    built = 0
    for form in (*forms, *grown):
        try:
            built += len(form.scene(form.sizes).faces) > 0
        except ValueError:
            continue

    assert len({(form.name, *form.sizes) for form in forms}) == len(forms)
    assert built > 0.8 * len((*forms, *grown))
