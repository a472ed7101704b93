"""Furniture is made of boxes that look outwards, do not run through one another, and stand."""

from itertools import combinations

import numpy as np
import pytest

from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.furniture import VARIED, bench, cabinet, desk, shelf, stairs, stool
from facetlog.robot.rendering.world import Solid

PIECES = {
    "desk on panels": (desk(60, 30, 30, thickness=1, panel=1, modesty=0.5), 4, (60, 30, 30)),
    "desk with a drawer block": (
        desk(60, 30, 30, thickness=1, panel=1, modesty=0.5, blocks=(16, 0)),
        4,
        (60, 30, 30),
    ),
    "bench on panels": (
        bench(50, 14, 18, thickness=1.5, support=1.5, panels=True),
        3,
        (50, 14, 18),
    ),
    "bench on legs": (bench(50, 14, 18, thickness=1.5, support=2, panels=False), 5, (50, 14, 18)),
    "stool": (stool(14, 13, 20, thickness=1.5, leg=1.5), 5, (14, 13, 20)),
    "shelf": (shelf(36, 12, 60, boards=5, thickness=1, back=False), 7, (36, 12, 60)),
    "shelf with a back": (shelf(36, 12, 60, boards=5, thickness=1, back=True), 8, (36, 12, 60)),
    "cabinet on a plinth": (cabinet(30, 16, 40, foot=3), 2, (30, 16, 40)),
    "cabinet on legs": (cabinet(30, 16, 40, foot=4, leg=2), 5, (30, 16, 40)),
}


def normal(corners: FloatArray) -> FloatArray:
    return np.asarray(np.cross(corners[1] - corners[0], corners[2] - corners[1]))


@pytest.mark.parametrize("name", PIECES)
def test_furniture_has_its_size_and_its_pieces(name: str) -> None:
    solid, pieces, size = PIECES[name]
    assert len(solid.vertices) == 8 * pieces
    assert solid.size == pytest.approx(size)
    assert solid.vertices.min(axis=0) == pytest.approx([-size[0] / 2, -size[1] / 2, 0])


@pytest.mark.parametrize("name", PIECES)
def test_pieces_touch_but_do_not_run_through_one_another(name: str) -> None:
    boxes = PIECES[name][0].vertices.reshape(-1, 8, 3)
    lows, highs = boxes.min(axis=1), boxes.max(axis=1)
    touching = {0}
    for _ in boxes:
        for i, j in combinations(range(len(boxes)), 2):
            shared = np.minimum(highs[i], highs[j]) - np.maximum(lows[i], lows[j])
            assert shared.min() < 1e-9
            if shared.min() > -1e-9 and touching & {i, j}:
                touching |= {i, j}
    assert touching == set(range(len(boxes)))


def _unit(solid: Solid, face: tuple[int, ...]) -> FloatArray:
    across = normal(solid.vertices[list(face)])
    return np.asarray(across / np.linalg.norm(across)) + 0.0


@pytest.mark.parametrize("steps", [2, 3, 5])
def test_stairs_are_closed_and_have_a_tread_and_a_riser_for_each_step(steps: int) -> None:
    solid = stairs(steps, 30, 7, 11)
    assert solid.size == pytest.approx((11 * steps, 30, 7 * steps))
    volume = sum(
        float(p[0] @ np.cross(p[i], p[i + 1])) / 6
        for p in (solid.vertices[list(face)] for face in solid.faces)
        for i in range(1, len(p) - 1)
    )
    assert volume == pytest.approx(30 * 7 * 11 * steps * (steps + 1) / 2)
    looks = [tuple(np.round(_unit(solid, face), 6)) for face in solid.faces]
    assert looks.count((0.0, 0.0, 1.0)) == steps
    assert looks.count((-1.0, 0.0, 0.0)) == steps


@pytest.mark.parametrize("name", VARIED)
def test_what_is_drawn_keeps_its_pieces_apart(name: str) -> None:
    for seed in range(40):
        solid = VARIED[name](np.random.default_rng(seed))
        assert solid.vertices[:, 2].min() == pytest.approx(0.0)
        if name in ("boxes", "stairs", "steps", "door"):
            continue
        boxes = solid.vertices.reshape(-1, 8, 3)
        for a, b in combinations(boxes, 2):
            shared = np.minimum(a.max(axis=0), b.max(axis=0)) - np.maximum(
                a.min(axis=0), b.min(axis=0)
            )
            assert shared.min() < 1e-9
