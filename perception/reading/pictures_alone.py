"""Pictures without any poses: by the mat that they show, or else by what they have in common."""

import logging
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.reading.mat.mat_poses import NoMatError, read_mat
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions, PoseReader
from facetlog.perception.reading.pose_files.poses_file import PosesFile
from facetlog.perception.reading.sfm.sfm_poses import (
    NothingPlacedError,
    are_kept,
    can_map,
    read_by_motion,
)
from facetlog.perception.reading.shots import has_shots

__all__ = ["PICTURES", "read_pictures"]

_LOG = logging.getLogger(__name__)


def read_pictures(folder: Path, options: PoseOptions) -> PosesFile:
    """Return cameras and poses of the pictures in a folder: by a mat in metres, else without unit
    and up.

    InputError where neither way leads to them, or an option goes with neither.
    """
    if options.unit is not None:
        raise InputError(
            "unit is for poses of an unknown unit, and these pictures have none: a mat gives "
            "metres (if its bar was off, give the side of a square, as 17.6mm), and without "
            'one a known length as scale does: "height = 74 cm"'
        )
    if options.square is None and are_kept(folder, options):
        return read_by_motion(folder, options)  # no mat was seen when these were made
    try:
        return read_mat(folder, options.square)
    except NoMatError as exc:
        if options.square is not None:
            raise
        if not can_map():
            raise InputError(
                f"{exc}, or let facetlog find poses by texture: pip install 'facetlog[sfm]'"
            ) from None
        no_mat = exc.what
    _LOG.info("%s: %s: poses by structure from motion", folder, no_mat)
    try:
        return read_by_motion(folder, options)
    except NothingPlacedError as exc:
        raise InputError(f"{folder}: {no_mat}, and {exc}") from None


def _find(folder: Path) -> Path | None:
    return folder if has_shots(folder) else None


PICTURES = PoseReader(
    kind="pictures alone",
    needs="pictures of a thing on a printed mat (facetlog mat -o mat.pdf)",
    find=_find,
    takes=Path.is_dir,
    read=read_pictures,
    alone=True,
)
