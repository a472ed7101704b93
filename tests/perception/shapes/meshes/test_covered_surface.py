"""Where boards touch or reach into each other nobody sees a face, and none is stated."""

import pytest

from facetlog.perception.facts.all_facts import FactRows, fact_rows
from tests.perception.shapes.meshes.made_meshes import block, scene_of, together

Box = tuple[tuple[float, float, float], tuple[float, float, float]]

LOW_STEP: Box = ((0.0, 0.0, 0.0), (0.5, 0.4, 0.2))
FLOOR: Box = ((0.0, 0.0, 0.0), (0.4, 0.3, 0.01))
WALLS: tuple[Box, ...] = (
    ((0.0, 0.0, 0.01), (0.4, 0.01, 0.25)),
    ((0.0, 0.29, 0.01), (0.4, 0.3, 0.25)),
    ((0.0, 0.01, 0.01), (0.01, 0.29, 0.25)),
    ((0.39, 0.01, 0.01), (0.4, 0.29, 0.25)),
)


def facts_of(*boxes: Box) -> FactRows:
    return fact_rows(scene_of(together(*(block(*ends) for ends in boxes))))


def upward_sizes(facts: FactRows) -> list[tuple[float, float]]:
    """Length and width of the faces that look up, by height."""
    length, width = dict(r[:2] for r in facts["length"]), dict(r[:2] for r in facts["width"])
    height = dict(r[:2] for r in facts["elevation"])
    faces = sorted((f for (f,) in facts["upward"]), key=lambda f: height[f])
    return [(length[f], width[f]) for f in faces]


@pytest.mark.parametrize("reaches_in", [0.0, 0.1])
def test_a_tread_ends_at_the_step_that_stands_on_it(reaches_in: float) -> None:
    facts = facts_of(LOW_STEP, ((0.25, 0.0, 0.2 - reaches_in), (0.5, 0.4, 0.4)))
    assert upward_sizes(facts) == [pytest.approx((0.4, 0.25), abs=1e-3)] * 2


def test_the_walls_of_a_crate_of_boards_are_hollow_to_its_floor() -> None:
    facts = facts_of(FLOOR, *WALLS)
    height = dict(row[:2] for row in facts["elevation"])
    floor = min((f for (f,) in facts["upward"]), key=lambda f: height[f])
    walls = [wall for wall, other in facts["concave"] if other == floor]
    assert len(walls) == len(set(walls)) == 4
    (size,) = [row[1:3] for row in facts["area"] if row[0] == floor]
    assert size[0] == pytest.approx(0.38 * 0.28, rel=1e-3)


def test_things_that_stand_apart_cover_nothing() -> None:
    facts = facts_of(LOW_STEP, ((0.9, 0.0, 0.0), (1.2, 0.4, 0.4)))
    assert sorted(upward_sizes(facts)) == [
        pytest.approx((0.4, 0.3)),
        pytest.approx((0.5, 0.4)),
    ]
