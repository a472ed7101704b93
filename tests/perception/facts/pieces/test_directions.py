"""How pieces are turned to one another, and to the way up."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.pieces.piece_directions import iter_angles
from facetlog.perception.flat_faces import Estimate
from facetlog.perception.pieces.shown_pieces import Piece
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.types import FloatArray

UP = np.array([0.0, 0.0, 1.0])
BAR, BOARD, BLOCK = (1.0, 0.1, 0.08), (1.0, 0.6, 0.05), (0.6, 0.5, 0.4)
turns = st.integers(0, 10**6).map(lambda seed: Rotation.random(random_state=seed).as_matrix())


def piece(extents: tuple[float, float, float], axes: FloatArray) -> Piece:
    sizes = [Estimate(extent, 0.002) for extent in extents]
    return Piece(*sizes, axes, np.zeros(3), 0.0, 1.0, (), 0.0)


def between(one: Piece, other: Piece, up: FloatArray | None = None) -> Estimate:
    (_, _, first), (_, _, second) = iter_angles([one, other], up)
    assert first == second
    return first


@given(turns, st.floats(0.0, 360.0))
def test_a_bar_is_square_to_a_board_that_it_carries_however_that_is_turned(
    world: np.ndarray, degrees: float
) -> None:
    about = Rotation.from_rotvec(np.deg2rad(degrees) * UP).as_matrix()
    post = piece(BAR, np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]) @ world.T)
    top = piece(BOARD, about @ world.T)
    assert between(post, top).value == pytest.approx(90.0, abs=1e-4)
    rail = piece(BAR, about @ world.T)
    assert between(rail, top).value == pytest.approx(0.0, abs=1e-4)


def test_legs_are_square_to_their_top_and_along_each_other() -> None:
    rows = fact_rows(build("table", {}), {"piece_angle"})["piece_angle"]
    angles = {(a, b): angle for a, b, angle, _ in rows}
    assert len(angles) == 20
    assert all(angle == pytest.approx(90.0 * ("p1" in pair)) for pair, angle in angles.items())
