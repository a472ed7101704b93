"""Cameras and poses of pictures that show a mat: from nothing but the pictures."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facetlog.errors import InputError
from facetlog.perception.length_units import Length
from facetlog.perception.name_lists import named
from facetlog.perception.reading.exif import TakenWith, taken_with
from facetlog.perception.reading.image_sources import Shot, list_shots
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.mat.advice import advice
from facetlog.perception.reading.mat.fit import (
    CENTRE_SD,
    OF_CAMERA,
    SURE_SDS,
    Corners,
    FittedCamera,
    FittedPose,
    MatFit,
    fitted,
)
from facetlog.perception.reading.mat.mats import (
    BAR_MM,
    Mat,
    MirroredError,
    OtherBoardError,
    Sighting,
    sighting,
)
from facetlog.perception.reading.pose_files.poses_file import Intrinsics, PosedPicture, PosesFile
from facetlog.perception.reading.skipped_images import LeftOut
from facetlog.perception.reading.video_file import VideoFrames
from facetlog.perception.reading.view_image import KEPT_DIAGONAL_PX
from facetlog.perception.types import FloatArray, PoseErrorKind

MOST_BLUR_PX = 2.0
"""Standard deviation, in pictures at the size at which edges are found in them: lines nearer than
some twice that to each other, as those of a thin leg, are no longer two."""
MISFIT = 4.0
"""A picture whose residuals are so many times the median of all pictures does not fit: the camera
moved, or the mat."""
FLAT_SQUARES, MOST_SQUARES = 0.02, 0.1
"""Residuals of corners in squares. A flat sheet fits to some thousandths, one that is wavy by a
third of a millimetre to 0.02; what is off by more than 0.1 is no mat seen through one lens."""
LEAST_RESIDUAL_PX = 0.5
"""Error with which a corner may be found, however small its square is."""
RULER_SD_MM = 0.5 / 3**0.5
"""Standard deviation of a length read off a ruler to the nearest millimetre: uniform."""
AMBIGUOUS = -1
FOCUS_SD = 0.02
"""Standard deviation of the log of a focal length between pictures of one zoom: a lens of 5 mm that
focuses at 15 cm is 3 % farther out than at infinity."""
LEAST_RATIO_SDS = 5.0
"""Two zooms differ by more than focusing does, in these standard deviations: by a tenth."""
LEAST_CHI2 = 25.0
"""Least gain of chi² by two focal lengths: five standard deviations, as a set is split in as many
ways as it has pictures."""
AMBIGUOUS_SDS = 3.0
UNSURE_ZOOM = (
    "is from too steep above to tell at which of the focal lengths it was taken: take all at one "
    "zoom, and do not crop them"
)
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
        """Blur at the size at which edges are found."""
        return self.seen.blur_px * min(KEPT_DIAGONAL_PX / float(np.hypot(*self.size)), 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class PlacedPicture:
    """A picture with its camera and pose, as fitted to all pictures together."""

    picture: MatPicture
    camera: FittedCamera
    placed: FittedPose

    @property
    def misfit(self) -> float:
        """Noise of its corners as a share of its diagonal: pictures of all sizes compare."""
        return self.placed.noise_px / float(np.hypot(*self.picture.size))


@dataclass(frozen=True, eq=False, slots=True)
class MatSet:
    """The pictures of a folder that show a mat, with cameras and poses, and those left out.

    `faults` say, for people, what is wrong with the print or the pictures and was allowed for.
    """

    mat: Mat
    pictures: tuple[PlacedPicture, ...]
    left_out: tuple[LeftOut, ...]
    faults: tuple[str, ...]

    @property
    def residual_px(self) -> float:
        """Median of the noise of corners."""
        return float(np.median([each.placed.noise_px for each in self.pictures]))


def find_mat_pictures(folder: Path, square: float | None = None) -> MatSet:
    """Find the pictures that show the mat, with cameras and poses, and those that are left out.

    `square` is the side of a square as printed, in metres, where it is not as it should be.
    NoMatError where no picture shows a mat, InputError where they show two, or none as it is.
    """
    shots = list_shots(folder)
    if not shots:
        raise InputError(f"{folder} holds no pictures: add 12 to 30 of a thing on a printed mat")
    seen, left_out, why_not = _seen(shots)
    if not seen:
        for kind in (MirroredError, OtherBoardError):
            first = next((exc for exc in why_not if isinstance(exc, kind)), None)
            if first is not None:
                count = sum(isinstance(exc, kind) for exc in why_not)
                raise InputError(f"{folder}: each of {count} pictures {first}")
        why = f" ({left_out[0].line})" if left_out and len(left_out) == len(shots) == 1 else ""
        where = "the only picture" if len(shots) == 1 else f"any of {len(shots)} pictures"
        raise NoMatError(folder, f"no mat is seen in {where}{why}")
    mats = {picture.seen.mat: picture.shot.name for picture in seen}
    if len(mats) > 1:
        names = " and ".join(f"{mat.paper} in {name}" for mat, name in mats.items())
        raise InputError(f"{folder} shows two mats, {names}: give each its own folder")
    (mat,) = mats
    side = mat.square_mm / 1000 if square is None else square
    groups, fit = _group_by_camera(seen, side)
    unsure = [p for p in seen if groups[p] is None]
    left_out += [_left_out(p.shot, UNSURE_ZOOM) for p in unsure]
    found = _placed([p for p in seen if p not in unsure], groups, fit)
    usual = float(np.median([each.misfit for each in found]))
    fitting = [each.picture for each in found if each.misfit <= MISFIT * usual]
    if len(fitting) < len(found):
        why = "does not fit the others: the camera or the mat moved"
        left_out += [_left_out(e.picture.shot, why) for e in found if e.picture not in fitting]
        fit = _fitted(fitting, groups, side)
        found = _placed(fitting, groups, fit)
    return MatSet(mat, found, tuple(left_out), tuple(_faults(folder, mat, found, groups, fit)))


def read_mat(folder: Path, square: Length | None = None) -> PosesFile:
    """Return cameras and poses of the pictures in a folder by the mat that they show; metres, up is
    +z.

    `square` is the side of a square as printed, where it is not as it should be. Without a standard
    deviation the print's scale is known as well as its bar, or as much of the board, tells by a
    ruler. NoMatError where no picture shows a mat, InputError where they show two.
    """
    found = find_mat_pictures(folder, None if square is None else square.metres)
    scale_sd = RULER_SD_MM / BAR_MM
    if square is not None and square.sd is not None:
        scale_sd = square.sd / square.metres
    wanted = advice(found.pictures)
    more = (f"{wanted[0]} (facetlog mat check {folder} says more)",) if wanted else ()
    return PosesFile(
        folder,
        tuple(map(_posed, found.pictures)),
        np.array([0.0, 0.0, 1.0]),
        metric=True,
        error_kind=PoseErrorKind.INDEPENDENT,
        left_out=found.left_out,
        kind=f"{found.mat.name} (its corners fit to {found.residual_px:.2g} px)",
        scale_sd=scale_sd,
        notes=(*found.faults, *more),
    )


def _seen(shots: Sequence[Shot]) -> tuple[list[MatPicture], list[LeftOut], list[InputError]]:
    """Return the pictures that show a mat, those that do not, and the errors of unusable ones."""
    seen: list[MatPicture] = []
    left_out: list[LeftOut] = []
    faults: list[InputError] = []
    videos = VideoFrames()
    for shot in shots:
        try:
            image = shot.read(videos)
            found = sighting(image)
        except (MirroredError, OtherBoardError) as exc:
            left_out.append(_left_out(shot, str(exc)))
            faults.append(exc)
            continue
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
    return seen, left_out, faults


def _left_out(shot: Shot, why: str) -> LeftOut:
    return LeftOut(shot.name, f"picture {shot.place} {why}", shot.place)


_Groups = dict[MatPicture, "_Kind | None"]
"""Camera and zoom of each picture; None where that cannot be told."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """Pictures that share a camera: of one size, by one lens, at one zoom (numbered)."""

    size: tuple[int, int]
    taken_with: TakenWith
    zoom: int = 0


def _group_by_camera(seen: Sequence[MatPicture], square: float) -> tuple[_Groups, MatFit]:
    """Group the pictures by what took them, and fit them: a camera for each size and lens, or for
    each zoom where that is the more probable.
    """
    plain: _Groups = {p: _Kind(p.size, p.taken_with) for p in seen}
    fit = _fitted(seen, plain, square)
    zoomed = _group_by_zoom(seen, plain, square, 0.0)
    by_zoom = _choose_more_probable(seen, plain, fit, zoomed, square)
    if by_zoom is not None and by_zoom.stretch:
        # A stretched print makes focal lengths of single pictures differ, too.
        zoomed = _group_by_zoom(seen, plain, square, by_zoom.stretch)
        by_zoom = _choose_more_probable(seen, plain, fit, zoomed, square)
    return (plain, fit) if by_zoom is None else (zoomed, by_zoom)


def _group_by_zoom(
    seen: Sequence[MatPicture], plain: _Groups, square: float, stretch: float
) -> _Groups:
    """Group the pictures by what took them and at which zoom, seen on a mat of this stretch."""
    zoomed: _Groups = dict(plain)
    for kind in dict.fromkeys(plain.values()):
        own = [p for p in seen if plain[p] == kind]
        if kind is not None and len(own) > 1:
            corners = [_corners(p, 0, square) for p in own]
            longer = np.array([1.0, np.exp(stretch), 1.0])
            corners = [replace(each, points=each.points * longer) for each in corners]
            zooms = _find_zooms(corners, kind.size, kind.taken_with.compute_focal_px(*kind.size))
            for picture, zoom in zip(own, zooms.tolist(), strict=True):
                zoomed[picture] = None if zoom == AMBIGUOUS else replace(kind, zoom=zoom)
    return zoomed


def _choose_more_probable(
    seen: Sequence[MatPicture], plain: _Groups, fit: MatFit, zoomed: _Groups, square: float
) -> MatFit | None:
    """Return the fit by zoom, where that is the more probable; else None."""
    more = len(set(zoomed.values()) - {None}) - len(set(plain.values()))
    if more <= 0:
        return None
    sure = [p for p in seen if zoomed[p] is not None]
    by_zoom = _fitted(sure, zoomed, square)
    # Schwarz's criterion, over the same pictures.
    alike = fit if len(sure) == len(seen) else _fitted(sure, plain, square)
    count = 2 * sum(len(p.seen.numbers) for p in sure)
    penalty = more * OF_CAMERA * np.log(count) / 2
    return by_zoom if by_zoom.cost + penalty < alike.cost else None


def _corners(picture: MatPicture, camera: int, square: float) -> Corners:
    seen = picture.seen
    return Corners(seen.mat.corners(seen.numbers, square), seen.pixels, camera, picture.size[1])


def _kinds(pictures: Sequence[MatPicture], groups: _Groups) -> list[_Kind]:
    """Return the cameras of pictures, in the order in which a fit has them."""
    return list(dict.fromkeys(kind for p in pictures if (kind := groups[p]) is not None))


def _fitted(pictures: Sequence[MatPicture], groups: _Groups, square: float) -> MatFit:
    kinds = _kinds(pictures, groups)
    corners = [
        _corners(p, kinds.index(kind), square) for p in pictures if (kind := groups[p]) is not None
    ]
    focals = [kind.taken_with.compute_focal_px(*kind.size) for kind in kinds]
    return fitted(corners, [kind.size for kind in kinds], focals)


def _placed(
    pictures: Sequence[MatPicture], groups: _Groups, fit: MatFit
) -> tuple[PlacedPicture, ...]:
    cameras = dict(zip(_kinds(pictures, groups), fit.cameras, strict=True))
    return tuple(
        PlacedPicture(p, cameras[kind], placed)
        for p, placed in zip(pictures, fit.poses, strict=True)
        if (kind := groups[p]) is not None
    )


def _faults(
    folder: Path, mat: Mat, found: Sequence[PlacedPicture], groups: _Groups, fit: MatFit
) -> Iterator[str]:
    """Yield faults of the print and the pictures; InputError where no camera explains them."""
    off = np.array([e.placed.noise_px for e in found])
    squares = float(np.median(off / [e.picture.seen.square_px for e in found]))
    off_px = float(np.median(off))
    if squares > MOST_SQUARES and off_px > LEAST_RESIDUAL_PX:
        raise InputError(
            f"{folder}: the mat's corners fit no camera ({off_px:.2g} px off, "
            f"{squares * mat.square_mm:.2g} mm on the mat): use pictures as they were taken, "
            "neither cropped nor warped, of a flat mat"
        )
    if squares > FLAT_SQUARES and off_px > LEAST_RESIDUAL_PX:
        yield (
            f"the mat's corners fit to {off_px:.2g} px only, {squares * mat.square_mm:.2g} mm on "
            "the mat: glue it on board or glass, for a bent mat gives wrong sizes"
        )
    if fit.stretch:
        longer = "longer" if fit.stretch > 0 else "shorter"
        yield (
            f"the mat is printed {100 * abs(np.expm1(fit.stretch)):.1f} % {longer} from the words "
            "away than across: allowed for, and lengths go by its bar, which lies across; "
            'print it at 100 % (not "fit to page"), or measure the bar'
        )
    yield from _iter_zoom_faults(found, groups)


def _iter_zoom_faults(found: Sequence[PlacedPicture], groups: _Groups) -> Iterator[str]:
    of_kind: dict[_Kind, list[PlacedPicture]] = {}
    for each in found:
        if (kind := groups[each.picture]) is not None:
            of_kind.setdefault(kind, []).append(each)
    for kind, pictures in of_kind.items():
        usual = of_kind.get(replace(kind, zoom=0), [])
        camera = pictures[0].camera
        names = named([e.picture.shot.name for e in pictures])
        if kind.zoom and usual:
            ratio = camera.focal / usual[0].camera.focal
            yield (
                f"two focal lengths: {names} {'is' if len(pictures) == 1 else 'are'} zoomed or "
                f"cropped {ratio:.3g} times: each has a camera of its own now; take all pictures "
                "at one zoom, and do not crop them"
            )
        off = camera.centre - (np.array(kind.size) - 1) / 2
        off_px = float(np.hypot(*off))
        if off_px > SURE_SDS * CENTRE_SD * float(np.hypot(*kind.size)):
            yield (
                f"the optical axis is {off_px:.0f} px off the middle of {names}: use pictures as "
                "they were taken, not cropped"
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


def _find_zooms(
    pictures: Sequence[Corners], size: tuple[int, int], focal: float | None
) -> NDArray[np.intp]:
    """Return the number of each picture's zoom (n,), by rising focal length.

    A picture that was cropped and enlarged, and has no EXIF, looks like another of the same size.
    One focal length for both kinds gives poses that are far off and yet fit the corners well. Each
    picture that sees the mat at a slant has its own focal length in it, to some percent: where
    these are two, there are two cameras.

    `focal` is what EXIF says of the focal length, in pixels. AMBIGUOUS are pictures which another
    zoom suits as well, where there are several: those from right above.
    """
    fits = [fitted([replace(p, camera=0)], [size], [focal]).cameras[0] for p in pictures]
    logs = np.array([np.log(camera.focal) for camera in fits])
    variances = np.array([camera.cov[0, 0] for camera in fits]) + FOCUS_SD**2
    groups = _split(np.argsort(logs, kind="stable"), logs, variances)
    zooms = np.zeros(len(pictures), dtype=np.intp)
    means = np.array([np.average(logs[g], weights=1 / variances[g]) for g in groups])
    for number, group in enumerate(groups):
        zooms[group] = number
    others = np.abs(logs[:, None] - means) / np.sqrt(variances)[:, None]
    others[np.arange(len(pictures)), zooms] = np.inf
    zooms[others.min(axis=1) < AMBIGUOUS_SDS] = AMBIGUOUS
    return zooms


def _split(
    order: NDArray[np.intp], logs: FloatArray, variances: FloatArray
) -> list[NDArray[np.intp]]:
    """Split pictures (n,) in the order of their focal lengths into groups of one zoom each."""
    best, cut = LEAST_CHI2, 0
    for at in range(1, len(order)):
        low, high = order[:at], order[at:]
        weights = (1 / variances[low]).sum(), (1 / variances[high]).sum()
        ratio = float(
            np.average(logs[high], weights=1 / variances[high])
            - np.average(logs[low], weights=1 / variances[low])
        )
        chi2 = ratio**2 / (1 / weights[0] + 1 / weights[1])
        if ratio >= LEAST_RATIO_SDS * FOCUS_SD and chi2 > best:
            best, cut = chi2, at
    if cut == 0:
        return [order]
    return [*_split(order[:cut], logs, variances), *_split(order[cut:], logs, variances)]
