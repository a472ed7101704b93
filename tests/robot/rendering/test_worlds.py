"""The named worlds: seeded, in view of the tour, and different from the floor they stand on."""

import numpy as np
import pytest

from facetlog.perception.types import Camera
from facetlog.robot.rendering.furniture import VARIED
from facetlog.robot.rendering.render import BACKGROUND, FLOOR, find_first_hits, render, seen_by
from facetlog.robot.rendering.worlds import INCH, WORLDS, make_world
from facetlog.robot.tour import tour_camera, tour_poses

PAPER_THRESHOLD = 150  # of 255, section 6
# What a person would call one of its kind.
REAL_HEIGHTS_M = {
    "boxes": (0.01, 1.2),
    "tables": (0.35, 1.15),
    "chairs": (0.75, 1.15),
    "desk": (0.69, 0.79),
    "bench": (0.39, 0.51),
    "stool": (0.41, 0.76),
    "shelf": (0.7, 2.05),
    "cabinet": (0.35, 2.15),
    "stairs": (0.45, 1.0),
    "steps": (0.35, 0.5),
    "bed": (0.55, 1.25),
    "sofa": (0.65, 0.95),
    "crate": (0.06, 0.55),
    "door": (1.9, 2.2),
    "frame": (0.18, 1.06),
}
SMALL = Camera(160, 120, tour_camera().fx / 4, tour_camera().fy / 4, 79.5, 59.5)


@pytest.mark.parametrize("name", WORLDS)
@pytest.mark.slow
def test_a_world_renders_and_follows_its_seed(name: str) -> None:
    def picture(seed: int) -> bytes:
        rng = np.random.default_rng(0)
        return render(make_world(name, seed), SMALL, tour_poses()[8], rng=rng).tobytes()

    assert picture(1) == picture(1)
    assert picture(1) != picture(2)


def test_an_unknown_world_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(ValueError, match="printed_block"):
        make_world("teapot")


@pytest.mark.parametrize("name", [n for n in WORLDS if n not in ("empty", "clutter_block")])
def test_the_object_stands_on_the_floor_and_inside_nearly_all_pictures(name: str) -> None:
    camera = tour_camera()
    for seed in range(5):
        (solid,) = make_world(name, seed).solids
        assert solid.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
        inside = 0
        for pose in tour_poses():
            x, y, z = ((solid.vertices - pose.centre) @ pose.rotation).T
            u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
            in_picture = (u > 5) & (u < camera.width - 6) & (v > 5) & (v < camera.height - 6)
            inside += bool((z > 0).all() and in_picture.all())
        assert inside >= (24 if name.endswith("block") else 20)


@pytest.mark.parametrize("name", VARIED)
def test_a_model_of_a_real_thing_varies_in_proportion_and_says_its_scale(name: str) -> None:
    shapes, heights = set(), []
    for seed in range(8):
        world = make_world(name, seed)
        (solid,) = world.solids
        heights.append(world.model_scale * float(solid.vertices[:, 2].max()) * INCH)
        shapes.add(tuple(np.round(np.array(solid.size) / solid.size[2], 3)))
    assert len(shapes) == 8
    low, high = REAL_HEIGHTS_M[name]
    assert low <= min(heights) < max(heights) <= high


def test_the_papers_threshold_parts_every_face_of_the_block_from_the_floor() -> None:
    for seed in range(12):
        world = make_world("block", seed)
        for pose in tour_poses()[seed % 4 :: 8]:
            image = render(world, SMALL, pose, noise_sd=0, blur_px=0, rng=np.random.default_rng(0))
            v, u = np.mgrid[0:120, 0:160].astype(np.float64)
            uv = np.stack([u.ravel(), v.ravel()])
            facet = find_first_hits(world, SMALL, pose, seen_by(world, SMALL, pose), uv).facet
            own = facet.reshape(120, 160)
            # Only pixels whose neighbours show the same: edges hold a mixture of both sides.
            same = np.ones_like(own, dtype=bool)
            for shift, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
                same &= np.roll(own, shift, axis) == own
            assert image[same & (own >= 0)].min() > PAPER_THRESHOLD + 10
            assert image[same & ((own == FLOOR) | (own == BACKGROUND))].max() < PAPER_THRESHOLD - 20


def test_clutter_keeps_off_the_block_and_the_cameras() -> None:
    for seed in range(10):
        block, *clutter = make_world("clutter_block", seed).solids
        middle = block.vertices.mean(axis=0)[:2]
        assert clutter
        for solid in clutter:
            reach = np.linalg.norm(solid.vertices[:, :2] - middle, axis=1)
            assert reach.min() > np.hypot(5, 4)
            gaps = solid.vertices[:, None] - [pose.centre for pose in tour_poses()]
            assert np.linalg.norm(gaps, axis=2).min() > 5
