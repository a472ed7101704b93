"""Which pictures of one camera were taken at which focal length: some may be zoomed, or cropped.

A picture that was cropped and enlarged, and has no EXIF, looks like another of the same size. One
focal length for both kinds gives poses that are far off and yet fit the corners well. Each picture
that sees the mat at a slant has its own focal length in it, to some percent: where these are two,
there are two cameras.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.reading.mat.fit import Corners, fitted
from facetlog.perception.types import FloatArray

__all__ = ["AMBIGUOUS", "find_zooms"]

AMBIGUOUS = -1
FOCUS_SD = 0.02
"""Of the log of a focal length between pictures of one zoom: a lens of 5 mm that focuses at 15 cm
stands 3 % farther out than at infinity."""
LEAST_RATIO_SDS = 5.0
"""Two zooms differ by more than focusing does, in these standard deviations: by a tenth."""
LEAST_CHI2 = 25.0
"""By how much two focal lengths must explain the pictures better: five standard deviations, for as
many ways to split a set are tried as it has pictures."""
AMBIGUOUS_SDS = 3.0


def find_zooms(
    pictures: Sequence[Corners], size: tuple[int, int], focal: float | None
) -> NDArray[np.intp]:
    """Return the number of each picture's zoom (n,), by rising focal length.

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
    """The pictures (n,), in the order of their focal lengths, in groups of one zoom each."""
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
