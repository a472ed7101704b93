"""Pictures of lenses that are not what was stated: brought to what they were found to be."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.types import Camera, Image, LensError, StoredPicture, View

__all__ = ["corrected", "lens_warnings", "together"]

WELL_KNOWN = 0.01
"""A focal length known to a hundredth leaves lengths as well known."""
SURE_SDS = 2.0
NAMED = 3


def corrected(view: View, error: LensError) -> View:
    """The view as a pinhole of the focal length found would have taken it, freed of distortion."""
    lens = _lens(view.camera, error)
    stored = view.stored
    if stored is not None:
        large, read = _lens(stored.camera, error), stored.read

        def read_corrected() -> Image:
            return large.undistort(read())

        stored = StoredPicture(large.pinhole, read_corrected)
    return replace(view, image=lens.undistort(view.image), camera=lens.pinhole, stored=stored)


def together(first: LensError, beyond: LensError) -> LensError:
    """What a lens is off by, where a view corrected by the first is still off beyond it."""
    return LensError(
        first.focal * beyond.focal,
        first.radial + beyond.radial,
        first.focal * beyond.focal_sd,
        beyond.radial_sd,
    )


def lens_warnings(views: Sequence[View], errors: Sequence[LensError]) -> tuple[str, ...]:
    """What is to be said of the lenses of these views, which are as given; of each camera once."""
    cameras: dict[tuple[Camera, LensError], list[str]] = {}
    for view, error in zip(views, errors, strict=True):
        if error.focal_sd > 0:
            cameras.setdefault((view.camera, error), []).append(view.name)
    found = []
    for (camera, error), names in cameras.items():
        more = ", …" if len(names) > NAMED else ""
        whose = "" if len(cameras) == 1 else f" of {', '.join(names[:NAMED])}{more}"
        found.append(_warning(camera.fx * _scale(views, names[0]), error, whose))
    return tuple(found)


def _lens(camera: Camera, error: LensError) -> Lens:
    radial = (error.radial, 0.0, 0.0, 0.0)
    return Lens(camera.zoomed(error.focal), Distortion.POLYNOMIAL, radial)


def _scale(views: Sequence[View], name: str) -> float:
    return float(next(v for v in views if v.name == name).enlargement[0])


def _warning(given: float, error: LensError, whose: str) -> str:
    found, sd = error.focal * given, error.focal_sd * given
    digits = max(0, 1 - int(np.floor(np.log10(max(sd, 1e-3)))))
    parts = []
    if abs(error.focal - 1.0) > SURE_SDS * error.focal_sd:
        parts.append(
            f"a focal length of {found:.{digits}f} ± {sd:.{digits}f} px ({given:.{digits}f} px is "
            "given)"
        )
    if abs(error.radial) > SURE_SDS * error.radial_sd:
        parts.append(f"a radial distortion k1 of {error.radial:.3f} ± {error.radial_sd:.3f} beyond")
    shown = " and ".join(parts) or "that it is another one"
    uncertain = error.focal_sd > WELL_KNOWN * error.focal
    used = "lengths are known no better than that" if uncertain else "this was used"
    return (
        f"the lens{whose} is not as stated: the pictures show {shown}; {used}: calibrate the camera"
    )
