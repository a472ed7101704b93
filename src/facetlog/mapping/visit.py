"""A collection's folder as the map takes it: its runs, its way, and its views in groups."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from facetlog.errors import InputError
from facetlog.mapping.sonar_beams import Driven, driven
from facetlog.perception.estimation.pose_refinement.pose_chain import (
    OWN_SD,
    added,
    convert_to_twist_cov,
)
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.collecting.record import (
    TRANSFORMS_FILE,
    WAY_FILE,
    Taken,
    read_log,
    read_record,
    read_robot_tum,
)
from facetlog.robot.collecting.run_sessions import list_runs
from facetlog.robot.pose2 import Pose2

if TYPE_CHECKING:
    from facetlog.perception.reading.read_views import ViewSet
    from facetlog.perception.types import PoseErrors

START_STATED = "start_stated"
"""Of a run's first line in collect.jsonl: whether the user said where the robot stood."""


NOT_LOGGED = Driven()

# An optical axis that passes a place by this share of its distance has it in the middle 30 degrees
# of the picture, and so has another view two places that are as near to one another.
MIDDLE_SHARE = 0.25
# Of views that look at no place together, as when a robot looks about, there is one group.
MOST_ALONE = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class Visit:
    """One collection: its folder, its views as they were taken, and the way between them.

    `stated` says whether the user said where the robot stood in the world.
    """

    folder: Path
    taken: tuple[Taken, ...]
    way: tuple[Pose2, ...]
    stated: bool
    driven: Driven = NOT_LOGGED

    @property
    def name(self) -> str:
        """Name in the map."""
        return self.folder.resolve().name or str(self.folder)


def read_visit(folder: Path) -> Visit:
    """Return the visit of a folder that `facetlog collect` left; InputError for another one."""
    _, taken = read_record(folder)
    lines = read_log(folder)
    runs = [line for line in lines if "schema" in line]
    path = folder / WAY_FILE
    way = tuple(place for _, place in read_robot_tum(path)) if path.is_file() else ()
    return Visit(
        folder,
        taken,
        way or tuple(view.robot for view in taken),
        _is_stated(runs[0]) if runs else False,
        driven(folder, list_runs(lines, folder)),
    )


def _is_stated(run: Mapping[str, object]) -> bool:
    stated = run.get(START_STATED)
    if isinstance(stated, bool):
        return stated
    # Collections from before that was recorded: the default is the world's origin.
    return run.get("start") not in ([0.0, 0.0, 0.0], [0, 0, 0])


def check_aligned(visits: Sequence[Visit]) -> None:
    """Raise InputError where the worlds of several visits are not known to be one.

    The first one's world is that of the map. Another is the same if the user said where its robot
    stood in it; else its origin is wherever the robot stood then.
    """
    unknown = [visit for visit in visits if not visit.stated]
    if len(visits) < 2 or len(unknown) < 2:
        return
    first, other = unknown[:2]
    raise InputError(
        f"{first.folder} and {other.folder} both have their origin where the robot stood at first, "
        "so how their worlds lie to each other is not known: map each alone, collect with --start, "
        "or give --aligned if the robot began at the same place and heading"
    )


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """Views that look at one place, with their poses corrected by the pictures, which are as sure
    as beside the first of them; `errors` are those in the world. `times` are when each was taken,
    by its name, seconds since 1970.
    """

    views: "ViewSet"
    errors: "PoseErrors | None"
    times: Mapping[str, float] = field(default_factory=dict)


def read_grouped_views(visit: Visit) -> tuple[Look, ...]:
    """Return the views that look at one place each, in the order in which they were taken.
    InputError if they cannot be read.
    """
    from facetlog.perception.reading.read_views import read_views

    found = read_views(visit.folder / TRANSFORMS_FILE)
    groups = view_groups([view.pose for view in found.views])
    looks = []
    times = {view.name: view.time for view in visit.taken}
    for number, own in enumerate(groups, start=1):
        if len(own) < FEWEST_VIEWS:
            continue
        name = found.name if len(groups) == 1 else f"{found.name}-{number}"
        look = _choose_views(found, own, name)
        looks.append(replace(look, times=times))
    return tuple(looks)


def _choose_views(found: "ViewSet", chosen: Sequence[int], name: str) -> Look:
    """Return some of the views (indices) under a name, their poses corrected by the pictures."""
    from facetlog.perception.estimation.pose_refinement.refine_poses import correct_poses

    views = tuple(found.views[k] for k in chosen)
    if found.pose_errors is None:
        return Look(replace(found, name=name, views=views), None)
    errors = found.pose_errors.of(chosen)
    covs = compute_relative_covariances(errors.poses, errors.covariances)
    beside = tuple(
        view if view.pose_cov is None else replace(view, pose_cov=cov)
        for view, cov in zip(views, covs, strict=True)
    )
    part = replace(found, name=name, views=beside, pose_errors=replace(errors, covariances=covs))
    return Look(correct_poses(part), errors)


