"""Reads a folder of pictures with known cameras and poses as views."""

import logging
import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.length_units import Length
from facetlog.perception.name_lists import named
from facetlog.perception.reading.path_guard import check_own_folder
from facetlog.perception.reading.pose_files.pose_checks import LEAST_SPREAD
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.poses_file import (
    Intrinsics,
    PosedPicture,
    PosesFile,
)
from facetlog.perception.reading.pose_files.register import find_poses_path, kind_of, read_poses
from facetlog.perception.reading.skipped_images import LeftOut, lines_of
from facetlog.perception.reading.view_image import ViewLoader
from facetlog.perception.types import FloatArray, PoseErrorKind, PoseErrors, View

_LOG = logging.getLogger(__name__)

LEAST_VIEWS = 2
# Two camera centres are one place where they differ by less than this share of their largest
# coordinate: the rounding of poses that are written with some ten digits. Relative, so that the
# unit of length does not matter; this small, so that map coordinates (10⁶ m) still pass.
SAME_PLACE = 1e-9


@dataclass(frozen=True, eq=False, slots=True)
class ViewSet:
    """The views of one set, its name, and what is known of its world frame.

    `problems` has one line for each kind of fault for which pictures were left out (`left_out` is
    their number), and what the poses lack. `up` is a unit vector or None, `metric` says that
    lengths are metres. `source` is the poses file, None for views without one. `pose_errors` are
    stated where the file has the covariance of each pose; they keep the file's poses even if those
    of the views are corrected. `kind` is that of the poses file, for people; empty without one.
    Without `find_up` an up that is not known is not looked for either.
    """

    name: str
    views: tuple[View, ...]
    problems: tuple[str, ...] = ()
    up: FloatArray | None = None
    metric: bool = False
    source: Path | None = None
    pose_errors: PoseErrors | None = None
    left_out: int = 0
    kind: str = ""
    find_up: bool = True

    @property
    def description(self) -> str:
        """Kind, number of pictures and what is unknown of the world; empty without a poses file."""
        if not self.kind:
            return ""
        count = len(self.views) + self.left_out
        parts = [self.kind, f"{count} pictures"]
        parts += ["up unknown"] * (self.up is None) + ["unit unknown"] * (not self.metric)
        return ", ".join(parts)


def read_views(
    path: str | Path,
    *,
    unit: str | None = None,
    square: Length | None = None,
    axis: bool = False,
    keep: Path | None = None,
    trusted: bool = False,
    progress: Callable[[str, int, int], None] | None = None,
) -> ViewSet:
    """Read the views in a folder with a poses file (pose_files/register.py), or in such a file
    itself.

    Pictures are grey, as stored (not turned by EXIF), and undistorted, so that every View.camera is
    a pure pinhole. Large ones are kept reduced (view_image.py). A picture that
    is missing, damaged or not of its camera's size is left out and reported in `problems`, as long
    as two are left.

    Parameters
    ----------
    unit
        "m", "cm", "mm", "in" or "ft": the unit of a file that does not give its own.
    square
        The side of a square of the mat that the pictures show, if it was printed at another scale.
    axis
        Whether an axis of the poses' world was stated to be up.
    keep
        A folder for poses that take minutes to find.
    trusted
        Whether the file may name pictures outside of its folder (path_guard.py).
    progress
        Called with ("pictures", done, all) after each picture, and likewise with other steps.

    Raises
    ------
    InputError
        The folder, file or pictures cannot be used; one line that names the file and the way out.
    OutsideError
        A picture is outside of the folder of a file that is not trusted; none was opened.
    CalibrationError
        A camera or pose is missing or invalid, or all views were taken from one place.
    """
    source = find_poses_path(Path(path))
    _LOG.debug("%s is read as %s", source, kind_of(source, Path(path)))
    file = read_poses(source, PoseOptions(unit, square, axis, keep, progress))
    if file.faults:
        raise file.faults[0]
    file = _without_repeats(file, source)
    if not trusted:
        for picture in file.pictures:
            check_own_folder(picture, file.folder, source)
    views: list[View] = []
    used: list[PosedPicture] = []
    left_out: list[LeftOut] = []
    loader = ViewLoader()
    for done, picture in enumerate(file.pictures, start=1):
        found = loader.load(picture)
        if isinstance(found, LeftOut):
            left_out.append(found)
        else:
            views.append(found)
            used.append(picture)
        if progress is not None:
            progress("pictures", done, len(file.pictures))
    odd = _find_odd_sizes(used, views, source)
    views = [view for k, view in enumerate(views) if k not in odd]
    left_out += odd.values()
    if len(views) < LEAST_VIEWS:
        line = _describe_too_few_views(source, len(views), (*file.left_out, *left_out))
        raise InputError(f"{line}: {file.advice}" if file.advice and not views else line)
    _check_places(views, source)
    name = file.folder.resolve().name or "views"  # "/" has no name
    errors = collect_stated_errors(views, file.error_kind, file.scale_sd)
    return ViewSet(
        name,
        tuple(views),
        (*lines_of((*file.left_out, *left_out)), *file.notes),
        file.up,
        file.metric,
        source,
        errors,
        left_out=len(left_out),
        kind=file.kind or kind_of(source, Path(path)),
    )


