"""The simulated camera's renderer: a process of its own, so that rendering starves nothing else.

It reads viewpoints as lines of JSON from a socket and answers each with a JPEG; it ends when the
socket does. Its argument: the socket's number. The first message describes the world.
"""

import json
import sys
from contextlib import suppress
from dataclasses import asdict
from multiprocessing.connection import Connection

import cv2
import numpy as np
from pydantic import TypeAdapter

from facetlog.robot.simulator.camera.exposure import Exposures
from facetlog.robot.simulator.camera.viewpoint import Viewpoint
from facetlog.robot.simulator.scene import make_scene
from facetlog.robot.simulator.world_file import WorldSetup

__all__ = ["main", "opening_message", "viewpoints_message"]

# Keeps the pictures' noise apart from what else is drawn with the same seed.
PICTURE_STREAM = 3


def opening_message(setup: WorldSetup) -> bytes:
    """What is sent first."""
    return TypeAdapter(WorldSetup).dump_json(setup)


def viewpoints_message(start: Viewpoint, end: Viewpoint) -> bytes:
    """Where the camera was when an exposure began, and when it ended."""
    return json.dumps([asdict(start), asdict(end)]).encode()


def main(descriptor: int) -> None:
    """Answers until the other side goes away."""
    cv2.setNumThreads(1)
    with Connection(descriptor) as line, suppress(EOFError, OSError):
        setup = TypeAdapter(WorldSetup).validate_json(line.recv_bytes())
        exposures = Exposures(
            make_scene(setup.scene),
            setup.mount,
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
