"""The kinds of poses files, which of them a folder holds, and pictures without any poses.

A new kind is a module here with a PoseReader, and a name in the first row of READERS.
"""

import logging
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.reading.image_sources import has_shots
from facetlog.perception.reading.picture_file import PICTURE_SUFFIXES
from facetlog.perception.reading.pose_files.capture_files import (
    BLENDER,
    POLYCAM,
    RECORD3D,
    RECORD3D_ZIP,
    TRANSFORMS,
    TRANSFORMS_FILE,
)
from facetlog.perception.reading.pose_files.colmap_poses import COLMAP, has_pictures
from facetlog.perception.reading.pose_files.file_values import read_json
from facetlog.perception.reading.pose_files.pan_tilt_file import PAN_TILT
from facetlog.perception.reading.pose_files.picture_places import find_pictures
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions, PoseReader
from facetlog.perception.reading.pose_files.poses_file import PosesFile
from facetlog.perception.reading.pose_files.sfm_files import BUNDLER, OPENMVG, VISUALSFM
from facetlog.perception.reading.pose_files.trajectory_files import KITTI, TUM
from facetlog.perception.reading.sfm.sfm_poses import (
    NothingPlacedError,
    can_map,
    has_kept_cameras,
    read_by_motion,
)
from facetlog.perception.reading.video_file import COUNTED

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
    # Loaded only now: its fit takes parts of scipy that poses from a file do without.
    from facetlog.perception.reading.mat.mat_poses import NoMatError, read_mat

    if options.square is None and has_kept_cameras(folder, options):
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


PICTURES = PoseReader(
    kind="pictures alone",
    needs="pictures of a thing on a printed mat (facetlog mat -o mat.pdf)",
    find=lambda folder: folder if has_shots(folder) else None,
    takes=Path.is_dir,
    read=read_pictures,
    alone=True,
)
# A file is read by the first that takes it: the last three take any .json, .csv and folder.
READERS: tuple[PoseReader, ...] = (
    *(BLENDER, OPENMVG, POLYCAM, RECORD3D, RECORD3D_ZIP, COLMAP, BUNDLER, VISUALSFM, TUM, KITTI),
    *(TRANSFORMS, PAN_TILT, PICTURES),
)
VIDEO_KINDS = (*COUNTED, ".mkv", ".webm", ".ts", ".mjpg")
# Names that a message lists of what a folder holds.
LISTED = 8


def find_poses_path(path: Path) -> Path:
    """Return the poses file that a path given by the user means."""
    try:
        if path.is_dir():
            return find_poses(path)
        if path.is_file():
            return path
    except (OSError, ValueError) as exc:
        raise InputError(f"{str(path)!r} cannot be read: {exc}") from exc
    kind = "is neither a folder nor a file" if path.exists() else "does not exist"
    raise InputError(
        f"{path} {kind}: give a folder of pictures, or of pictures with their poses "
        "(docs/pictures.md lists the forms)"
    )


def find_poses(folder: Path) -> Path:
    """Return the poses file in a folder; InputError where there is none, it is not all there, or
    there are several kinds.
    """
    found = _found(folder)
    if all(reader.alone for reader, _ in found):  # poses are never dropped without a word
        for reader in READERS:
            if lack := reader.lacks(folder):
                raise InputError(
                    f"{folder} has part of a {reader.kind}: {lack}; to go without, put the "
                    "pictures into a folder of their own"
                )
    if not found:
        raise InputError(f"{folder} has no poses, {_holds(folder)}: add {_needs()}")
    if len(found) > 1:
        names = " and ".join(f"{path.relative_to(folder)} ({r.kind})" for r, path in found)
        raise InputError(f"{folder} has both {names}: name the one to use")
    return found[0][1]


def has_poses(path: Path) -> bool:
    """Return whether a path given by the user means poses of pictures, and not a shape.

    A COLMAP model without pictures is a cloud, JSON without frames is a scene.
    """
    if path.is_dir():
        return any(reader is not COLMAP or has_pictures(found) for reader, found in _found(path))
    reader = _find_reader(path)
    if reader is not TRANSFORMS:
        return reader is not None
    try:
        document = read_json(path)
    except InputError:  # who reads it as a scene says what is wrong
        return False
    return isinstance(document, dict) and "frames" in document


def has_only_pictures(path: Path) -> bool:
    """Return whether a path is a folder without poses: of pictures, or nothing that is read."""
    return path.is_dir() and all(reader.alone for reader, _ in _found(path))


def read_poses(path: Path, options: PoseOptions) -> PosesFile:
    """Read a poses file of the kind that its name shows."""
    reader = _find_reader(path)
    if reader is not None:
        return find_pictures(reader.read(path, options))
    if path.suffix.lower() in PICTURE_SUFFIXES:
        raise InputError(f"{path} is one picture: give the folder of all that show the thing")
    video = (
        f'; of a video a {TRANSFORMS_FILE} with "video": "{path.name}" and a pose for each frame'
        if path.suffix.lower() in VIDEO_KINDS
        else ""
    )
    raise InputError(f"{path} is no poses file: give its folder, or {_needs()}{video}")


def kind_of(path: Path, given: Path) -> str:
    """Return the kind of a poses file, for people, and which of several in the given folder it is;
    empty for what is none.
    """
    reader = _find_reader(path)
    if reader is None:
        return ""
    choice = reader.choice(given) if given.is_dir() else ""
    return f"{reader.kind} {choice}" if choice else reader.kind


def _find_reader(path: Path) -> PoseReader | None:
    return next((reader for reader in READERS if reader.takes(path)), None)


def _found(folder: Path) -> list[tuple[PoseReader, Path]]:
    found = [(r, path) for r in READERS if (path := r.find(folder)) is not None]
    if len(found) > 1:
        found = [(reader, path) for reader, path in found if not reader.alone]
    covered = {kind for reader, _ in found for kind in reader.made_from}
    return [(reader, path) for reader, path in found if reader.kind not in covered]


def _holds(folder: Path) -> str:
    paths = sorted(folder.iterdir())
    for path in paths:
        if not (path.is_file() or path.is_dir()):
            return f"and {path.name} is no file that can be read"
    names = [path.name for path in paths]
    if not names:
        return "it is empty"
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return f"only {', '.join(names[:LISTED])}{more}"


def _needs() -> str:
    others = (reader for reader in READERS if reader is not PICTURES)
    return ", or ".join(reader.needs for reader in (PICTURES, *others))
