"""Checks of cameras and poses for values that no camera has.

They are refused here, of all kinds of files: what comes later squares and divides them, and would
end in overflow or in views that mean nothing.
"""

import numpy as np

from facetlog.errors import CalibrationError
from facetlog.perception.reading.lens import FISHEYES, Distortion, Lens
from facetlog.perception.types import FloatArray, Pose

FARTHEST = 1e12
"""Units of length from a world's origin, and standard deviations: a thousand times the earth's
circumference in millimetres, which are map coordinates. Doubles hold its fourth power."""
LEAST_SPREAD = 1e-6
"""Units of length between cameras: of metres less than a camera can be moved on purpose."""
WIDEST_TANGENT = 25.0
"""Tangent of the angle from the axis to the farthest pixel, 87.7 degrees: no pinhole sees more."""
SMALLEST_ANGLE = 1e-3
"""View angle in radians across a picture's diagonal: a telescope's."""
FARTHEST_CENTRE = 3.0
"""Largest distance of the principal point from the middle, in diagonals, also if cropped."""
LONGEST_PIXEL = 4.0
"""Largest ratio of a pixel's sides: pictures that are squeezed for the screen have 2."""
LEAST_GAIN, MOST_GAIN = 0.2, 1.2
"""Distorted over undistorted radius at a picture's corners: lenses bend inwards much (those that
see 180 degrees), outwards by a tenth."""
SHARE_OF_PICTURE = 5.0
"""Focal lengths below, in px, are none but shares of the picture's width or height: they are 0.3
(150 degrees) to 5 (a long telephoto lens)."""


def check_pose(pose: Pose, covariance: FloatArray | None, where: str) -> None:
    """Raise CalibrationError if a camera is, or may be off, farther than any can."""
    far = float(np.abs(pose.centre).max())
    if far > FARTHEST:
        raise CalibrationError(
            f"{where}: the camera is {far:.2g} units from the origin, more than {FARTHEST:.0e}: "
            "correct its translation"
        )
    if covariance is not None and np.abs(covariance).max() > FARTHEST**2:
        raise CalibrationError(
            f"{where}: the covariance has {np.abs(covariance).max():.2g}, more than "
            f"{FARTHEST**2:.0e}: correct it, or leave it out"
        )


def check_lens(lens: Lens, where: str) -> None:
    """Raise CalibrationError if no camera has the focal lengths, centre or distortion of a lens."""
    camera = lens.camera
    diagonal = float(np.hypot(camera.width, camera.height))
    shortest, longest = min(camera.fx, camera.fy), max(camera.fx, camera.fy)
    if longest < SHARE_OF_PICTURE and longest * WIDEST_TANGENT < diagonal:
        raise CalibrationError(
            f"{where}: a focal length of {shortest:.3g} px is a view angle of "
            f"{_view_angle_deg(shortest, camera.width):.1f} degrees: give it in pixels, not as a "
            "share "
            f"of the picture ({shortest:.3g} x {camera.width} = {shortest * camera.width:.4g} px "
            f"are {_view_angle_deg(shortest * camera.width, camera.width):.0f} degrees)"
        )
    off = abs(camera.cx - (camera.width - 1) / 2), abs(camera.cy - (camera.height - 1) / 2)
    if max(off) > FARTHEST_CENTRE * diagonal:
        raise CalibrationError(
            f"{where}: the principal point ({camera.cx:.6g}, {camera.cy:.6g}) is far outside of "
            f"the picture of {camera.width} x {camera.height}: give it in pixels"
        )
    # A fisheye's radius is its focal length times the angle: from the middle, all round, π.
    most = np.pi * shortest if lens.distortion in FISHEYES else WIDEST_TANGENT * shortest
    if max(off[0] + camera.width / 2, off[1] + camera.height / 2) > most:
        raise CalibrationError(
            f"{where}: focal lengths of {camera.fx:.3g} and {camera.fy:.3g} px are a view angle of "
            f"{_view_angle_deg(shortest, camera.width):.1f} degrees in pictures of "
            f"{camera.width} x {camera.height}: give them in pixels of these pictures"
        )
    if longest * SMALLEST_ANGLE > diagonal:
        raise CalibrationError(
            f"{where}: focal lengths of {camera.fx:.3g} and {camera.fy:.3g} px are a view angle of "
            f"{_view_angle_deg(longest, camera.width):.2g} degrees: give them in pixels"
        )
    if longest > LONGEST_PIXEL * shortest:
        raise CalibrationError(
            f"{where}: focal lengths of {camera.fx:.3g} px across and {camera.fy:.3g} px down are "
            f"more than {LONGEST_PIXEL:g} times apart: give both in pixels of the picture"
        )
    gain = _compute_corner_gain(lens)
    if lens.distortion is Distortion.POLYNOMIAL and not LEAST_GAIN <= gain <= MOST_GAIN:
        shown = ", ".join(f"{c:g}" for c in lens.coefficients)
        raise CalibrationError(
            f"{where}: the lens distortion ({shown}) moves the picture's corners "
            f"to {gain:.3g} times their distance from the middle ({LEAST_GAIN} to {MOST_GAIN}): "
            "check the coefficients and the camera model"
        )


def _compute_corner_gain(lens: Lens) -> float:
    """Return the distorted over the undistorted radius of a picture's corners, farthest from 1."""
    pinhole = lens.pinhole
    u, v = np.array([0.0, pinhole.width - 1.0]), np.array([0.0, pinhole.height - 1.0])
    x, y = (u - pinhole.cx) / pinhole.fx, (v - pinhole.cy) / pinhole.fy
    gains = lens.compute_radial_gain(np.add.outer(x**2, y**2).ravel())
    return float(gains[np.argmax(np.abs(np.log(np.maximum(gains, 1e-300))))])


def _view_angle_deg(focal: float, length: int) -> float:
    return float(np.degrees(2 * np.arctan2(length / 2, focal)))
