"""Simulated views of a world, as a robot would collect them.

Pictures are always taken in the world's own frame. The frame in which they are recorded may be
another one (`Similarity`), the recorded poses may have errors (`add_pose_noise`) or belong to
other pictures (`shuffled`): faults that a reader of the views must tolerate or detect.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.perception.types import Camera, FloatArray, Pose, View
from facetlog.robot.recording import Format, write_ground_truth, write_views
from facetlog.robot.rendering.render import render
from facetlog.robot.rendering.world import GroundTruth, World

# Accuracy of a pan-tilt head: some steps of its encoder and the backlash of its gears, radians.
HEAD_SD = float(np.radians(0.1))
# Place on the ground and heading among x, y, z and the rotations about them.
ON_GROUND = (0, 1, 5)


@dataclass(frozen=True, eq=False, slots=True)
class Similarity:
    """The change of frame x -> scale * rotation @ x + shift."""

    rotation: FloatArray
    shift: FloatArray
    scale: float = 1.0

    def __post_init__(self) -> None:
        pose = Pose(self.rotation, self.shift)  # checks and freezes both
        object.__setattr__(self, "rotation", pose.rotation)
        object.__setattr__(self, "shift", pose.centre)
        if not (np.isfinite(self.scale) and self.scale > 0):
            raise ValueError("the scale must be positive and finite")

    def view(self, view: View) -> View:
        """Return the view with its pose in the new frame."""
        centre = self.scale * self.rotation @ view.pose.centre + self.shift
        return replace(view, pose=Pose(self.rotation @ view.pose.rotation, centre))

    def truth(self, world: World) -> GroundTruth:
        """Return the true shapes of the world's solids in the new frame."""
        solids = tuple(s.moved(self.rotation, self.shift, self.scale) for s in world.solids)
        return replace(world, solids=solids).truth


def draw_similarity(
    rng: np.random.Generator, *, scale: float = 1.0, reach: float = 0.0
) -> Similarity:
    """Return a rotation drawn evenly from all, a shift of up to `reach` along each axis, and a
    scale.
    """
    rotation = Rotation.random(random_state=rng).as_matrix()
    return Similarity(rotation, rng.uniform(-reach, reach, 3), scale)


def views_of(
    world: World,
    poses: Sequence[Pose],
    camera: Camera,
    *,
    seed: int = 0,
    noise_sd: float = 5.0,
    blur_px: float = 1.0,
) -> tuple[View, ...]:
    """Return one view per pose, in the world's frame and unit; the noise of each follows from the
    seed.

    The noise of a view depends on its place in `poses` alone, not on the others.
    """
    return tuple(
        View(
            f"view{index:03d}.png",
            render(
                world,
                camera,
                pose,
                noise_sd=noise_sd,
                blur_px=blur_px,
                rng=np.random.default_rng([seed, index]),
            ),
            camera,
            pose,
        )
        for index, pose in enumerate(poses)
    )


def shuffled(views: Sequence[View], rng: np.random.Generator) -> tuple[View, ...]:
    """Return the views with their poses dealt out anew, so that no picture keeps its own.

    ValueError for fewer than two views.
    """
    if len(views) < 2:
        raise ValueError("the poses of fewer than two views cannot be shuffled")
    # A cycle through all views in random order leaves none in its place.
    order = rng.permutation(len(views))
    giver = {int(a): int(b) for a, b in zip(order, np.roll(order, 1), strict=True)}
    return tuple(replace(view, pose=views[giver[i]].pose) for i, view in enumerate(views))


def add_pose_noise(
    views: Sequence[View], rng: np.random.Generator, *, position_sd: float, angle_sd: float
) -> tuple[View, ...]:
    """Return the views with recorded poses off by normal errors: per axis, world units and
    radians.
    """
    noisy = []
    for view in views:
        turn = Rotation.from_rotvec(rng.normal(0.0, angle_sd, 3)).as_matrix()
        centre = view.pose.centre + rng.normal(0.0, position_sd, 3)
        noisy.append(replace(view, pose=Pose(view.pose.rotation @ turn, centre)))
    return tuple(noisy)


