"""A small collection that is known to the last digit: a box, two views, and the way between."""

import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from facetlog.kb.explaining.verdict import Recognition
from facetlog.kb.recognize import judge_scene
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.types import Camera, Image
from facetlog.pipeline import open_models
from facetlog.recordings.frames import Moment, read_candidate_views
from facetlog.robot.camera.checks import Quality
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.record import WAY_FILE, Record, Taken, format_robot_tum
from facetlog.robot.collecting.run_sessions import Run
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2

BEGAN = 1_700_000_000.125
START = Pose2(0.4, -0.2, math.radians(30.0))
RUN = Run(BEGAN, START)
OPTICS = Optics(Camera(64, 48, 50.0, 51.0, 31.0, 23.5), "OPENCV", (("k1", -0.1), ("p2", 0.002)))
SPEED = 0.2
# Three views could have been the second; the one that promised half as much a second was nearer.
CHOICE = {
    "result": "chosen",
    "image": "view2.png",
    "candidates": [
        [1.0, 0.0, 0.7, 0.4, 8.0, 1],
        [0.0, 1.0, 0.7, 0.2, 8.0, 0],
        [0.0, -1.0, 0.7, 0.0, 5.0, 0],
    ],
}


@dataclass(frozen=True)
class Collection:
    """Its views, their pictures, and what is known at the end."""

    taken: tuple[Taken, ...]
    images: tuple[Image, ...]
    way: tuple[tuple[float, Pose2], ...]
    scene: Scene
    recognition: Recognition

    def moments(self) -> list[Moment]:
        """Nothing is known after the first view."""
        pictures = [cv2.imencode(".png", image)[1].tobytes() for image in self.images]
        first, second = (
            Moment(view, picture, OPTICS, RUN, tuple(p for p in self.way if low < p[0] <= high))
            for view, picture, (low, high) in zip(
                self.taken,
                pictures,
                ((0.0, self.taken[0].time), (self.taken[0].time, self.taken[1].time)),
                strict=True,
            )
        )
        return [
            first,
            Moment(
                second.taken,
                second.picture,
                OPTICS,
                RUN,
                second.way,
                self.scene,
                self.recognition,
                read_candidate_views([CHOICE], second.taken.name),
            ),
        ]

    def write(self, folder: Path) -> None:
        """As `facetlog collect` leaves it."""
        record = Record(folder, OPTICS, {"tour": "two", "began": BEGAN, "start": [0.4, -0.2, 30.0]})
        for view, image in zip(self.taken, self.images, strict=True):
            if view.name == CHOICE["image"]:
                record.note(CHOICE)
            record.add(view, image)
        (folder / WAY_FILE).write_text(format_robot_tum(self.way), encoding="utf-8")


def collection() -> Collection:
    """The robot drives straight ahead, 1 m between the views."""
    rng = np.random.default_rng(3)
    way = tuple(
        (BEGAN + 0.1 * i, START.compose(Pose2(0.1 * SPEED * i, 0.0, 0.0))) for i in range(71)
    )
    views, images = [], []
    for number, (at, pan) in enumerate(((1.0, 0.3), (6.0, -0.7)), start=1):
        odometry = Pose2(SPEED * at, 0.0, 0.0)
        robot = START.compose(odometry)
        root = rng.normal(size=(6, 6)) * 0.01
        views.append(
            Taken(
                number,
                f"view{number}.png",
                camera_pose(robot, DEFAULT_MOUNT, Gaze(pan, -0.2)),
                root @ root.T,
                robot,
                odometry,
                pan,
                -0.2,
                0,
                BEGAN + at,
                Quality(1.0, 1.0, 0.0),
            )
        )
        images.append(rng.integers(0, 255, (48, 64), dtype=np.uint8))
    scene = cuboid(0.3, 0.2, 0.1)
    facts = [fact.row for fact in scene_facts(scene)]
    with open_models() as base:
        found = judge_scene(
            base, "box", facts, on_demand=lambda: (f.row for f in facts_on_demand(scene))
        )
    return Collection(tuple(views), tuple(images), way, scene, found)
