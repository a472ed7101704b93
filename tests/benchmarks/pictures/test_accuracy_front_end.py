"""True corners in pictures: what hides them, and that all of them found is a recall of one."""

import numpy as np

from benchmarks.pictures.accuracy_front_end import (
    Tally,
    hidden_corners,
    tally_pictures,
    true_pixels,
)
from facetlog.perception.types import Observation, View
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses

WORLD = make_world("clutter_block")
FLAT = [index for index, solid in enumerate(WORLD.solids) if not solid.curved]


def some_views() -> tuple[View, ...]:
    return views_of(WORLD, tour_poses()[::8], tour_camera())


def test_a_block_hides_those_of_its_corners_that_it_does_not_show() -> None:
    (block, *_) = WORLD.truth.solids
    for view in some_views():
        _, inside, _ = true_pixels(block, view)
        hidden = np.flatnonzero(hidden_corners(WORLD, block, view))
        assert len(inside) in (6, 7)
        assert set(hidden.tolist()) == set(range(8)) - set(inside)


def test_all_true_corners_are_a_recall_and_a_precision_of_one() -> None:
    views, found = some_views(), []
    for k, view in enumerate(views):
        here = []
        for index in FLAT:
            solid = WORLD.truth.solids[index]
            pixels, inside, _ = true_pixels(solid, view)
            hidden = hidden_corners(WORLD, solid, view)
            here += [Observation(k, pixels[i], np.eye(2)) for i in inside if not hidden[i]]
        found.append(here)
    tally = Tally()
    tally_pictures(tally, FLAT, views, found, WORLD)
    assert tally.hit == tally.true == tally.found > 60
    assert max(tally.errors) < 1e-9