def compute_relative_covariances(poses: Sequence[Pose], covariances: FloatArray) -> FloatArray:
    """Return the covariances (V, 6, 6) of place (world units) and rotation vector (radians) of
    poses that a robot took in this order, as if its odometry had begun with the first one.
    """
    if not len(poses):
        return np.zeros((0, 6, 6))
    centres = np.array([pose.centre for pose in poses])
    about = centres.mean(axis=0)
    # As far as from one another the views are from what they look at.
    distance = float(np.linalg.norm(centres - about, axis=1).max())
    own = np.diag([(OWN_SD * distance) ** 2] * 3 + [OWN_SD**2] * 3)
    twists = [
        convert_to_twist_cov(pose, cov, about) for pose, cov in zip(poses, covariances, strict=True)
    ]
    since = np.zeros((6, 6))
    found = []
    for before, twist, pose in zip([twists[0], *twists], twists, poses, strict=False):
        step = added(before, twist)
        # Odometry that restarted is off independently of what it was before.
        since = since + (before + twist if step is None else step)
        back = _compute_place_from_twist(pose, about)
        found.append(back @ since @ back.T + own)
    return np.array(found)


def _compute_place_from_twist(pose: Pose, about: FloatArray) -> FloatArray:
    """Return the derivative (6, 6) of a pose's place and rotation vector by a twist's rotation
    vector and shift: the place moves by turn x (centre - about) + shift.
    """
    x, y, z = pose.centre - about
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    matrix[:3, 3:] = matrix[3:, :3] = np.eye(3)
    return matrix


@dataclass(eq=False, slots=True)
class _Place:
    """Views (indices) and the place (3,) that their axes pass, None of a single view."""

    views: list[int] = field(default_factory=list)
    point: FloatArray | None = None


def view_groups(poses: Sequence[Pose]) -> tuple[tuple[int, ...], ...]:
    """Return the views (indices, ascending) of each group, in the order in which they begin.

    Views that fit nowhere go with those before them; a group has as many as a face needs.
    """
    places: list[_Place] = []
    for index in range(len(poses)):
        if places and (point := _going_on(places[-1], index, poses)) is not None:
            places[-1].views.append(index)
            places[-1].point = point
        else:
            places.append(_Place([index]))
    groups = _together(places, poses)
    large = [group for group in groups if len(group) >= FEWEST_VIEWS]
    alone = len(poses) - sum(map(len, large))
    if not large or alone > MOST_ALONE * len(poses):
        return (tuple(range(len(poses))),) if len(poses) else ()
    for group in groups:
        if len(group) < FEWEST_VIEWS:
            for index in group:
                nearest = min(large, key=lambda own: min(abs(index - k) for k in own))
                nearest.append(index)
    return tuple(tuple(sorted(group)) for group in sorted(large))


def _going_on(place: _Place, index: int, poses: Sequence[Pose]) -> FloatArray | None:
    """Return the place with one more view, if it is in the middle part of the pictures of all of
    them.
    """
    views = [*place.views, index]
    point = _crossing([poses[k] for k in views])
    if point is None:
        return None
    return point if all(_is_middle(poses[k], point) for k in views) else None


def _crossing(poses: Sequence[Pose]) -> FloatArray | None:
    """Return the point (3,) nearest to the optical axes, by least squares; None if they are
    parallel.

    Σ (I - d dᵀ) (p - c) = 0
    """
    axes = np.array([pose.rotation[:, 2] for pose in poses])
    centres = np.array([pose.centre for pose in poses])
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    matrix = across.sum(axis=0)
    if np.linalg.cond(matrix) > 1.0 / MIDDLE_SHARE**4:
        return None
    found: FloatArray = np.linalg.solve(matrix, np.einsum("nij,nj->i", across, centres))
    return found


def _is_middle(pose: Pose, point: FloatArray) -> bool:
    """Return whether a point is ahead, in the middle part of the picture."""
    x, y, z = pose.rotation.T @ (point - pose.centre)
    return bool(z > 0 and np.hypot(x, y) <= MIDDLE_SHARE * z)


def _together(places: Sequence[_Place], poses: Sequence[Pose]) -> list[list[int]]:
    """Return the views of places, of which those that are near one another are one."""
    groups: list[tuple[list[int], FloatArray | None]] = []
    for place in places:
        for views, point in groups:
            if point is None or place.point is None:
                continue
            both = [*views, *place.views]
            away = min(float(np.linalg.norm(poses[k].centre - point)) for k in both)
            if float(np.linalg.norm(point - place.point)) <= MIDDLE_SHARE * away:
                views.extend(place.views)
                break
        else:
            groups.append((list(place.views), place.point))
    return [views for views, _ in groups]
