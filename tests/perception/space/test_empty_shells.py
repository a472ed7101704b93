"""Points between a place and the walls round it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.space.flooding import is_empty_shell
from tests.perception.shapes.sampled_shapes import box_points, sphere_points

SIZE = (3.0, 2.0, 2.5)
MIDDLE = np.array([1.5, 1.0, 1.25])


@given(st.tuples(*[st.floats(0.1, 0.9)] * 3), st.floats(1e-3, 1e3), st.integers(0, 50))
def test_a_shell_is_empty_wherever_one_stands_in_it_and_not_seen_from_outside(
    share: tuple[float, float, float], scale: float, seed: int
) -> None:
    shell = scale * box_points(SIZE, 400, seed=seed)
    place = scale * np.array(SIZE) * share
    assert is_empty_shell(shell, shell, place)
    assert not is_empty_shell(shell, shell, place + np.array([4.0 * scale, 0.0, 0.0]))


def test_a_ball_round_a_place_is_empty_until_something_stands_in_it() -> None:
    ball = sphere_points(1.0, 2000, 0.0)
    place = ball.mean(axis=0)
    assert is_empty_shell(ball, ball, place)
    inner = place + 0.5 * (ball[:200] - place)
    assert not is_empty_shell(ball, np.concatenate([ball, inner]), place)


def test_what_is_flat_encloses_nothing() -> None:
    flat = box_points(SIZE, 400, sides=("-z",))
    assert not is_empty_shell(flat, flat, MIDDLE)
    assert not is_empty_shell(flat[:2], flat, MIDDLE)
