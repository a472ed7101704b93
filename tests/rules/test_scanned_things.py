"""Things that a scan shows from one side: two sides are enough for a box, and for nothing else."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.brief_verdict import BriefVerdict
from facetlog.kb.explaining.proof import State
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.scene import Body, Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import polyhedron, seen_from

# From the front, a corner, the other corner and behind, each in turn from a little and far above.
AZIMUTHS = (20.0, 110.0, 200.0, 290.0)
HEIGHTS = (4.0, 40.0)
NO_BOXES = (
    *("tray", "pyramid", "wedge", "l_block", "room_corner", "table"),
    *("desk", "chair", "stool", "bench", "shelf", "stairs"),
)


@pytest.fixture(scope="module")
def judge() -> Iterator[BatchJudge]:
    with BatchJudge() as judge:
        yield judge


def scanned(scene: Scene, azimuth: float, height: float) -> Scene:
    """Return view of the scene by a sensor from this direction, degrees, as a body."""
    around, over = np.deg2rad([azimuth, height])
    way = np.array([np.cos(over) * np.cos(around), np.cos(over) * np.sin(around), np.sin(over)])
    middle = scene.points.mean(axis=0)
    seen = seen_from(scene, middle + 3.0 * np.linalg.norm(np.ptp(scene.points, axis=0)) * way)
    body = Body(tuple(range(len(seen.faces))), tuple(range(len(seen.edges))))
    return replace(seen, bodies=(body,))


def box(judge: BatchJudge, scene: Scene) -> BriefVerdict:
    """Return the verdict on the only thing."""
    (verdict,) = [found for found in judge.judge(fact_rows(scene)) if found.model == "box"]
    return verdict


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_two_sides_are_a_box_half_as_sure_as_three(judge: BatchJudge, azimuth: float) -> None:
    block = build("cuboid", {})
    two, three = (box(judge, scanned(block, azimuth, height)) for height in (0.0, 40.0))
    assert (two.state, three.state) == (State.HOLDS, State.HOLDS)
    assert [len(names) for _, names in two.parts] == [1, 1, 0]
    assert two.degree == pytest.approx(0.5 * three.degree, abs=0.02)


def test_one_side_is_no_box(judge: BatchJudge) -> None:
    assert box(judge, scanned(build("cuboid", {}), 0.0, 0.0)).state is not State.HOLDS


def test_two_sides_in_pictures_are_a_box_as_in_a_scan(judge: BatchJudge) -> None:
    scan = scanned(build("cuboid", {}), 20.0, 0.0)
    pictures = box(judge, replace(scan, bodies=()))
    assert (pictures.state, pictures.degree) == (State.HOLDS, box(judge, scan).degree)


@pytest.mark.parametrize("name", NO_BOXES)
@pytest.mark.slow
def test_what_is_no_box_passes_for_none_from_whichever_side(judge: BatchJudge, name: str) -> None:
    thing = build(name, {})
    for azimuth in AZIMUTHS:
        for height in HEIGHTS:
            verdict = box(judge, scanned(thing, azimuth, height))
            assert verdict.state is not State.HOLDS, (azimuth, height, verdict)


@pytest.mark.parametrize("builder", ["cuboid", "l_block"])
def test_the_verdict_on_a_scan_does_not_need_up_or_scale(judge: BatchJudge, builder: str) -> None:
    seen = scanned(build(builder, {}), 20.0, 0.0)
    loose = replace(seen, up=None, metric=False)
    assert box(judge, loose).state is box(judge, seen).state


def seat_of_bars(*, back: bool) -> Scene:
    """Return a seat seen from above on four legs, with or without two posts and two rails on its
    rear: all bars are known as edges alone.
    """
    slab = [(x, y, z) for z in (0.42, 0.46) for y in (0.0, 0.42) for x in (0.0, 0.42)]
    feet = [(x, y, 0.0) for x, y, _ in slab[:4]]
    posts = [(x, 0.42, z) for x in (0.01, 0.41) for z in (0.46, 0.9)]
    rails = [(x, 0.42, z) for z in (0.7, 0.89) for x in (0.01, 0.41)]
    bars = [(i, 8 + i) for i in range(4)] + [
        (12 + i, 13 + i) for i in range(0, 8 if back else 0, 2)
    ]
    faces = [(4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    return polyhedron([*slab, *feet, *posts, *rails], faces, bars)


def test_a_back_of_bars_is_a_chair_s(judge: BatchJudge) -> None:
    held = {
        back: {
            v.model
            for v in judge.judge(fact_rows(seat_of_bars(back=back)))
            if v.state is State.HOLDS
        }
        for back in (True, False)
    }
    assert "chair" in held[True]
    assert "table" not in held[True]
    assert "chair" not in held[False]
