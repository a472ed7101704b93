"""Unusable pictures: black, saturated, of one grey level, tiny, blurred, or given twice.

A picture without contrast is recognised by itself. Blur is measured at the strongest edges, whose
gradient falls by less than a sharp edge's when the picture is smoothed once more. A few pictures
more blurred than the others are left out; where most are blurred, all are kept.

Of duplicate pictures with different poses at most one can be right: noise makes any two photographs
differ. Pictures rendered without noise may be equal where the thing looks the same from several
sides, so they are named, and all stay.
"""

import hashlib
from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.errors import InputError
from facetlog.perception.detection.picture_noise import noise_sd
from facetlog.perception.name_lists import named
from facetlog.perception.reading.picture_file import LEAST_SIDE_PX
from facetlog.perception.threads import map_on_threads
from facetlog.perception.types import FloatArray, Image, View

DARK, BRIGHT = 40.0, 215.0
"""Grey levels of an empty picture, below which it is called black and above which saturated."""
ENDS = (0.001, 0.999)
"""Quantiles between which nearly all grey levels lie: a thousandth of the pixels may be defects
of the sensor."""
NOISE_ENDS_SD = 3.1
"""The same quantiles of normal noise, in standard deviations."""
ROUNDING = 3.0
"""Grey levels by which compression and uneven light may change an empty picture."""
FINE_PX, COARSE_PX = 1.0, 3.0
"""Smoothing before the two gradients that are compared."""
EDGES = 0.01
"""The share of the pixels with the strongest coarse gradients: the edges."""
MIN_CONTRAST_SD = 8.0
"""Edges weaker than this, in sd of the coarse gradient's noise, are not measured."""
LEAST_OTHERS = 5
"""The spread of the blur is not estimated from fewer other pictures."""
OUTLIER_SDS = 5.0
"""Robust standard deviations above the median of the others: edges differ in width by depth too,
so far out only motion or a lens out of focus brings a picture."""
MUCH = 2.0
"""A blur less than so many times the others' costs little: its edges are only less certain."""
SOFT_PX = 1.5
"""From here on faces are lost: of a rendered table blurred by 1.8 px 3 to 5 of 8 are found, of a
chair by 1.6 px 2 of 3. Sharp pictures, rendered or photographed, reach .8."""
MEDIAN_OF_NORMAL = 0.6745


def select_usable_views(views: Sequence[View]) -> tuple[tuple[View, ...], tuple[str, ...]]:
    """Return the views whose pictures show something, and a warning for each kind of fault.

    InputError where fewer than two are left. Blurred pictures are left out while most are sharp;
    where most are blurred, all stay.
    """
    empty = {k: fault for k, view in enumerate(views) if (fault := find_picture_fault(view.image))}
    if len(views) - len(empty) < min(2, len(views)):
        raise InputError(_explain_empty_views(views, empty))
    shown = [k for k in range(len(views)) if k not in empty]
    blurs = np.array(list(map_on_threads(blur_px, [views[k].image for k in shown])))
    blurred = {shown[n]: float(blurs[n]) for n in _find_far_above(blurs)}
    warnings = [
        f"{named([views[k].name for k, f in empty.items() if f == fault])}: {fault}, left out"
        for fault in dict.fromkeys(empty.values())
    ]
    usual = float(np.nanmedian(blurs)) if np.isfinite(blurs).any() else 0.0
    if blurred:
        widest = max(blurred.values())
        warnings.append(
            f"{named([views[k].name for k in blurred])}: blurred by up to {widest:.1f} px, the "
            f"other pictures by {usual:.1f}, left out"
        )
    soft = [views[k].name for k, blur in zip(shown, blurs, strict=True) if blur >= SOFT_PX]
    if usual >= SOFT_PX:
        warnings.append(_blurred(soft, len(shown), usual))
    left = tuple(views[k] for k in shown if k not in blurred)
    return left, tuple(warnings)


def find_picture_fault(image: Image) -> str | None:
    """Return the fault of an empty picture ("black", "saturated", "of one grey level", "too
    small"); None if it has grey levels beyond its noise.
    """
    if min(image.shape) < LEAST_SIDE_PX:
        return f"too small ({image.shape[1]} x {image.shape[0]})"
    counts = np.cumsum(np.bincount(image.ravel(), minlength=256)) / image.size
    low, high = np.searchsorted(counts, ENDS)
    if high - low > 2 * NOISE_ENDS_SD * noise_sd(image) + ROUNDING:
        return None
    level = float(image.mean())
    return "black" if level < DARK else "saturated" if level > BRIGHT else "of one grey level"


