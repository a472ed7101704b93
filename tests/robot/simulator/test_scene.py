"""Scenes in metres: named worlds, own solids, and what of them is in the way."""

import numpy as np
import pytest

from facetlog.robot.rendering.worlds import BLOCK_CENTRE, INCH, make_world
from facetlog.robot.simulator.world_file import SceneSetup, SolidSetup, in_metres, make_scene


@pytest.mark.parametrize("name", ["block", "table", "clutter_block", "stairs"])
def test_a_named_world_is_the_same_in_metres(name: str) -> None:
    inches, metres = make_world(name, 4), in_metres(make_world(name, 4))
    for before, after in zip(inches.solids, metres.solids, strict=True):
        assert after.vertices == pytest.approx(INCH * before.vertices)
    assert inches.floor is not None
    assert metres.floor is not None
    assert inches.floor.texture is not None
    assert metres.floor.texture is not None
    assert metres.floor.texture.period == pytest.approx(INCH * inches.floor.texture.period)


def test_the_default_scene_is_the_papers_block_where_its_tour_looks() -> None:
    (block,) = make_scene(SceneSetup()).solids
    assert block.size == pytest.approx((0.254, 0.2032, 0.1524))
    middle = block.vertices.mean(axis=0)[:2]
    assert np.hypot(*(middle - INCH * np.array(BLOCK_CENTRE))) < 1.5 * INCH


@pytest.mark.parametrize(
    ("kind", "size", "extent"),
    [
        ("box", (0.3, 0.2, 0.1), (0.3, 0.2, 0.1)),
        ("pyramid", (0.3, 0.2, 0.1), (0.3, 0.2, 0.1)),
        ("cylinder", (0.4, 0.5), (0.4, 0.4, 0.5)),
        ("wedge", (0.3, 0.2), (0.3, 0.2, 0.2 * np.sqrt(0.75))),
        ("prism", (0.7,), (1.0, 2.0, 0.7)),
    ],
)
def test_own_solids_stand_where_they_are_put(
    kind: str, size: tuple[float, ...], extent: tuple[float, ...]
) -> None:
    plan = ((0.0, 0.0), (1.0, 0.0), (0.0, 2.0)) if kind == "prism" else ()
    solid = SolidSetup(kind, size, plan, at=(3.0, -1.0), albedo=0.5)  # type: ignore[arg-type]
    made = make_scene(SceneSetup(world="empty", solid=(solid,))).solids[0]
    assert np.ptp(made.vertices, axis=0) == pytest.approx(np.array(extent), abs=1e-3)
    assert made.vertices[:, 2].min() == 0.0
    assert set(made.albedo) == {0.5}
    if kind != "prism":
        low, high = made.vertices.min(axis=0), made.vertices.max(axis=0)
        assert (low + high)[:2] / 2 == pytest.approx(np.array([3.0, -1.0]))
