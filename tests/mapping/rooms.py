"""Things at known places, as scenes of a visit find them."""

import math
from pathlib import Path

import numpy as np

from facetlog.kb.explaining.verdict import Recognition
from facetlog.mapping.placed_thing import PlacedThing, Said, place_things
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved
from facetlog.perception.types import Pose, View
from facetlog.robot.camera.checks import Quality
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.record import WAY_FILE, Record, Taken, format_robot_tum
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.solids import cuboid as solid_cuboid
from facetlog.robot.rendering.solids import placed
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import INCH, make_world
from facetlog.robot.tour import make_pose_looking_at, tour_camera

SD = 0.002


def box_at(
    x: float, y: float, heading: float = 0.0, size: tuple[float, float, float] = (0.4, 0.3, 0.2)
) -> Scene:
    """An exact box on the floor, whose plan has its middle there."""
    c, s = math.cos(heading), math.sin(heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    scene = cuboid(*size, sd=SD)
    low, high = scene.points.min(axis=0), scene.points.max(axis=0)
    middle = np.array([*(low + high)[:2] / 2, low[2]])
    return moved(scene, turn, np.array([x, y, 0.0]) - turn @ middle)


def box_thing(
    x: float,
    y: float,
    heading: float = 0.0,
    size: tuple[float, float, float] = (0.4, 0.3, 0.2),
    *,
    visit: str = "one",
    model: str = "box",
    pose_sd: float = 0.0,
) -> PlacedThing:
    """That box as a visit placed it, with a common error of its robot's place."""
    (thing,) = place_things(
        box_at(x, y, heading, size),
        Recognition("scene", ()),
        visit,
        (Pose(np.eye(3), np.array([x, y, 0.0])),),
        np.diag([pose_sd**2] * 2 + [0.0] * 4)[None],
    )
    said = (Said(model, 0.8, "80%", f"t1 is a {model}"),) if model else ()
    return PlacedThing(
        (visit, "t1"),
        thing.box,
        thing.common,
        thing.outline,
        thing.low,
        thing.high,
        thing.seen,
        said,
        thing.triangles,
    )


def block_world(x: float = 0.0) -> World:
    """A block of the paper's size, its middle so far along x from the world's origin, in inches."""
    world = make_world("empty")
    block = placed(solid_cuboid(10.0, 8.0, 6.0, name="block"), x, 0.0, yaw=0.4)
    return World((block,), world.floor, world.sun, name="block")


def write_visit(
    folder: Path,
    first: float,
    *,
    count: int = 4,
    stated: bool = True,
    x: float = 0.0,
    began: float = 1e9,
) -> None:
    """Write a collection's folder of rendered views of the block from neighbouring places. The
    block is at `x` (m), the first view was taken a second after it `began`.
    """
    poses = []
    for k in range(count):
        angle = first + 0.45 * k
        place = [x / INCH + 34.0 * math.cos(angle), 34.0 * math.sin(angle), 28.5]
        poses.append(make_pose_looking_at(place, [x / INCH, 0.0, 3.0]))
    views = views_of(block_world(x / INCH), poses, tour_camera(), noise_sd=3.0)
    about = {"tour": "block", "start": [0.0, 0.0, 0.0], "start_stated": stated}
    record = Record(folder, Optics(tour_camera()), about)
    way = []
    for number, view in enumerate(views, start=1):
        taken = _taken(number, view, began)
        record.add(taken, view.image)
        way.append((taken.time, taken.robot))
    (folder / WAY_FILE).write_text(format_robot_tum(way), encoding="utf-8")


def _taken(number: int, view: View, began: float) -> Taken:
    pose = Pose(view.pose.rotation, view.pose.centre * INCH)
    x, y = pose.centre[:2].tolist()
    ahead = pose.rotation[:, 2]
    robot = Pose2(x, y, math.atan2(ahead[1], ahead[0]))
    cov = np.diag([1e-6] * 6)
    sharp = Quality(1.0, 1.0, 0.0)
    return Taken(number, view.name, pose, cov, robot, robot, 0.0, 0.0, 0, began + number, sharp)