def add_drift(
    views: Sequence[View],
    rng: np.random.Generator,
    *,
    turn_sd: float,
    way_sd: float,
    head_sd: float = HEAD_SD,
) -> tuple[tuple[View, ...], FloatArray]:
    """Return the views with poses whose errors add up as a robot's odometry does, and their
    covariances.

    Each step from view to view rotates the robot by an error of `turn_sd` (radians) about the
    world's z and shifts it on the ground by `way_sd` times the step's length; its head has an
    independent error of `head_sd` at each view. Covariances (V, 6, 6) are of place and rotation
    vector in the world frame.
    """
    heading, place, cov = 0.0, np.zeros(3), np.zeros((3, 3))
    found: list[View] = []
    covs: list[FloatArray] = []
    before = views[0].pose.centre
    for view in views:
        step = view.pose.centre - before
        before = view.pose.centre
        sd = way_sd * float(np.linalg.norm(step[:2]))
        place = place + heading * np.array([-step[1], step[0], 0.0])
        place[:2] += rng.normal(0.0, sd, 2)
        if len(found):
            heading += rng.normal(0.0, turn_sd)
            carried = np.array([[1.0, 0.0, -step[1]], [0.0, 1.0, step[0]], [0.0, 0.0, 1.0]])
            cov = carried @ cov @ carried.T + np.diag([sd**2, sd**2, turn_sd**2])
        robot, head = Rotation.from_rotvec([0.0, 0.0, heading]), rng.normal(0.0, head_sd, 3)
        turn = (Rotation.from_rotvec(head) * robot).as_matrix()
        found.append(replace(view, pose=Pose(turn @ view.pose.rotation, view.pose.centre + place)))
        of_pose = np.diag([0.0] * 3 + [head_sd**2] * 3)
        of_pose[np.ix_(ON_GROUND, ON_GROUND)] += cov
        covs.append(of_pose)
    return tuple(found), np.array(covs)


def pose_errors(views: Sequence[View], true: Sequence[View]) -> tuple[float, float]:
    """Return rms errors of place (world units) and rotation (radians) after the best rigid
    alignment."""
    turns = Rotation.concatenate(
        [
            Rotation.from_matrix(t.pose.rotation @ v.pose.rotation.T)
            for v, t in zip(views, true, strict=True)
        ]
    )
    common = turns.mean()
    ours, theirs = (np.array([v.pose.centre for v in those]) for those in (views, true))
    left = common.apply(ours - ours.mean(axis=0)) - (theirs - theirs.mean(axis=0))
    angles = (turns * common.inv()).magnitude()
    return float(np.sqrt((left**2).sum(axis=1).mean())), float(np.sqrt((angles**2).mean()))


def simulate(
    folder: Path,
    world: World,
    poses: Sequence[Pose],
    camera: Camera,
    *,
    layout: Format = Format.PAN_TILT,
    unit: str = "in",
    seed: int = 0,
    noise_sd: float = 5.0,
    blur_px: float = 1.0,
    position_sd: float = 0.0,
    angle_sd: float = 0.0,
    shuffle: bool = False,
    frame: Similarity | None = None,
) -> tuple[View, ...]:
    """Write a folder of views and its ground_truth.json; returned are the views as recorded.

    `position_sd` (world units) and `angle_sd` (radians) put errors on the recorded poses,
    `shuffle` deals them out to the wrong pictures, and `frame` turns and scales poses and truth
    alike. `unit` names the unit of what is written. InputError if the folder cannot be written.
    """
    views = views_of(world, poses, camera, seed=seed, noise_sd=noise_sd, blur_px=blur_px)
    rng = np.random.default_rng([seed, len(views)])  # views_of uses [seed, 0 … len - 1]
    if position_sd > 0 or angle_sd > 0:
        views = add_pose_noise(views, rng, position_sd=position_sd, angle_sd=angle_sd)
    if shuffle:
        views = shuffled(views, rng)
    truth = world.truth
    if frame is not None:
        views = tuple(frame.view(view) for view in views)
        truth = frame.truth(world)
    write_views(folder, views, layout=layout, unit=unit)
    write_ground_truth(folder, truth, unit=unit)
    return views
