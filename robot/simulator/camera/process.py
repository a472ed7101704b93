"""The simulated camera's renderer, in a process of its own so that rendering blocks nothing else.

It reads viewpoints as lines of JSON from a socket and answers each with a JPEG; it ends when the
socket closes. Its argument: the socket's number. The first message describes the world.

At rest the sharp picture is rendered once and gets new noise for each exposure. While robot or head
move, a picture that would be blurred anyway is rendered smaller and enlarged, to be ready in time.
"""

import json
import sys
from contextlib import suppress
from dataclasses import asdict
from multiprocessing.connection import Connection

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from facetlog.perception.types import Camera, FloatArray, Image, Pose
from facetlog.robot.mount.mount import Mount
from facetlog.robot.rendering.render import render
from facetlog.robot.rendering.world import World
from facetlog.robot.simulator.camera.viewpoint import Viewpoint, make_camera
from facetlog.robot.simulator.world_file import CameraSetup, WorldSetup, make_scene

# Below this motion blur two viewpoints are one: a hundredth of what the renderer resolves.
STILL_PX = 1e-3
# A picture that is smeared by so many pixels is rendered at this scale.
SCALES = ((8.0, 0.25), (3.0, 0.5))
# Moments of an exposure, of which the smeared picture is the mean; fewer if it is smeared little.
MOST_MOMENTS = 16
# A level or rising view meets no floor: it is treated as one that falls by so much a metre, and the
# plane is never nearer than this, metres.
LEAST_FALL, LEAST_AHEAD = 0.2, 0.3
# Points of the picture whose motion is looked at, as shares of its size: corners and middle.
PROBES = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.5))


GreySum = NDArray[np.float32]


def _compute_homography(camera: Camera, start: Pose, end: Pose) -> FloatArray:
    """Return homography (3, 3) from pixels of one picture to those of another.

    Exact for what lies in the plane square to the view through the point of the floor that the
    middle of the picture shows, and for everything if the camera only turns.
    """
    # X_end = R X_start + t, and X_start lies d ahead: H = K (R + t (0, 0, 1) / d) K⁻¹
    R = end.rotation.T @ start.rotation
    t = end.rotation.T @ (start.centre - end.centre)
    falling = max(-start.rotation[2, 2], LEAST_FALL)
    d = max(float(start.centre[2]) / falling, LEAST_AHEAD)
    K = camera.matrix
    return np.asarray(K @ (R + np.outer(t, [0.0, 0.0, 1.0]) / d) @ np.linalg.inv(K))


def measure_smear_px(camera: Camera, start: Pose, end: Pose) -> float:
    """Return the most pixels that a picture moves between two poses; see `_compute_homography`."""
    size = np.array([camera.width - 1, camera.height - 1])
    pixels = np.array([(*(size * probe), 1.0) for probe in PROBES]).T
    moved = _compute_homography(camera, start, end) @ pixels
    return float(np.hypot(*(moved[:2] / moved[2] - pixels[:2])).max())


class Exposures:
    """Pictures of a world from viewpoints; keeps the sharp one that it rendered last."""

    def __init__(
        self, world: World, mount: Mount, setup: CameraSetup, rng: np.random.Generator
    ) -> None:
        self._world, self._mount, self._setup, self._rng = world, mount, setup, rng
        self._camera = make_camera(setup)
        self._from: Pose | None = None
        self._sharp: Image | None = None

    def expose(self, start: Viewpoint, end: Viewpoint) -> Image:
        """Render the picture (H, W) of an exposure between two viewpoints."""
        pose = start.camera_pose(self._mount)
        smear = measure_smear_px(self._camera, pose, end.camera_pose(self._mount))
        still = smear < STILL_PX
        picture = self._expose_at_rest(pose) if still else self._expose_moving(start, end, smear)
        noise = self._rng.standard_normal(picture.shape, dtype=np.float32)
        noise *= self._setup.noise
        return np.asarray(np.clip(np.rint(picture + noise), 0, 255), dtype=np.uint8)

    def _expose_at_rest(self, pose: Pose) -> Image:
        before = self._from
        if (
            self._sharp is None
            or before is None
            or measure_smear_px(self._camera, before, pose) > STILL_PX
        ):
            self._sharp, self._from = self._render(pose, 1.0), pose
        return self._sharp

    def _expose_moving(self, start: Viewpoint, end: Viewpoint, smear: float) -> GreySum:
        """Return the mean of the picture from the middle of the way, moved to moments of the
        exposure.
        """
        pose = start.towards(end, 0.5).camera_pose(self._mount)
        sharp = self._render(pose, next((scale for least, scale in SCALES if smear >= least), 1.0))
        moments = min(MOST_MOMENTS, 2 + round(smear))
        total: GreySum = np.zeros(sharp.shape, dtype=np.float32)
        for share in (np.arange(moments) + 0.5) / moments:
            moved_to = start.towards(end, float(share)).camera_pose(self._mount)
            there = _compute_homography(self._camera, pose, moved_to)
            size = (self._camera.width, self._camera.height)
            moved = cv2.warpPerspective(sharp, there, size, borderMode=cv2.BORDER_REPLICATE)
            cv2.accumulate(moved, total)
        return total / np.float32(moments)

    def _render(self, pose: Pose, scale: float) -> Image:
        camera = make_camera(self._setup, scale)
        blur = self._setup.blur * scale
        rng = self._rng  # not used without noise
        picture = render(self._world, camera, pose, noise_sd=0.0, blur_px=blur, rng=rng)
        if scale == 1.0:
            return picture
        size = (self._camera.width, self._camera.height)
        larger = cv2.resize(picture, size, interpolation=cv2.INTER_LINEAR)
        return np.asarray(larger, dtype=np.uint8)


# Keeps the pictures' noise apart from what else is drawn with the same seed.
PICTURE_STREAM = 3


def encode_setup(setup: WorldSetup) -> bytes:
    return TypeAdapter(WorldSetup).dump_json(setup)


def encode_viewpoints(start: Viewpoint, end: Viewpoint) -> bytes:
    """Encode where the camera was when an exposure began and ended."""
    return json.dumps([asdict(start), asdict(end)]).encode()


def main(descriptor: int) -> None:
    """Answer until the other side closes the connection."""
    cv2.setNumThreads(1)
    with Connection(descriptor) as line, suppress(EOFError, OSError):
        setup = TypeAdapter(WorldSetup).validate_json(line.recv_bytes())
        exposures = Exposures(
            make_scene(setup.scene),
            setup.mount.mount,
            setup.camera,
            np.random.default_rng([setup.seed, PICTURE_STREAM]),
        )
        while True:
            start, end = (Viewpoint(**each) for each in json.loads(line.recv_bytes()))
            picture = exposures.expose(start, end)
            quality = [cv2.IMWRITE_JPEG_QUALITY, setup.camera.quality]
            line.send_bytes(cv2.imencode(".jpg", picture, quality)[1].tobytes())


if __name__ == "__main__":
    main(int(sys.argv[1]))
