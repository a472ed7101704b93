"""Duplicate pictures with different poses, of which at most one can be right.

Noise makes any two photographs differ, if only in a few pixels. Pictures rendered without noise may
be equal where the thing looks the same from several sides: so they are named, and all stay.
"""

import hashlib
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from facetlog.perception.name_lists import named
from facetlog.perception.types import View

__all__ = ["same_pictures"]


def same_pictures(views: Sequence[View]) -> tuple[str, ...]:
    """A warning for each picture that several views with different poses have, pixel by pixel.

    The same picture at the same pose is no fault: together such views count as one.
    """
    alike: dict[tuple[tuple[int, ...], bytes], list[View]] = {}
    for view in views:
        pixels = hashlib.sha256(view.image.tobytes()).digest()
        alike.setdefault((view.image.shape, pixels), []).append(view)
    return tuple(
        f"{_which(same, len(views))}: one and the same picture at different poses; "
        "give each pose its own, unless the thing looks the same from there"
        for same in alike.values()
        if any(not _same_pose(a, b) for a, b in pairwise(same))
    )


def _which(same: Sequence[View], of: int) -> str:
    names = named([view.name for view in same])
    return f"all {of} pictures ({names})" if len(same) == of else names


def _same_pose(a: View, b: View) -> bool:
    return np.array_equal(a.pose.rotation, b.pose.rotation) and np.array_equal(
        a.pose.centre, b.pose.centre
    )
