"""Small pictures enlarged: segments, masks and merging need a certain number of pixels.

An enlarged picture is smooth between the pixels of the small one, and its noise would be
underestimated ten times. So its noise is taken from the small one.
"""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from facetlog.perception.detection.picture_noise import Noise, measure_working_noise
from facetlog.perception.types import FloatArray, Track, View

# The distances in pixels of this front end suit pictures with a diagonal of 600 px and more. The
# cube of 100 px in 640 x 480 is lost at half that size and found again when it is doubled.
MIN_DIAGONAL_PX = 600.0
# More only spreads the blur.
MAX_FACTOR = 4


def enlarge_to_working_size(views: Sequence[View]) -> tuple[tuple[View, ...], tuple[int, ...]]:
    """Return the views, each enlarged by a factor of its own (1, 2 or 4), and the factors."""
    enlarged, factors = [], []
    for view in views:
        factor = 1
        while factor < MAX_FACTOR and factor * np.hypot(*view.image.shape) < MIN_DIAGONAL_PX:
            factor *= 2
        factors.append(factor)
        if factor > 1:
            image = cv2.resize(
                view.image, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC
            )
            camera = view.camera.resized(image.shape[1], image.shape[0])
            view = View(view.name, np.asarray(image, dtype=np.uint8), camera, view.pose)
        enlarged.append(view)
    return tuple(enlarged), tuple(factors)


def measure_working_noises(views: Sequence[View], factors: Sequence[int]) -> tuple[Noise, ...]:
    """Return the noise of views that were enlarged by such factors, from the views as they were."""
    pairs = zip(views, factors, strict=True)
    return tuple(
        replace(measure_working_noise(view.image), factor=factor) for view, factor in pairs
    )


def to_own_pixels(track: Track, factors: Sequence[int]) -> Track:
    """Return a track of the enlarged views in the pixels of the views themselves."""
    shares: list[FloatArray] = [np.full(2, 1.0 / factor) for factor in factors]
    return Track(tuple(o.resized(shares[o.view]) for o in track.observations), track.label)
