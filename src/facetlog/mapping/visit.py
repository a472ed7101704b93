"""A collection's folder as the map takes it: its runs, its way, and its views in groups."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import InputError
from facetlog.mapping.sonar_beams import Driven, driven
from facetlog.mapping.view_groups import view_groups
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.robot.collecting.record import (
    TRANSFORMS_FILE,
    WAY_FILE,
    Taken,
    read_log,
    read_record,
    read_robot_tum,
)
from facetlog.robot.collecting.run_sessions import runs_of
from facetlog.robot.pose2 import Pose2

if TYPE_CHECKING:
    from facetlog.perception.reading.read_views import ViewSet
    from facetlog.perception.types import PoseErrors

__all__ = [
    "START_STATED",
    "Look",
    "Visit",
    "check_aligned",
    "grouped_views",
    "read_visit",
]

START_STATED = "start_stated"
"""Of a run's first line in collect.jsonl: whether the user said where the robot stood."""


NOT_LOGGED = Driven()


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
        """What the map calls it."""
        return self.folder.resolve().name or str(self.folder)


def read_visit(folder: Path) -> Visit:
    """The visit of a folder that `facetlog collect` left; InputError for another one."""
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
        driven(folder, runs_of(lines, folder)),
    )


def _is_stated(run: Mapping[str, object]) -> bool:
    stated = run.get(START_STATED)
    if isinstance(stated, bool):
        return stated
    # Collections from before that was recorded: the default is the world's origin.
    return run.get("start") not in ([0.0, 0.0, 0.0], [0, 0, 0])


def check_aligned(visits: Sequence[Visit]) -> None:
    """InputError where the worlds of several visits are not known to be one.

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


def grouped_views(visit: Visit) -> tuple[Look, ...]:
    """The views that look at one place each (view_groups.py), in the order in which they were
    taken. InputError if they cannot be read.
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
    from facetlog.mapping.anchored import covariances_beside_first
    from facetlog.perception.estimation.pose_refinement.refine_poses import with_refined_poses

    views = tuple(found.views[k] for k in chosen)
    if found.pose_errors is None:
        return Look(replace(found, name=name, views=views), None)
    errors = found.pose_errors.of(chosen)
    covs = covariances_beside_first(errors.poses, errors.covariances)
    beside = tuple(
        view if view.pose_cov is None else replace(view, pose_cov=cov)
        for view, cov in zip(views, covs, strict=True)
    )
    part = replace(found, name=name, views=beside, pose_errors=replace(errors, covariances=covs))
    return Look(with_refined_poses(part), errors)
