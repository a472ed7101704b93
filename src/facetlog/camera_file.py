"""Read the camera of a robot from camera.toml, as pan-tilt tours have it."""

from pathlib import Path

from facetlog.errors import CalibrationError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.file_values import get_metres_per, read_text
from facetlog.perception.reading.pose_files.poses_file import FieldNames, read_intrinsics
from facetlog.robot.camera.optics import Optics
from facetlog.toml_text import parse_toml_fields

__all__ = ["read_optics"]

NAMES = FieldNames("width", "height", "fx", "fy", pixel_centre=0.0)
MODELS = {
    Distortion.NONE: "PINHOLE",
    Distortion.POLYNOMIAL: "OPENCV",
    Distortion.FISHEYE: "OPENCV_FISHEYE",
}


def read_optics(path: Path) -> tuple[Optics, float | None]:
    """Read the camera in a TOML file, and the metres in the unit that it names, if it names one.

    Raise InputError for what is not TOML, CalibrationError for a camera that cannot be.
    """
    fields = parse_toml_fields(read_text(path), str(path))
    intrinsics = read_intrinsics(fields, NAMES, str(path))
    width, height = intrinsics.size
    if width is None or height is None:
        raise CalibrationError(f"{path}: the camera has no size: give width and height in pixels")
    lens = intrinsics.lens(width, height)
    if lens.distortion not in MODELS or any((*lens.rational, *lens.prism)):
        known = ", ".join(MODELS.values())
        raise CalibrationError(f"{path}: a robot's camera is one of {known}: calibrate it as such")
    named = dict(
        zip(("k1", "k2", "k3", "k4", "p1", "p2"), (*lens.radial, *lens.tangential), strict=True)
    )
    coefficients = tuple((name, value) for name, value in named.items() if value)
    model = MODELS[lens.distortion] if coefficients else "PINHOLE"
    unit = fields.get("unit")
    scale = get_metres_per(unit, str(path)) if isinstance(unit, str) else None
    return Optics(lens.camera, model, coefficients), scale