def blur_px(image: Image) -> float:
    """Return the standard deviation in px of the blur of the picture's strongest edges; NaN without
    edges.

    The gradient of a step of height C, blurred by b and smoothed by s, peaks at
    C / sqrt(2π (s² + b²)): the ratio r of two of them gives b² = (s₂² - r² s₁²) / (r² - 1).
    """
    coarse = _measure_gradient(image, COARSE_PX)
    least = MIN_CONTRAST_SD * noise_sd(image) / (np.sqrt(8 * np.pi) * (COARSE_PX**2 + 0.5))
    # Neighbours are correlated: every second row and column is enough for a quantile.
    peaks = coarse > max(float(np.quantile(coarse[::2, ::2], 1.0 - EDGES)), least)
    if not peaks.any():
        return float("nan")
    size = 2 * round(COARSE_PX) + 1
    nearest = np.asarray(
        cv2.dilate(_measure_gradient(image, FINE_PX), np.ones((size, size), np.uint8))
    )
    # Sobel's own smoothing adds half a pixel squared to both.
    s1, s2 = FINE_PX**2 + 0.5, COARSE_PX**2 + 0.5
    widest = np.sqrt(s2 / s1)
    r = float(np.clip(np.median(nearest[peaks] / coarse[peaks]), 1.001, widest))
    return float(np.sqrt(max(s2 - r**2 * s1, 0.0) / (r**2 - 1.0)))


def _measure_gradient(image: Image, sigma: float) -> NDArray[np.float32]:
    """Return the gradient's magnitude (H, W) in grey levels per px."""
    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), sigma)
    gx = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=3, scale=1 / 8)
    gy = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3, scale=1 / 8)
    return np.asarray(cv2.magnitude(gx, gy), dtype=np.float32)


def _find_far_above(blurs: FloatArray) -> list[int]:
    """Return indices of blurs far above the median of all; none where they are not a minority."""
    known = np.isfinite(blurs)
    if known.sum() <= LEAST_OTHERS:
        return []
    middle = float(np.median(blurs[known]))
    spread = float(np.median(np.abs(blurs[known] - middle))) / MEDIAN_OF_NORMAL
    limit = max(middle + OUTLIER_SDS * spread, MUCH * middle, 1.0)
    found = np.flatnonzero(known & (np.nan_to_num(blurs) > limit)).tolist()
    return found if len(blurs) - len(found) > LEAST_OTHERS else []


def _blurred(soft: Sequence[str], of: int, usual: float) -> str:
    which = "all" if len(soft) == of else f"{len(soft)} of"
    names = "" if len(soft) == of else f" ({named(soft)})"
    return (
        f"{which} {of} pictures are blurred by about {usual:.1f} px{names}: faces may be lost; "
        "focus the lens, and hold the camera still"
    )


def _explain_empty_views(views: Sequence[View], empty: dict[int, str]) -> str:
    faults = tuple(dict.fromkeys(empty.values()))
    kind = faults[0] if len(faults) == 1 else " or ".join(faults)
    which = (
        f"all {len(views)} pictures are"
        if len(empty) == len(views)
        else f"all but one of {len(views)} pictures are"
    )
    return (
        f"{which} {kind} ({named([views[k].name for k in empty])}): "
        "check the files, exposure and lens cap"
    )


def find_same_pictures(views: Sequence[View]) -> tuple[str, ...]:
    """Return a warning for each picture that several views with different poses have, pixel by
    pixel.

    The same picture at the same pose is no fault: together such views count as one.
    """
    alike: dict[tuple[tuple[int, ...], bytes], list[View]] = {}
    for view in views:
        pixels = hashlib.sha256(view.image.tobytes()).digest()
        alike.setdefault((view.image.shape, pixels), []).append(view)
    found = []
    for same in alike.values():
        poses = [view.pose for view in same]
        if any(
            not np.array_equal(a.rotation, b.rotation) or not np.array_equal(a.centre, b.centre)
            for a, b in pairwise(poses)
        ):
            names = named([view.name for view in same])
            which = f"all {len(views)} pictures ({names})" if len(same) == len(views) else names
            found.append(
                f"{which}: one and the same picture at different poses; "
                "give each pose its own, unless the thing looks the same from there"
            )
    return tuple(found)