def collect_stated_errors(
    views: Sequence[View], kind: PoseErrorKind, scale_sd: float = 0.0
) -> PoseErrors | None:
    """Return the errors of the views' poses, where they are stated of each."""
    stated = [view.pose_cov for view in views if view.pose_cov is not None]
    if not views or len(stated) < len(views):
        return None
    return PoseErrors(tuple(v.pose for v in views), np.array(stated), kind, scale_sd)


def _without_repeats(file: PosesFile, source: Path) -> PosesFile:
    """Return the file with each picture once, and a note that names those with the same pose twice.

    InputError for a picture of two poses, and for a camera, which has one picture, now.
    """
    seen: dict[str, PosedPicture] = {}
    repeated: list[str] = []
    for picture in file.pictures:
        if picture.frame is not None and picture.frame.number is None:
            raise InputError(
                f"{source}: camera {picture.frame} has one picture, now: follow it as it takes "
                "one for each pose (recognize --follow)"
            )
        place = str(picture.frame or os.path.normpath(picture.path))
        first = seen.setdefault(place, picture)
        if first is picture:
            continue
        if not _same_pose(first, picture):
            raise InputError(f"{source}: picture {picture.name!r} has two poses: remove one")
        repeated.append(picture.name)
    if not repeated:
        return file
    note = f"{source} has {named(repeated)} twice, with the same pose: used once"
    return replace(file, pictures=tuple(seen.values()), notes=(*file.notes, note))


def _same_pose(one: PosedPicture, other: PosedPicture) -> bool:
    a, b = one.pose, other.pose
    near = SAME_PLACE * max(float(np.abs(a.centre).max()), 1.0)
    same = np.allclose(a.rotation, b.rotation, rtol=0.0, atol=SAME_PLACE)
    return bool(same and np.allclose(a.centre, b.centre, rtol=0.0, atol=near))


def _find_odd_sizes(
    pictures: Sequence[PosedPicture], views: Sequence[View], source: Path
) -> dict[int, LeftOut]:
    """Return which pictures are not of the size of most that their camera took.

    Only for cameras that are given in pixels without the size of their pictures.
    CalibrationError where most of one camera are of no one size.
    """
    of_camera: dict[Intrinsics, list[int]] = {}
    for k, picture in enumerate(pictures):
        if picture.intrinsics.suits_one_size:
            of_camera.setdefault(replace(picture.intrinsics, where=""), []).append(k)
    odd: dict[int, LeftOut] = {}
    for same in of_camera.values():
        sizes = [views[k].stored_size for k in same]
        (usual, count), *_ = Counter(sizes).most_common()
        if 2 * count <= len(same) > 1:
            raise CalibrationError(
                f"{source}: {len(same)} pictures of one camera are of {len(set(sizes))} sizes: "
                "give each size a camera of its own, with its width and height"
            )
        for k, (width, height) in zip(same, sizes, strict=True):
            if (width, height) != usual:
                where = pictures[k].intrinsics.where
                line = (
                    f"{where}: the picture is {width} x {height}, most of its camera are "
                    f"{usual[0]} x {usual[1]}: give it a camera of its own"
                )
                odd[k] = LeftOut(pictures[k].name, line, where)
    return odd


def _describe_too_few_views(source: Path, usable: int, left_out: Sequence[LeftOut]) -> str:
    count = f"{source}: {usable or 'no'} usable {'view' if usable == 1 else 'views'}"
    if not left_out:
        return f"{count}: give at least {LEAST_VIEWS}, from different places"
    more = f" (and {len(left_out) - 1} more)" if len(left_out) > 1 else ""
    return f"{count}, {LEAST_VIEWS} are needed: {left_out[0].line}{more}"


def _check_places(views: Sequence[View], source: Path) -> None:
    """Raise CalibrationError if all centres are one place: without a baseline no depth."""
    centres = np.array([view.pose.centre for view in views])
    spread = float(np.ptp(centres, axis=0).max())
    if 0 < spread < LEAST_SPREAD:
        raise CalibrationError(
            f"{source}: all {len(views)} cameras are within {spread:.2g} units of length "
            f"({LEAST_SPREAD:.0e} at least): give their places in metres, or any larger unit"
        )
    if spread <= SAME_PLACE * np.abs(centres).max():
        raise CalibrationError(
            f"{source}: all {len(views)} views are from one place, which shows no depth: "
            "take pictures from different places"
        )
