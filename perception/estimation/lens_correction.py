"""Corrected pictures, and warnings, for lenses whose stated intrinsics were found to be wrong."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from facetlog.perception.name_lists import named
from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.types import Camera, Image, LensError, StoredPicture, View

WELL_KNOWN = 0.01
"""Relative standard deviation of a focal length above which the warning says that lengths are as
uncertain."""
SURE_SDS = 3.0
"""Standard deviations from the stated value from which on a lens error is reported."""


def corrected(view: View, error: LensError) -> View:
    """Return view undistorted, as a pinhole of the estimated focal length would have taken it."""
    lens = _build_lens(view.camera, error)
    stored = view.stored
    if stored is not None:
        large, read = _build_lens(stored.camera, error), stored.read

        def read_corrected() -> Image:
            return large.undistort(read())

        stored = StoredPicture(large.pinhole, read_corrected)
    return replace(view, image=lens.undistort(view.image), camera=lens.pinhole, stored=stored)


def combine_lens_errors(first: LensError, beyond: LensError) -> LensError:
    """Return the total lens error, where a view corrected by the first still has the second."""
    return LensError(
        first.focal * beyond.focal,
        first.radial + beyond.radial,
        first.focal * beyond.focal_sd,
        beyond.radial_sd,
    )


def explain_lens_errors(views: Sequence[View], errors: Sequence[LensError]) -> tuple[str, ...]:
    """Return warnings about the lenses of these views, given with their stated lenses; one a
    camera.
    """
    cameras: dict[tuple[Camera, LensError], list[View]] = {}
    for view, error in zip(views, errors, strict=True):
        cameras.setdefault((view.camera, error), []).append(view)
    found = []
    for (_, error), taken in cameras.items():
        shown = _shown(error, taken[0].camera.fx * float(taken[0].enlargement[0]))
        if not shown:
            continue
        whose = "" if len(cameras) == 1 else f" of {named([view.name for view in taken])}"
        uncertain = error.focal_sd > WELL_KNOWN * error.focal
        used = "lengths are known no better than that" if uncertain else "this was used"
        found.append(
            f"the lens{whose} is not as stated: the pictures show {' and '.join(shown)}; "
            f"{used}: calibrate the camera"
        )
    return tuple(found)


def _shown(error: LensError, given: float) -> list[str]:
    # The significant errors of a lens with a stated focal length of so many px.
    shown = []
    found, sd = error.focal * given, error.focal_sd * given
    if abs(error.focal - 1.0) > SURE_SDS * error.focal_sd > 0:
        digits = max(0, 1 - int(np.floor(np.log10(max(sd, 1e-3)))))
        shown.append(
            f"a focal length of {found:.{digits}f} ± {sd:.{digits}f} px ({given:.{digits}f} px is "
            "given)"
        )
    if abs(error.radial) > SURE_SDS * error.radial_sd > 0:
        shown.append(f"a radial distortion k1 of {error.radial:.3f} ± {error.radial_sd:.3f} more")
    return shown


def _build_lens(camera: Camera, error: LensError) -> Lens:
    radial = (error.radial, 0.0, 0.0, 0.0)
    return Lens(camera.zoomed(error.focal), Distortion.POLYNOMIAL, radial)
