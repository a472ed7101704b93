"""From where unseen floor is looked at: what shows most of it for the time it takes."""

import numpy as np
import pytest

from facetlog.exploring.floor_ways import FloorWays, Lattice
from facetlog.exploring.unseen_floor import Sweep, best_sweep, shown_from
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pose2 import Pose2

LATTICE = Lattice.of_area((0.0, 0.0, 8.0, 4.0), 0.1)
X, Y = np.moveaxis(LATTICE.middles, -1, 0)
NONE = np.zeros(LATTICE.shape, np.bool_)


def _best(unseen: np.ndarray, stopped: np.ndarray = NONE, x: float = 4.0) -> Sweep | None:
    ways = FloorWays(LATTICE, ~unseen & ~stopped, ~stopped, (x, 2.0))
    return best_sweep(
        unseen.astype(float), stopped, ways, LATTICE, Pose2(x, 2.0), Pace(), reach=2.0, least=0.25
    )


def test_it_goes_where_floor_is_unseen_and_knows_how_much_shows() -> None:
    found = _best(X > 6.0)
    assert found is not None
    assert 4.0 < found.place[0] < 6.0
    shown = shown_from(found.place, NONE, LATTICE, 2.0) & (X > 6.0)
    assert found.floor == pytest.approx(shown.sum() * 0.01, rel=0.1)


def test_of_two_sides_the_nearer_one_is_first() -> None:
    found = _best((X > 7.0) | (X < 1.0), x=3.0)
    assert found is not None
    assert found.place[0] < 3.0


def test_what_is_behind_a_wall_does_not_show() -> None:
    wall = (X > 5.0) & (X < 5.3)
    assert _best(X > 5.3, wall) is None
    assert not shown_from((4.0, 2.0), wall, LATTICE, 3.0)[X > 5.3].any()


def test_where_all_is_seen_or_hardly_anything_is_not_there_is_nowhere_to_go() -> None:
    assert _best(NONE) is None
    assert _best((X > 7.8) & (Y > 3.8)) is None


def test_all_that_a_look_was_worth_shows_from_there() -> None:
    """Else it would be taken again and again: a far cell that one ray grazes may be worth it."""
    for at, far in (((3, 21), (25, 21)), ((0, 45), (0, 23)), ((3, 3), (25, 3))):
        worth = np.zeros(LATTICE.shape)
        worth[far] = 25.0
        here = Pose2(*LATTICE.middles[at].tolist())
        ways = FloorWays(LATTICE, ~NONE, ~NONE, (here.x, here.y))
        found = best_sweep(worth, NONE, ways, LATTICE, here, Pace(), reach=2.3, least=0.25)
        assert found is not None
        assert shown_from(found.place, NONE, LATTICE, 2.3)[far]
