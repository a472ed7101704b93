"""Cameras and poses of pictures that show a mat: from nothing but the pictures."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.length_units import Length
from facetlog.perception.reading.exif import TakenWith, taken_with
from facetlog.perception.reading.left_out import LeftOut
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.mat.advice import advice
from facetlog.perception.reading.mat.fit import Corners, FittedCamera, FittedPose, fitted
from facetlog.perception.reading.mat.mats import BAR_MM, Mat
from facetlog.perception.reading.mat.sightings import Sighting, sighting
from facetlog.perception.reading.picture_of_view import KEPT_DIAGONAL_PX
from facetlog.perception.reading.pose_files.poses_file import Intrinsics, PosedPicture, PosesFile
from facetlog.perception.reading.shots import Shot, shots_in
from facetlog.perception.reading.video_file import VideoFrames
from facetlog.perception.types import PoseErrorKind

__all__ = ["MatPicture", "NoMatError", "PlacedPicture", "mat_pictures", "read_mat"]

MOST_BLUR_PX = 2.0
"""Standard deviation, in pictures at the size at which edges are found in them: lines nearer than
some twice that to each other, as those of a thin leg, are no longer two."""
MISFIT = 4.0
"""Of a picture whose residuals are so many times the median of all pictures the corners do not
fit: the camera moved, or the mat."""
RULER_SD_MM = 0.5 / 3**0.5
"""Of a length read off a ruler to the nearest millimetre: half of one to either side, all alike."""
HIDDEN = "shows too little of the mat: all is hidden, too far, too blurred, or outside"


class NoMatError(InputError):
    """No picture shows a mat: `what` says just that, the message the way out, too."""

    def __init__(self, folder: Path, what: str) -> None:
        super().__init__(
            f"{folder}: {what}: print one (facetlog mat -o mat.pdf) and stand the thing on it, or "
            "add a file of poses (docs/pictures.md)"
        )
        self.what = what


@dataclass(frozen=True, eq=False, slots=True)
class MatPicture:
    """A picture that shows the mat: its size, what took it, and what is seen of the mat."""

    shot: Shot
    size: tuple[int, int]
    taken_with: TakenWith
    seen: Sighting

    @property
    def blur_kept_px(self) -> float:
        """The blur at the size at which edges are found."""
        return self.seen.blur_px * min(KEPT_DIAGONAL_PX / float(np.hypot(*self.size)), 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class PlacedPicture:
    """A picture with its camera and pose, as fitted to all pictures together."""

    picture: MatPicture
    camera: FittedCamera
    placed: FittedPose

    @property
    def misfit(self) -> float:
        """The noise of its corners as a share of its diagonal: pictures of all sizes compare."""
        return self.placed.noise_px / float(np.hypot(*self.picture.size))


def mat_pictures(
    folder: Path, square: float | None = None
) -> tuple[Mat, tuple[PlacedPicture, ...], tuple[LeftOut, ...]]:
    """The mat, the pictures that show it with cameras and poses, and those that are left out.

    `square` is the side of a square as printed, in metres, where it is not as it should be.
    NoMatError where no picture shows a mat, InputError where they show two.
    """
    shots = shots_in(folder)
    if not shots:
        raise InputError(f"{folder} holds no pictures: add 12 to 30 of a thing on a printed mat")
    seen, left_out = _seen(shots)
    if not seen:
        why = f" ({left_out[0].line})" if left_out and len(left_out) == len(shots) == 1 else ""
        raise NoMatError(folder, f"no mat is seen in {_of(len(shots))}{why}")
    mats = {picture.seen.mat: picture.shot.name for picture in seen}
    if len(mats) > 1:
        named = " and ".join(f"{mat.paper} in {name}" for mat, name in mats.items())
        raise InputError(f"{folder} shows two mats, {named}: give each its own folder")
    (mat,) = mats
    side = mat.square_mm / 1000 if square is None else square
    found = _fitted(seen, side)
    usual = float(np.median([each.misfit for each in found]))
    fitting = [each.picture for each in found if each.misfit <= MISFIT * usual]
    if len(fitting) < len(found):
        why = "does not fit the others: the camera or the mat moved"
        left_out += [_left_out(p.shot, why) for p in seen if p not in fitting]
        found = _fitted(fitting, side)
    return mat, found, tuple(left_out)


def read_mat(folder: Path, square: Length | None = None) -> PosesFile:
    """Cameras and poses of the pictures in a folder by the mat that they show; metres, up is +z.

    `square` is the side of a square as printed, where it is not as it should be. Without a standard
    deviation the print's scale is known as well as its bar, or as much of the board, tells by a
    ruler. NoMatError where no picture shows a mat, InputError where they show two.
    """
    mat, found, left_out = mat_pictures(folder, None if square is None else square.metres)
    scale_sd = RULER_SD_MM / BAR_MM
    if square is not None and square.sd is not None:
        scale_sd = square.sd / square.metres
    wanted = advice(found)
    off = float(np.median([each.placed.noise_px for each in found]))
    return PosesFile(
        folder,
        tuple(map(_posed, found)),
        np.array([0.0, 0.0, 1.0]),
        metric=True,
        error_kind=PoseErrorKind.INDEPENDENT,
        left_out=left_out,
        kind=f"{mat.name} (its corners fit to {off:.2g} px)",
        scale_sd=scale_sd,
        notes=() if not wanted else (f"{wanted[0]} (facetlog mat check {folder} says more)",),
    )


def _seen(shots: Sequence[Shot]) -> tuple[list[MatPicture], list[LeftOut]]:
    seen: list[MatPicture] = []
    left_out: list[LeftOut] = []
    videos = VideoFrames()
    for shot in shots:
        try:
            image = shot.read(videos)
            found = sighting(image)
        except InputError as exc:
            left_out.append(shot.unreadable(exc))
            continue
        if found is None:
            left_out.append(_left_out(shot, HIDDEN))
            continue
        size = image.shape[1], image.shape[0]
        lens = taken_with(shot.path) if shot.frame is None else TakenWith(str(shot.path))
        picture = MatPicture(shot, size, lens, found)
        if picture.blur_kept_px > MOST_BLUR_PX:
            left_out.append(_left_out(shot, "is blurred: hold the camera still, and focus"))
        else:
            seen.append(picture)
    videos.close()
    return seen, left_out


def _left_out(shot: Shot, why: str) -> LeftOut:
    return LeftOut(shot.name, f"picture {shot.place} {why}", shot.place)


def _of(count: int) -> str:
    return "the only picture" if count == 1 else f"any of {count} pictures"


def _fitted(pictures: Sequence[MatPicture], square: float) -> tuple[PlacedPicture, ...]:
    """The pictures with cameras and poses: one camera for each size and zoom."""
    kinds = list(dict.fromkeys((p.size, p.taken_with) for p in pictures))
    corners = [
        Corners(
            p.seen.mat.corners(p.seen.numbers, square),
            p.seen.pixels,
            kinds.index((p.size, p.taken_with)),
            p.size[1],
        )
        for p in pictures
    ]
    sizes = [size for size, _ in kinds]
    fit = fitted(corners, sizes, [with_.focal_px(*size) for size, with_ in kinds])
    return tuple(
        PlacedPicture(p, fit.cameras[c.camera], placed)
        for p, c, placed in zip(pictures, corners, fit.poses, strict=True)
    )


def _posed(found: PlacedPicture) -> PosedPicture:
    picture, camera, placed = found.picture, found.camera, found.placed
    k1, k2, p1, p2, k3 = camera.lens.tolist()
    intrinsics = Intrinsics(
        where=picture.shot.place,
        size=picture.size,
        focal=(camera.focal, camera.focal),
        field_of_view=(None, None),
        centre=(float(camera.centre[0]), float(camera.centre[1])),
        distortion=Distortion.POLYNOMIAL,
        radial=(k1, k2, k3, 0.0),
        tangential=(p1, p2),
    )
    shot = picture.shot
    return PosedPicture(shot.name, shot.path, intrinsics, placed.pose, placed.cov, shot.frame)
