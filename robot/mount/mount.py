"""Where the camera head sits on the robot (extrinsics), with standard deviations; the mount file.

The head's two axes cross in one point of the robot's frame (x ahead, y left, z up; metres), and
the head's own frame is turned against the robot's by yaw, pitch and roll (about z, then y, then x).
The pinhole sits off the axes by an offset that turns with the head, the camera is turned about its
optical axis by a skew, and where the head says level the axis is raised by the tilt's zero.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from facetlog.errors import CalibrationError, InputError
from facetlog.safe_read import read_regular_text
from facetlog.toml_text import parse_toml_fields

LENGTHS = ("x", "y", "z", "pinhole_ahead", "pinhole_left", "pinhole_up")
ANGLES = ("yaw", "pitch", "roll", "tilt_zero", "skew")
PARAMETERS = (*LENGTHS[:3], *ANGLES[:3], *ANGLES[3:], *LENGTHS[3:])
"""Names of the numbers of a mount, in their order in vectors and covariances."""


@dataclass(frozen=True, slots=True)
class Mount:
    """Eleven numbers, in metres and radians, and the standard deviation of each (`sds`)."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    """Positive leans the head forwards."""
    roll: float = 0.0
    tilt_zero: float = 0.0
    skew: float = 0.0
    pinhole_ahead: float = 0.0
    pinhole_left: float = 0.0
    pinhole_up: float = 0.0
    sds: tuple[float, ...] = (0.0,) * len(PARAMETERS)

    def __post_init__(self) -> None:
        if len(self.sds) != len(PARAMETERS):
            raise ValueError(f"{len(self.sds)} deviations for {len(PARAMETERS)} numbers")
        if not all(math.isfinite(v) for v in (*self.values, *self.sds)) or min(self.sds) < 0:
            raise CalibrationError("a mount has finite numbers, and deviations from 0")

    @property
    def values(self) -> tuple[float, ...]:
        """The eleven numbers, in the order of `PARAMETERS`."""
        return tuple(getattr(self, name) for name in PARAMETERS)

    def replace_values(self, values: tuple[float, ...]) -> "Mount":
        """Return the mount with other numbers and the same deviations."""
        changed = dict(zip(PARAMETERS, values, strict=True))
        kept: dict[str, tuple[float, ...]] = {"sds": self.sds}
        return Mount(**changed, **kept)  # type: ignore[arg-type]


# The height of the paper's pinhole (figure 8: 28.5 inches) over the middle of the drive axle, and
# the accuracy of a tape and an eye: 5 mm and 1 degree.
PAPER_HEIGHT = 28.5 * 0.0254
TAPE_SD, EYE_SD = 0.005, math.radians(1.0)
DEFAULT_MOUNT = Mount(
    z=PAPER_HEIGHT,
    sds=tuple(TAPE_SD if name in LENGTHS else EYE_SD for name in PARAMETERS),
)
"""The paper's mast, as far as the paper describes it."""


def _key(name: str) -> str:
    return f"{name}_deg" if name in ANGLES else name


def format_mount(mount: Mount, *, remarks: tuple[str, ...] = ()) -> str:
    """Return the mount as TOML, in metres and degrees; `remarks` are put before it as comments."""
    head = ("# Where the camera head sits on the robot: metres and degrees.", *remarks)
    lines = [line if line.startswith("#") else f"# {line}" for line in head]
    for title, values in (("mount", mount.values), ("sd", mount.sds)):
        lines += ["", f"[{title}]"]
        for name, value in zip(PARAMETERS, values, strict=True):
            written = math.degrees(value) if name in ANGLES else value
            lines.append(f"{_key(name)} = {written:.6f}")
    return "\n".join([*lines, ""])


def read_mount(path: Path) -> Mount:
    """Return the mount in a TOML file: tables mount and sd, missing keys have their defaults.

    InputError for a file that is not of this form, CalibrationError for impossible numbers; both
    name the file and the key.
    """
    try:
        text = read_regular_text(path)
    except FileNotFoundError as exc:
        raise InputError(
            f"{path} is missing: write it by hand (docs/robot.md) or by `facetlog mount`"
        ) from exc
    except (OSError, UnicodeDecodeError) as exc:
        raise InputError(f"{path}: cannot be read: {exc}") from exc
    tables = parse_toml_fields(text, str(path))
    for name in tables:
        if name not in ("mount", "sd"):
            raise InputError(f"{path}: there is no table {name!r:.40}: use [mount] and [sd]")
    values = _numbers(tables.get("mount", {}), DEFAULT_MOUNT.values, f"{path}: [mount]")
    sds = _numbers(tables.get("sd", {}), DEFAULT_MOUNT.sds, f"{path}: [sd]")
    if min(sds) < 0:
        raise CalibrationError(f"{path}: [sd]: a standard deviation is not negative")
    return replace(DEFAULT_MOUNT.replace_values(values), sds=sds)


def _numbers(table: object, instead: tuple[float, ...], where: str) -> tuple[float, ...]:
    """Return the numbers of one table in SI units, in the order of `PARAMETERS`."""
    if not isinstance(table, Mapping):
        raise InputError(f"{where}: is no table")
    keys = {_key(name): name for name in PARAMETERS}
    for key in table:
        if key not in keys:
            raise InputError(f"{where}: there is no {key!r:.40}: use {', '.join(keys)}")
    found = []
    for (key, name), default in zip(keys.items(), instead, strict=True):
        value = table.get(key)
        if value is None:
            found.append(default)
            continue
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise CalibrationError(f"{where}: {key} is {value!r:.40}: give a number")
        if not math.isfinite(value):
            raise CalibrationError(f"{where}: {key} is {value}: give a finite number")
        found.append(math.radians(value) if name in ANGLES else float(value))
    return tuple(found)
