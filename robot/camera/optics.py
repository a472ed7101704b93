"""The camera's intrinsics as the record writes them: a pinhole and its lens distortion."""

from dataclasses import dataclass, field

from facetlog.errors import DeviceError
from facetlog.perception.types import Camera, Image


@dataclass(frozen=True, slots=True)
class Optics:
    """The pinhole (pixels, the middle of the first one is 0, 0) and its lens distortion.

    `coefficients` are names and values (k1 … k4, p1, p2) of the distortion model `model`, named as
    by COLMAP and nerfstudio: PINHOLE, OPENCV or OPENCV_FISHEYE.
    """

    camera: Camera
    model: str = "PINHOLE"
    coefficients: tuple[tuple[str, float], ...] = field(default=())

    def coefficient(self, name: str) -> float:
        """Return one coefficient, 0 where there is none."""
        return dict(self.coefficients).get(name, 0.0)

    def check(self, image: Image) -> None:
        """Raise DeviceError for a picture of another size: it is of another camera."""
        height, width = image.shape[:2]
        if (width, height) != (self.camera.width, self.camera.height):
            raise DeviceError(
                f"the camera's pictures are {width} x {height}, its calibration is for "
                f"{self.camera.width} x {self.camera.height}: give the --camera-file of this camera"
            )
