"""Pictures as a phone takes them: a lens that bends, hands that shake, rows exposed in turn, JPEG.

The world is rendered by a pinhole camera that sees more; each pixel of the phone's picture is then
taken from where its ray meets that picture. A rotation of the camera moves all rays alike whatever
their length, so that this is exact for shaking by rotation.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.perception.types import Camera, FloatArray, Image, Pose
from facetlog.robot.rendering.render import render
from facetlog.robot.rendering.world import World

# The pinhole's picture is finer, for it is sampled again, and wider, for rays bend and shake.
FINER, WIDER = 1.25, 1.12
INSTANTS = 7
"""Of an exposure: a blur of that many pixels has no gaps."""
LENS_ROUNDS = 30
"""Each brings the rays of a usual lens ten times nearer."""


@dataclass(frozen=True, eq=False, slots=True)
class Phone:
    """A phone's camera, and how it is held.

    `lens` is OpenCV's k1, k2, p1, p2, k3. While the rows are exposed, and during the exposure of
    each, it rotates by normal angles of these standard deviations, in radians. `noise_sd` is in
    grey levels, `blur_px` the focus.
    """

    camera: Camera
    lens: tuple[float, float, float, float, float] = (0.08, -0.2, 3e-4, -3e-4, 0.1)
    rolling_sd: float = 3e-4
    shaking_sd: float = 2e-4
    noise_sd: float = 3.0
    blur_px: float = 0.7
    jpeg_quality: int = 92


def take_phone_picture(world: World, phone: Phone, pose: Pose, rng: np.random.Generator) -> Image:
    """The picture (H, W) that a phone at a pose, which is that of its middle row, takes."""
    camera = phone.camera
    wide, high = (round(FINER * WIDER * n) for n in (camera.width, camera.height))
    focal = FINER * camera.fx
    pinhole = Camera(wide, high, focal, focal, (wide - 1) / 2, (high - 1) / 2)
    seen = render(world, pinhole, pose, noise_sd=0.0, blur_px=FINER / 2, rng=rng)
    rays = _rays(phone)
    rolling, shaking = rng.normal(0.0, phone.rolling_sd, 3), rng.normal(0.0, phone.shaking_sd, 3)
    rows = np.arange(camera.height) / camera.height - 0.5
    picture = np.zeros((camera.height, camera.width))
    for instant in np.linspace(-0.5, 0.5, INSTANTS):
        turns = Rotation.from_rotvec(np.outer(rows, rolling) + instant * shaking).as_matrix()
        x, y, z = np.einsum("rij,rcj->irc", turns, rays)
        u = (pinhole.cx + focal * x / z).astype(np.float32)
        v = (pinhole.cy + focal * y / z).astype(np.float32)
        picture += cv2.remap(seen, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    picture = np.asarray(cv2.GaussianBlur(picture / INSTANTS, (0, 0), phone.blur_px))
    noisy = picture + rng.normal(0.0, phone.noise_sd, picture.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def _rays(phone: Phone) -> FloatArray:
    """The rays (H, W, 3) of all pixels in the camera's axes: the lens's formula solved for them."""
    camera = phone.camera
    matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    v, u = np.mgrid[0 : camera.height, 0 : camera.width].astype(np.float64)
    pixels = np.stack([u, v], axis=-1)
    rounds = (cv2.TERM_CRITERIA_COUNT, LENS_ROUNDS, 0.0)
    flat = cv2.undistortPoints(
        pixels.reshape(-1, 1, 2), matrix, np.array(phone.lens), criteria=rounds
    ).reshape(pixels.shape)
    return np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)
