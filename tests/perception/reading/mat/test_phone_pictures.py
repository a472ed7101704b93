"""From pictures as a phone takes them, of a thing on a mat and nothing else, to what it is."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import facetlog
from facetlog.perception.reading.mat.mat_poses import PlacedPicture, find_mat_pictures
from facetlog.perception.types import Camera, Pose
from facetlog.robot.rendering.solids import chair, cuboid, placed, table
from facetlog.robot.rendering.texture import Pattern, Sheet, Texture
from facetlog.robot.rendering.world import Floor, Solid, World
from facetlog.robot.tour import make_ring_poses
from tests.perception.reading.mat.mat_photos import A3, PX_PER_MM, sheet
from tests.robot.phone import Phone, take_phone_picture

SUN = np.array([0.5, -0.3, 1.2])
WHITE = 230.0


def on_the_mat(*solids: Solid) -> World:
    """Solids on an A3 mat on a wooden floor, in metres."""
    printed = (sheet(A3, PX_PER_MM) / WHITE).astype(np.float32)
    size = A3.width_mm / 1000, A3.height_mm / 1000
    wood = Texture(Pattern.WOOD, 3, 1.2, 0.35)
    return World(solids, Floor(0.9, Sheet(printed, size, 0.4, wood)), SUN, exposure=1.05)


def taken(world: World, poses: tuple[Pose, ...], camera: Camera, folder: Path, seed: int) -> Phone:
    """The folder with JPEG pictures of the world from these poses, and the phone."""
    rng = np.random.default_rng(seed)
    phone = Phone(camera)
    for number, pose in enumerate(poses):
        picture = take_phone_picture(world, phone, pose, rng)
        quality = [cv2.IMWRITE_JPEG_QUALITY, phone.jpeg_quality]
        assert cv2.imwrite(str(folder / f"{number:02d}.jpg"), picture, quality)
    return phone


def squared_errors(found: tuple[PlacedPicture, ...], poses: tuple[Pose, ...]) -> list[float]:
    """Normalised squared error of each pose, of six degrees of freedom."""
    errors = []
    for each in found:
        true, pose = poses[int(each.picture.shot.path.stem)], each.placed.pose
        turn = Rotation.from_matrix(true.rotation @ pose.rotation.T).as_rotvec()
        off = np.concatenate([true.centre - pose.centre, turn])
        errors.append(float(off @ np.linalg.solve(each.placed.cov, off)))
    return errors


THINGS: dict[str, Callable[[], Solid]] = {
    "box": lambda: cuboid(0.18, 0.12, 0.1, albedo=0.8),
    "table": lambda: table(0.24, 0.17, 0.14, thickness=0.014, leg=0.018, albedo=0.7),
    "chair": lambda: chair(0.13, 0.13, 0.13, 0.14, thickness=0.014, leg=0.015, albedo=0.7),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", THINGS)
def test_a_thing_on_a_mat_is_what_it_is_and_as_large_as_it_is(name: str, tmp_path: Path) -> None:
    camera = Camera(960, 720, 900.0, 900.0, 483.0, 356.0)
    rng = np.random.default_rng(4)
    poses = make_ring_poses((0, 0, 0.04), 0.5, (0.28, 0.42, 0.58), 14, jitter=0.06, rng=rng)
    solid = placed(THINGS[name](), 0.0, 0.0, yaw=0.4)
    phone = taken(on_the_mat(solid), poses, camera, tmp_path, seed=2)
    seen = find_mat_pictures(tmp_path)
    found = seen.pictures
    assert (seen.left_out, seen.faults) == ((), ())
    assert np.mean(squared_errors(found, poses)) < 12
    off = found[0].camera.lens[:2] - phone.lens[:2]
    assert (np.abs(off) < 4 * np.sqrt(np.diag(found[0].camera.cov)[3:5])).all()

    result = facetlog.recognize(tmp_path)
    assert f"is a {name} (" in str(result)
    true = np.sort(np.ptp(THINGS[name]().vertices, axis=0))
    points = np.array([vertex.point for vertex in result.scene.vertices])
    high = points[:, 2].max() - points[:, 2].min()
    assert high == pytest.approx(np.ptp(THINGS[name]().vertices[:, 2]), abs=0.004)
    assert np.ptp(points[:, :2], axis=0).max() < 1.1 * float(np.hypot(*true[-2:]))
