"""Cameras and poses by structure from motion: made once, and read as any COLMAP model is.

Neither the unit nor the axes of the world are known then: they are those of a picture that COLMAP
began with.
"""

import logging
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from facetlog.errors import InputError
from facetlog.perception.reading.pose_files.colmap_poses import read_colmap_poses
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.poses_file import PosesFile
from facetlog.perception.reading.sfm.kept_model import (
    check_keep,
    keep_model,
    kept_outcome,
    made_from,
)
from facetlog.perception.reading.sfm.mapping import can_map, map_pictures
from facetlog.perception.reading.sfm.outcome import LEAST_PICTURES, Outcome, left_out, why_nothing
from facetlog.perception.reading.sfm.request import Settings
from facetlog.perception.reading.shots import Shot, shots_in

__all__ = ["NothingPlacedError", "are_kept", "read_by_motion"]

SETTINGS = Settings()

_LOG = logging.getLogger(__name__)


class NothingPlacedError(InputError):
    """No pictures could be placed together; the message says why, and the way out."""


def are_kept(folder: Path, options: PoseOptions) -> bool:
    """Whether `options.keep` has the cameras of just these pictures."""
    if options.keep is None or not options.keep.is_dir() or not can_map():
        return False
    key = made_from(tuple(shot.upright for shot in shots_in(folder)), SETTINGS)
    return kept_outcome(options.keep, key) is not None


def read_by_motion(folder: Path, options: PoseOptions) -> PosesFile:
    """Cameras and poses of the pictures in a folder by what they have in common.

    Where `options.keep` has those of the same pictures they are taken from there.
    NothingPlacedError where no pictures can be placed together, InputError for what does not go
    with this way, EngineError if COLMAP dies.
    """
    if options.axis:
        raise InputError(
            "up: no axis of a world that structure from motion makes can be known: leave it out "
            "(up is that of the ground then), or give none"
        )
    # As EXIF turns them: which way the ground lies is known from how cameras were held.
    shots = tuple(shot.upright for shot in shots_in(folder))
    if len(shots) < LEAST_PICTURES:
        raise NothingPlacedError(why_nothing(Outcome({shot.name: 0 for shot in shots})))
    keep = options.keep
    if keep is None:
        return _mapped(folder, shots, options)
    check_keep(keep)
    key = made_from(shots, SETTINGS)
    outcome = kept_outcome(keep, key)
    if outcome is None:
        return _mapped(folder, shots, options, key)
    _LOG.info("%s has the cameras of these pictures: not made again", keep)
    return _read(keep, folder, shots, outcome)


def _mapped(
    folder: Path, shots: tuple[Shot, ...], options: PoseOptions, key: str = ""
) -> PosesFile:
    with TemporaryDirectory(prefix="facetlog-cameras-") as name:
        model = Path(name)
        outcome = map_pictures(shots, model, SETTINGS, options.progress)
        _LOG.debug("features of each picture: %s", dict(outcome.features))
        _LOG.info(
            "structure from motion: %d pairs of pictures have points in common, groups of %s "
            "pictures were placed",
            len(outcome.pairs),
            [len(group) for group in outcome.groups],
        )
        if not outcome.groups:
            raise NothingPlacedError(why_nothing(outcome))
        if options.keep is not None:
            keep_model(options.keep, model, key, outcome)
            _LOG.info("cameras are kept in %s", options.keep)
        return _read(model, folder, shots, outcome)


def _read(model: Path, folder: Path, shots: tuple[Shot, ...], outcome: Outcome) -> PosesFile:
    file = read_colmap_poses(model / "images.bin", None)
    picture_of = {picture.name: picture for picture in file.pictures}
    placed = tuple(
        replace(picture_of[shot.name], path=shot.path, frame=shot.frame, turns=shot.turns)
        for shot in shots
        if shot.name in picture_of
    )
    return replace(
        file,
        folder=folder,
        pictures=placed,
        left_out=left_out(outcome, {shot.name: shot.place for shot in shots}),
        kind=f"structure from motion (its points fit to {outcome.error_px:.2g} px)",
    )
