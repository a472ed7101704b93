"""Tours: the camera's poses that are wanted, from a CSV file or the paper's own.

A CSV file has a column each for x, y, z, pan_deg, tilt_deg, and may have image and skew_deg: the
pinhole and the paper's angles A, B, C (perception/pan_tilt.py), lengths in a unit that is given
separately. The columns of the paper's tour.csv (x_in, y_in, z_in) are in inches and need no unit.
Lines that start with # are comments.
"""

import csv
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.recording import compute_pan_tilt_angles
from facetlog.robot.tour import tour_poses
from facetlog.safe_read import read_regular_text

PAPER_TOUR = "paper"
INCH = 0.0254
PLACES, INCHES = ("x", "y", "z"), ("x_in", "y_in", "z_in")
ANGLES = ("pan_deg", "tilt_deg")
HEADER = "image,x,y,z,pan_deg,tilt_deg,skew_deg"
# Two lines of sight count as parallel if the normal matrix of their common point is this near to
# singular: its standard deviation along them would be more than ten times that across.
LEAST_CONDITION = 0.01
# A skew that an eye does not see; printed tours are rounded to tenths.
SMALL_SKEW = math.radians(0.1)


@dataclass(frozen=True, eq=False, slots=True)
class TourView:
    """One view that is wanted: the name of its picture and the camera's pose (metres)."""

    name: str
    pose: Pose

    @property
    def direction(self) -> FloatArray:
        """Unit vector (3,) along the view."""
        return np.asarray(self.pose.rotation[:, 2])

    @property
    def skewed(self) -> bool:
        """Whether the picture is to be turned about the line of sight."""
        return abs(compute_pan_tilt_angles(self.pose)[2]) > SMALL_SKEW


@dataclass(frozen=True, eq=False, slots=True)
class Tour:
    """Views in the order in which they are wanted; `name` is what messages call it.

    `aim` (3,) is what is looked at, None if the views themselves say it.
    """

    name: str
    views: tuple[TourView, ...]
    aim: FloatArray | None = None

    @property
    def target(self) -> FloatArray | None:
        """The point (3,) that is nearest to all lines of sight; None if they do not meet.

        Nor is there one if most views look away from where their lines meet, as all round a room.
        Least squares: Σ (I - d dᵀ) p = Σ (I - d dᵀ) c over the views' directions d and centres c.
        """
        if self.aim is not None:
            return self.aim
        blocks = [np.eye(3) - np.outer(v.direction, v.direction) for v in self.views]
        total = np.sum(blocks, axis=0)
        if not blocks or np.linalg.eigvalsh(total)[0] < LEAST_CONDITION * len(blocks):
            return None
        centres = [block @ v.pose.centre for block, v in zip(blocks, self.views, strict=True)]
        point = np.asarray(np.linalg.solve(total, np.sum(centres, axis=0)))
        towards = sum(bool(v.direction @ (point - v.pose.centre) > 0) for v in self.views)
        return point if 2 * towards > len(self.views) else None


def make_paper_tour() -> Tour:
    """Return the 24 views of the paper's figure 8 in metres; see robot/tour.py."""
    poses = tour_poses()
    return Tour(
        PAPER_TOUR,
        tuple(
            TourView(f"view{number:03d}.png", Pose(pose.rotation, pose.centre * INCH))
            for number, pose in enumerate(poses, start=1)
        ),
    )


def read_tour(path: Path, *, unit: float | None = None) -> Tour:
    """Return the tour in a CSV file, in metres; `unit` is the metres in its unit of length.

    InputError for what is not such a file, has no unit or names a picture twice, CalibrationError
    for a pose that cannot be; both name file and line.
    """
    views: list[TourView] = []
    seen: dict[str, int] = {}
    for line, row in _read_rows(path):
        where = f"{path}:{line}"
        scale = INCH if INCHES[0] in row else unit
        if scale is None:
            raise InputError(f"{path}: its unit of length is unknown: give --unit m (cm, in, …)")
        name = _read_picture_name(row.get("image", ""), len(views) + 1, where)
        if name in seen:
            raise InputError(f"{where}: picture {name} is in line {seen[name]} as well")
        seen[name] = line
        views.append(TourView(name, _pose(row, scale, where)))
    if not views:
        raise InputError(f"{path} has no poses: a line for each under {HEADER}")
    return Tour(str(path), tuple(views))


def _read_rows(path: Path) -> Iterator[tuple[int, Mapping[str, str]]]:
    """Iterate over line number and fields of each pose, its columns checked."""
    try:
        text = read_regular_text(path)
    except FileNotFoundError as exc:
        raise InputError(f"tour {path} is missing: give a CSV file, or `{PAPER_TOUR}`") from exc
    except (OSError, UnicodeDecodeError) as exc:
        reason = getattr(exc, "strerror", None) or exc
        raise InputError(f"tour {path} cannot be read: {reason}") from exc
    lines = csv.reader(io.StringIO(text), strict=True)
    header: tuple[str, ...] = ()
    try:
        for cells in lines:
            if not any(cell.strip() for cell in cells) or cells[0].startswith("#"):
                continue
            if not header:
                header = tuple(cell.strip() for cell in cells)
                places = INCHES if INCHES[0] in header else PLACES
                missing = [name for name in (*places, *ANGLES) if name not in header]
                if missing:
                    raise InputError(
                        f"{path}:{lines.line_num}: no column {', '.join(missing)}: "
                        f"the first line is {HEADER}"
                    )
                continue
            if len(cells) != len(header):
                raise InputError(
                    f"{path}:{lines.line_num}: {len(cells)} fields, the first line has "
                    f"{len(header)}"
                )
            yield lines.line_num, dict(zip(header, cells, strict=True))
    except csv.Error as exc:
        raise InputError(f"{path}:{lines.line_num}: not CSV: {exc}") from exc


def _pose(row: Mapping[str, str], scale: float, where: str) -> Pose:
    places = INCHES if INCHES[0] in row else PLACES
    x, y, z = (_parse_number(row, key, where) * scale for key in places)
    pan, tilt = (math.radians(_parse_number(row, key, where)) for key in ANGLES)
    skew = (
        math.radians(_parse_number(row, "skew_deg", where))
        if row.get("skew_deg", "").strip()
        else 0.0
    )
    return pan_tilt_pose(x, y, z, pan, tilt, skew)


def _parse_number(row: Mapping[str, str], key: str, where: str) -> float:
    try:
        value = float(row[key])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise CalibrationError(f"{where}: {key} is {row[key]!r:.40}: give a finite number")
    return value


def _read_picture_name(given: str, number: int, where: str) -> str:
    """Return the name of the picture's file: PNG, in the folder itself whatever the tour's
    folders are.
    """
    if not given.strip():
        return f"view{number:03d}.png"
    stem = PurePosixPath(given.strip()).stem
    if not stem or stem.startswith(".") or not stem.isprintable():
        raise InputError(f"{where}: image is {given!r:.40}: give a picture's name")
    return f"{stem}.png"
