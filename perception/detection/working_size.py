"""Small pictures enlarged: what segments, masks and merging need is a number of pixels."""

from collections.abc import Sequence

import cv2
import numpy as np

from facetlog.perception.types import Camera, Observation, Track, View

__all__ = ["at_working_size", "in_own_pixels"]

# The distances in pixels of this front end suit pictures with a diagonal of 600 px and more. The
# cube of 100 px in 640 x 480 is lost at half that size and found again when it is doubled.
MIN_DIAGONAL_PX = 600.0
# More only spreads the blur.
MAX_FACTOR = 4


def at_working_size(views: Sequence[View]) -> tuple[tuple[View, ...], int]:
    """The views, all enlarged by the same factor (1, 2 or 4), and the factor."""
    diagonal = float(np.median([np.hypot(*v.image.shape) for v in views]))
    factor = 1
    while factor < MAX_FACTOR and factor * diagonal < MIN_DIAGONAL_PX:
        factor *= 2
    return tuple(views) if factor == 1 else tuple(_enlarged(v, factor) for v in views), factor


def _enlarged(view: View, factor: int) -> View:
    image = cv2.resize(view.image, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
    c = view.camera
    # Pixel centres: u' + 1/2 = factor · (u + 1/2).
    camera = Camera(
        image.shape[1],
        image.shape[0],
        c.fx * factor,
        c.fy * factor,
        (c.cx + 0.5) * factor - 0.5,
        (c.cy + 0.5) * factor - 0.5,
    )
    return View(view.name, np.asarray(image, dtype=np.uint8), camera, view.pose)


def in_own_pixels(track: Track, factor: int) -> Track:
    """A track of the enlarged views in the pixels of the views themselves."""
    if factor == 1:
        return track
    seen = (
        Observation(o.view, (o.uv + 0.5) / factor - 0.5, o.cov / factor**2)
        for o in track.observations
    )
    return Track(tuple(seen), track.label)
