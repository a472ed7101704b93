"""Assemblies: what touches goes on to touch, and what is put under a part carries it."""

import numpy as np
import pytest

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.surfaces.exact_solids.cuboid_union import cuboid_union
from facetlog.prototype.assembly import Assembly
from facetlog.prototype.forms import (
    HUNG,
    angle,
    between,
    borne,
    hung,
    iter_grown_forms,
    iter_starting_forms,
    pair,
    planked,
    single,
    under,
    wheeled,
)
from facetlog.prototype.patterns import grids


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


@pytest.mark.parametrize("carried", [single("board"), under(single("board"), 0, "four legs")])
def test_wheels_are_round_pieces_on_the_ground_that_carry_the_rest(carried: Assembly) -> None:
    made = wheeled(carried)
    rows = fact_rows(made.scene(made.sizes), {"piece_round", "piece_on_ground", "carries"})
    wheels = {name for name, share in rows["piece_round"] if share > 0.9}

    assert wheels == {name for (name,) in rows["piece_on_ground"]}
    assert len(wheels) == 4
    assert {over for under, over in rows["carries"] if under in wheels} >= {"p1"}


@pytest.mark.parametrize(("count", "names"), [(9, ["3 rows of 3"]), (8, ["2 rows of 4"]), (7, [])])
def test_blocks_stand_in_rows_under_a_board(count: int, names: list[str]) -> None:
    patterns = [*grids(count)]
    assert [name.removesuffix(" blocks") for name in patterns] == names
    for pattern in patterns:
        made = under(single("board"), 0, pattern, flush=True)
        rows = fact_rows(made.scene(made.sizes), {"piece_on_ground", "carries"})
        assert len(rows["piece_on_ground"]) == len(rows["carries"]) == count


@pytest.mark.parametrize(("made", "boards"), [(angle("board"), 2), (planked(4), 6)])
def test_boards_that_touch_are_pieces_of_their_own(made: Assembly, boards: int) -> None:
    assert len(fact_rows(made.scene(made.sizes), {"piece_size"})["piece_size"]) == boards


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
