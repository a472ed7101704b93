"""The contents of a poses file, before its pictures are read: intrinsics, poses, unit of length."""

import math
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.lens import CAMERA_MODELS, Distortion, Lens
from facetlog.perception.reading.pose_files.file_values import number
from facetlog.perception.reading.pose_files.pose_checks import check_lens, check_pose
from facetlog.perception.reading.skipped_images import LeftOut
from facetlog.perception.reading.video_file import VideoFrame
from facetlog.perception.types import Camera, FloatArray, Pose, PoseErrorKind

ROUNDING_PX = 1.0
"""Largest difference of a scaled picture's height from its camera's."""

MIDDLE_SHARES = 0.3, 0.7
"""Range of principal points as shares of width and height, also in pictures cropped to one side.
Both shares are outside for pictures of less than .7 or more than 1.7 times their camera's size."""

# The only models with such coefficients: OpenCV's k4 to k6 are its denominator.
RATIONAL, PRISMS = "FULL_OPENCV", ("THIN_PRISM_FISHEYE", "RAD_TAN_THIN_PRISM_FISHEYE")
# Of the models that are no polynomials; the radians and the other ranges of read_intrinsics.
PROJECTIONS = {
    Distortion.FOV: ("omega",),
    Distortion.DIVISION: ("k",),
    Distortion.UNIFIED: ("alpha", "beta"),
}
POLYNOMIAL = ("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "sx1", "sx2", "sy1", "sy2")
COEFFICIENTS = (*POLYNOMIAL, *(name for names in PROJECTIONS.values() for name in names))


@dataclass(frozen=True, slots=True)
class FieldNames:
    """A format's names for the fields of a camera, and the centre of its top-left pixel."""

    width: str
    height: str
    fx: str
    fy: str
    pixel_centre: float


PLAIN_NAMES = FieldNames("width", "height", "fx", "fy", pixel_centre=0.0)


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A camera as written in a file; missing optional fields are None (pixels, radians)."""

    where: str
    size: tuple[int | None, int | None] = (None, None)
    focal: tuple[float | None, float | None] = (None, None)
    field_of_view: tuple[float | None, float | None] = (None, None)
    centre: tuple[float, float] | None = None
    distortion: Distortion = Distortion.NONE
    radial: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    tangential: tuple[float, float] = (0.0, 0.0)
    rational: tuple[float, float, float] = (0.0, 0.0, 0.0)
    prism: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    projection: tuple[float, ...] = ()

    @property
    def suits_one_size(self) -> bool:
        """Whether the camera is for one size of picture, which the file does not give."""
        return not all(self.size) and (any(self.focal) or self.centre is not None)

    def describe_size_fault(self, width: int, height: int) -> str:
        """Return why a picture of this size cannot be of this camera, and what to do; empty if it
        can.
        """
        said = (self.size[0] or width, self.size[1] or height)
        if said == (width, height):
            return ""
        share = width / said[0]
        if said == (height, width):
            remedy = "store it the way round that the camera was calibrated: EXIF turns nothing"
        elif abs(share * said[1] - height) <= ROUNDING_PX:
            remedy = (
                f"if it shows the same at {share:.3g} times the size, scale the camera by that; "
                "or use the pictures at the size they were calibrated at"
            )
        else:
            remedy = "use the pictures at the size they were calibrated at"
        return (
            f"{self.where}: the picture is {width} x {height}, its camera says "
            f"{said[0]} x {said[1]}: {remedy}"
        )

    def lens(self, width: int, height: int) -> Lens:
        """Return the lens for a picture of this size; CalibrationError if it cannot be."""
        fx, fy = (
            f or (length / 2 / math.tan(angle / 2) if angle else None)
            for f, angle, length in zip(
                self.focal, self.field_of_view, (width, height), strict=True
            )
        )
        fx, fy = fx or fy, fy or fx  # one focal length: the pixels are square
        if fx is None or fy is None:
            raise CalibrationError(f"{self.where}: the camera has no focal length")
        if self.suits_one_size and self.centre is not None:
            self._check_middle(width, height)
        cx, cy = self.centre or ((width - 1) / 2, (height - 1) / 2)
        try:
            camera = Camera(width, height, fx, fy, cx, cy)
            lens = Lens(
                *(camera, self.distortion, self.radial, self.tangential),
                *(self.rational, self.prism, self.projection),
            )
            with np.errstate(all="ignore"):  # of numbers that no lens has
                check_lens(lens, self.where)
        except CalibrationError as exc:
            if str(exc).startswith(self.where):
                raise
            raise CalibrationError(f"{self.where}: {exc}") from exc
        return lens

    def _check_middle(self, width: int, height: int) -> None:
        """Raise CalibrationError if the camera is for larger or smaller pictures, by its centre."""
        cx, cy = self.centre or (0.0, 0.0)
        across, down = (cx + 0.5) / width, (cy + 0.5) / height
        low, high = MIDDLE_SHARES
        if not (low < across < high or low < down < high):
            raise CalibrationError(
                f"{self.where}: the principal point ({cx:.6g}, {cy:.6g}) is far from the middle of "
                f"the picture of {width} x {height}, as of a camera for pictures of "
                f"{2 * cx:.0f} x {2 * cy:.0f}: use the pictures at the size they were calibrated "
                "at, or give the camera's size"
            )


@dataclass(frozen=True, slots=True)
class PosedPicture:
    """One picture of a poses file: the name it has there, its file, camera and pose; `frame` where
    that is a video. Camera and pose are those of the picture after so many quarter `turns` to the
    right: none, but where the poses were found in pictures that were read so.

    `covariance` (6, 6), if the file has it: of the camera's place (world units) and of a rotation
    vector in the world frame (radians).
    """

    name: str
    path: Path
    intrinsics: Intrinsics
    pose: Pose
    covariance: FloatArray | None = field(default=None, compare=False)
    frame: VideoFrame | None = None
    turns: int = 0

    @property
    def place(self) -> str:
        """Place of its camera or pose, for messages, with its name."""
        where, quoted = self.intrinsics.where, f"{self.name!r:.80}"
        return where if quoted in where else f"{where} ({quoted})"


@dataclass(frozen=True, eq=False, slots=True)
class PosesFile:
    """All pictures of a poses file; `up` unit vector or None, `metric` if lengths are metres.

    `unit` is the unit of length that the file states, None where it states none.
    `folder` is the one that the pictures must be within (path_guard.py); it names the set of views.
    `error_kind` says how the pose errors are correlated whose covariances the pictures have.
    `faults` are of the pictures with an invalid camera or pose, `left_out` those for which none was
    found. `kind` says more of it than its reader does, for people; else it is empty. `scale_sd` is
    the relative standard deviation of its unit (as in `PoseErrors`). `notes` say, for people,
    what would make the poses better, `advice` what to do if no picture can be used.
    """

    folder: Path
    pictures: tuple[PosedPicture, ...]
    up: FloatArray | None = None
    metric: bool = False
    error_kind: PoseErrorKind = PoseErrorKind.ODOMETRY
    faults: tuple[InputError, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    kind: str = ""
    scale_sd: float = 0.0
    notes: tuple[str, ...] = ()
    advice: str = ""
    unit: str | None = None

    def to_metres(self, metres: float) -> "PosesFile":
        """Return the file in metres, of which its unit of length has so many."""
        units = np.array([metres] * 3 + [1.0] * 3)
        pictures = []
        for each in self.pictures:
            pose = copy(each.pose)  # a pose made anew would change its rotation's last bits
            centre = pose.centre * metres
            centre.setflags(write=False)
            object.__setattr__(pose, "centre", centre)
            cov = None if each.covariance is None else each.covariance * np.outer(units, units)
            pictures.append(replace(each, pose=pose, covariance=cov))
        return replace(self, pictures=tuple(pictures), metric=True)


def collect_posed_pictures(
    readers: Iterable[Callable[[], PosedPicture]],
) -> tuple[tuple[PosedPicture, ...], tuple[InputError, ...]]:
    """Return the pictures whose camera and pose can be read, and the faults of the others."""
    pictures: list[PosedPicture] = []
    faults: list[InputError] = []
    for read in readers:
        try:
            with np.errstate(all="ignore"):  # numbers that no pose has: checked below
                picture = read()
            check_pose(picture.pose, picture.covariance, picture.place)
            pictures.append(picture)
        except InputError as exc:
            faults.append(exc)
    return tuple(pictures), tuple(faults)


def list_unregistered(path: Path, names: Iterable[str]) -> tuple[LeftOut, ...]:
    """Return the pictures of a file that structure from motion gave no pose, as left out."""
    return tuple(
        LeftOut(name, f"{path}: {name} has no pose: it was not registered", name) for name in names
    )


def read_intrinsics(fields: Mapping[str, object], names: FieldNames, where: str) -> Intrinsics:
    """Read the camera in `fields`, one field at a time; CalibrationError says which is wrong.

    Needs a focal length, or a field of view (then the centre may be left out: the middle).
    """
    model = fields.get("camera_model")
    if model is None:  # the general one, as nerfstudio takes it
        model = "OPENCV"
    if not isinstance(model, str) or model not in CAMERA_MODELS:
        raise CalibrationError(
            f"{where}: camera_model {model!r} is not one of {', '.join(CAMERA_MODELS)}: "
            "undistort the pictures (colmap image_undistorter does) and give a PINHOLE camera"
        )

    def optional(key: str) -> float | None:
        return number(fields, key, where) if fields.get(key) is not None else None

    def positive(key: str) -> float | None:
        value = optional(key)
        if value is not None and value <= 0:
            raise CalibrationError(f"{where}: {key} is {value:g}: give it in pixels, above 0")
        return value

    def pixels(key: str) -> int | None:
        value = positive(key)
        if value is not None and value != int(value):
            raise CalibrationError(f"{where}: {key} is {value:g}, it must be whole")
        return None if value is None else int(value)

    def angle(key: str) -> float | None:
        value = positive(key)
        if value is not None and value >= math.pi:
            raise CalibrationError(f"{where}: {key} is {value:g}, it must be radians below pi")
        return value

    focal = positive(names.fx), positive(names.fy)
    view = angle("camera_angle_x"), angle("camera_angle_y")
    cx, cy = optional("cx"), optional("cy")
    if not any((*focal, *view)):
        raise CalibrationError(
            f"{where}: the camera has no intrinsics: give {names.fx}, {names.fy}, cx, cy"
        )
    if (cx is None) != (cy is None) or (cx is None and any(focal) and not any(view)):
        missing = "cx" if cx is None else "cy"
        raise CalibrationError(f"{where}: the camera has no {missing}: give the principal point")
    given = {key: value for key in COEFFICIENTS if (value := optional(key)) is not None}
    k1, k2, k3, k4, k5, k6, p1, p2, sx1, sx2, sy1, sy2 = (given.get(key, 0.0) for key in POLYNOMIAL)
    distortion, _ = CAMERA_MODELS[model]
    if distortion is Distortion.NONE and any(given.values()):
        raise CalibrationError(
            f"{where}: a {model} camera has no distortion, yet coefficients are given: "
            "say camera_model OPENCV, or leave them out"
        )
    projection = tuple(given.get(key, 0.0) for key in PROJECTIONS.get(distortion, ()))
    if distortion is Distortion.FOV and abs(projection[0]) >= math.pi:
        raise CalibrationError(f"{where}: omega is {projection[0]:g}, it must be radians below pi")
    if distortion is Distortion.UNIFIED and not (0 <= projection[0] <= 1 and projection[1] > 0):
        raise CalibrationError(f"{where}: alpha must be from 0 to 1, and beta above 0")
    rational, radial_first = model == RATIONAL, distortion is Distortion.FISHEYE_RADIAL_FIRST
    shift = names.pixel_centre
    return Intrinsics(
        where=where,
        size=(pixels(names.width), pixels(names.height)),
        focal=focal,
        field_of_view=view,
        centre=None if cx is None or cy is None else (cx - shift, cy - shift),
        distortion=distortion,
        radial=(k1, k2, k3, 0.0 if rational else k4, *((k5, k6) if radial_first else ())),
        tangential=(
            (0.0, 0.0) if distortion is Distortion.FISHEYE and model not in PRISMS else (p1, p2)
        ),
        rational=(k4, k5, k6) if rational else (0.0, 0.0, 0.0),
        prism=(sx1, sx2, sy1, sy2) if model in PRISMS else (0.0, 0.0, 0.0, 0.0),
        projection=projection,
    )
