"""What is free, occupied and unseen, and which of them counts where they contradict."""

import numpy as np
import pytest
import shapely

from facetlog.errors import InputError
from facetlog.mapping.floor_grid import Cell, Seen, floor_grid
from facetlog.mapping.sonar_beams import Beam
from facetlog.perception.scene import SeenLattice
from facetlog.robot.pose2 import Pose2


def _shown(low: float, high: float, pitch: float = 0.04) -> SeenLattice:
    """Ground that two views show, square."""
    count = round((high - low) / pitch)
    return SeenLattice(
        np.array([low, low, 0.0]),
        pitch * np.eye(3)[:2],
        np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]),
        np.ones((2, count, count), np.bool_),
        (0, 1),
    )


def test_a_thing_is_occupied_though_the_floor_beneath_it_shows() -> None:
    table = shapely.box(0.5, 0.5, 1.5, 1.0)
    floor = floor_grid(Seen((_shown(0.0, 2.0),), plans=(table,)))
    assert floor.at(1.0, 0.75) is Cell.OCCUPIED
    assert floor.at(1.0, 1.2) is Cell.FREE


def test_where_the_robot_was_is_free_by_the_width_of_its_body() -> None:
    floor = floor_grid(Seen(way=(Pose2(0.0, 0.0), Pose2(1.0, 0.0)), radius=0.25))
    assert floor.at(0.5, 0.2) is Cell.FREE
    assert floor.at(0.5, 0.3) is Cell.UNSEEN
    assert floor_grid(Seen(way=(Pose2(0.0, 0.0),), radius=0.25)).at(0.1, 0.0) is Cell.FREE


def test_sonars_alone_make_no_floor_free_but_occupied_where_most_beams_end() -> None:
    """A wall at x = 2, which beams from three places meet."""
    beams = tuple(Beam(0.0, y, 0.0, 2.0, echo=True) for y in (-0.2, 0.0, 0.2))
    floor = floor_grid(Seen(beams=beams))
    assert floor.at(1.0, 0.0) is Cell.PASSED
    assert floor.at(1.98, 0.0) is Cell.OCCUPIED
    assert floor.at(2.3, 0.0) is Cell.UNSEEN
    assert floor.at(-0.2, 0.0) is Cell.UNSEEN


def test_of_nothing_there_is_an_empty_map_and_a_huge_one_is_refused() -> None:
    assert floor_grid(Seen()).area(Cell.FREE) == 0.0
    with pytest.raises(InputError, match="give a larger --resolution"):
        floor_grid(Seen((_shown(0.0, 2.0),)), 1e-4)
