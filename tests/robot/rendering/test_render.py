"""What the pictures show lies where the ground truth projects to, in the light it should."""

import cv2
import numpy as np
import pytest

from facetlog.perception.types import Camera, FloatArray, Image, View
from facetlog.robot.rendering.render import render
from facetlog.robot.rendering.solids import cuboid, placed
from facetlog.robot.rendering.texture import Sheet
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import Floor, World
from facetlog.robot.tour import make_pose_looking_at, make_ring_poses, tour_camera

SMALL = Camera(160, 120, 130.0, 130.0, 79.5, 59.5)
HALF_PROFILE_PX = 5.0


def clean(world: World, camera: Camera, eye: list[float], aim: list[float]) -> Image:
    rng = np.random.default_rng(0)
    return render(world, camera, make_pose_looking_at(eye, aim), noise_sd=0.0, blur_px=0.0, rng=rng)


def project(view: View, points: FloatArray) -> FloatArray:
    h = np.column_stack([points, np.ones(len(points))]) @ view.projection.T
    return np.asarray(h[:, :2] / h[:, 2:])


def edge_offsets(image: Image, start: FloatArray, end: FloatArray) -> FloatArray:
    """Signed distances (px) of the step in the picture from a line, along its middle half.

    For a step from level a to b at x0 the integral of (I - a) / (b - a) over [-h, h] is h - x0,
    however it is blurred. Steps of little contrast are left out: rounding to whole greys moves
    them.
    """
    along = (end - start) / np.linalg.norm(end - start)
    normal = np.array([-along[1], along[0]])
    steps = np.linspace(-HALF_PROFILE_PX, HALF_PROFILE_PX, 201)
    offsets = []
    for share in np.linspace(0.3, 0.7, 21):
        at = start + share * (end - start) + steps[:, None] * normal
        x, y = at[:, 0].astype(np.float32), at[:, 1].astype(np.float32)
        profile = cv2.remap(image.astype(np.float32), x, y, cv2.INTER_LINEAR).ravel()
        low, high = profile[:10].mean(), profile[-10:].mean()
        flat = profile[:10].std() < 0.5 and profile[-10:].std() < 0.5
        if flat and abs(high - low) > 60:
            rise = (profile - low) / (high - low)
            offsets.append(HALF_PROFILE_PX - np.trapezoid(rise, steps))
    return np.array(offsets)


@pytest.mark.parametrize("blur_px", [0.0, 1.0])
def test_edges_lie_on_the_projected_truth_to_a_twentieth_of_a_pixel(blur_px: float) -> None:
    # No cast shadow and no texture: both sides of each edge are flat.
    block = placed(cuboid(10, 8, 6), 23.2, 56.1, yaw=0.4)
    sun = np.array([1.0, 1.0, 2.0])
    world = World((block,), Floor(0.1), sun, ambient=1.0, sided=0.0, exposure=1.0)
    poses = make_ring_poses([23.2, 56.1, 3], 30, (15.0, 22.0), 5, jitter=0.1)
    medians = []
    for view in views_of(world, poses, tour_camera(), noise_sd=0, blur_px=blur_px):
        pixels = project(view, block.vertices)
        hull = cv2.convexHull(pixels.astype(np.float32)).reshape(-1, 2)
        for i, j in block.edges:
            on_hull = all(np.linalg.norm(hull - pixels[k], axis=1).min() < 1e-3 for k in (i, j))
            if on_hull and np.linalg.norm(pixels[i] - pixels[j]) > 40:
                offsets = edge_offsets(view.image, pixels[i], pixels[j])
                if len(offsets) == 21:
                    medians.append(np.median(offsets))
    assert len(medians) >= 20
    assert np.abs(medians).max() < 0.05
    assert abs(np.mean(medians)) < 0.01


def test_the_edge_of_a_shadow_lies_where_the_sun_throws_it() -> None:
    # Sun in the plane of x and z at 45 degrees: a wall 2 high at x = 0 shades 0 < x < 2.
    wall = placed(cuboid(0.1, 400, 2), -0.05, 0)
    world = World(
        (wall,), Floor(0.8), np.array([-1.0, 0.0, 1.0]), ambient=0.3, sided=0.0, exposure=1.0
    )
    camera = Camera(101, 11, 100.0, 100.0, 50.0, 5.0)
    view = views_of(
        world,
        [make_pose_looking_at([2.0, -1e-6, 10.0], [2.0, 0, 0])],
        camera,
        noise_sd=0,
        blur_px=0,
    )[0]
    centre, up_the_picture = view.image[5], view.image[:, 50]
    dark, bright = round(255 * 0.8 * 0.3), round(255 * 0.8 * (0.3 + 0.7 * np.sqrt(0.5)))
    assert centre[31:50].tolist() == [dark] * 19
    assert centre[51:].tolist() == [bright] * 50
    # The shadow ends in the middle of pixel 50: half of it is in the sun.
    assert np.abs(up_the_picture - (dark + bright) / 2).max() <= 0.02 * (bright - dark) + 1


def test_faces_have_the_greys_of_lambert_and_ambient_light() -> None:
    sun = np.array([0.0, -1.0, 1.0])
    block = cuboid(4, 4, 4, albedo=0.5)
    world = World((block,), Floor(0.2), sun, background=33, ambient=0.4, sided=0.0, exposure=1.0)
    picture = clean(world, SMALL, [0, -10, 6], [0, 0, 3])
    top = 255 * 0.5 * (0.4 + 0.6 * np.sqrt(0.5))
    assert set(np.unique(picture[60:70, 75:85])) == {round(top)}
    away = clean(world, SMALL, [0, 10, 3], [0, 0, 2])  # the face in its own shade
    assert set(np.unique(away[58:62, 75:85])) == {round(255 * 0.5 * 0.4)}
    assert away[0, 0] == 33


def test_noise_has_its_sd_and_blur_keeps_the_mean() -> None:
    world = World((), None, np.array([0.0, 0.0, 1.0]), background=120)
    pose = make_pose_looking_at([0, 0, 1], [1, 0, 1])
    image = render(world, SMALL, pose, noise_sd=5.0, blur_px=2.0, rng=np.random.default_rng(3))
    assert image.mean() == pytest.approx(120, abs=0.2)
    assert image.std() == pytest.approx(5.0, abs=0.2)


def test_a_sheet_lies_on_the_floor_the_right_way_round() -> None:
    printed = np.ones((20, 30), dtype=np.float32)
    printed[:10, 15:] = 0.2  # its far right quarter, as who stands at -y sees it
    world = World((), Floor(0.5, Sheet(printed, (6.0, 4.0), 0.6)), np.array([0.0, 0.0, 1.0]))
    eye, aim = [0.0, -6.0, 8.0], [0.0, 0.0, 0.0]
    view = View("a", clean(world, SMALL, eye, aim), SMALL, make_pose_looking_at(eye, aim))
    spots = np.array([[1.5, 1.0, 0], [-1.5, 1.0, 0], [1.5, -1.0, 0], [3.6, 0, 0]])
    grey = [int(view.image[v, u]) for u, v in np.rint(project(view, spots)).astype(int)]
    assert grey[1] == grey[2]
    assert grey[0] == pytest.approx(0.2 * grey[1], abs=1)
    assert grey[3] == pytest.approx(0.6 * grey[1], abs=1)
