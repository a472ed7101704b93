"""Views in groups that look at one place each, so that a room is reconstructed thing by thing.

The views of another thing show hardly anything of this one, and views of all together take longer
than the same views apart, by the square of their number. A robot looks at one thing after the
other: each view goes on with the place that the ones before it look at, if that is in the middle
part of its picture, or else begins a new place. Places that are near each other are one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray, Pose

__all__ = ["view_groups"]

# An optical axis that passes a place by this share of its distance has it in the middle 30 degrees
# of the picture, and so has another view two places that are as near to one another.
MIDDLE_SHARE = 0.25
# Of views that look at no place together, as when a robot looks about, there is one group.
MOST_ALONE = 0.5


@dataclass(eq=False, slots=True)
class _Place:
    """Views (indices) and the place (3,) that their axes pass, None of a single view."""

    views: list[int] = field(default_factory=list)
    point: FloatArray | None = None


def view_groups(poses: Sequence[Pose]) -> tuple[tuple[int, ...], ...]:
    """The views (indices, ascending) of each group, in the order in which they begin.

    Views that fit nowhere go with those before them; a group has as many as a face needs.
    """
    places: list[_Place] = []
    for index in range(len(poses)):
        if places and (point := _going_on(places[-1], index, poses)) is not None:
            places[-1].views.append(index)
            places[-1].point = point
        else:
            places.append(_Place([index]))
    groups = _together(places, poses)
    large = [group for group in groups if len(group) >= FEWEST_VIEWS]
    alone = len(poses) - sum(map(len, large))
    if not large or alone > MOST_ALONE * len(poses):
        return (tuple(range(len(poses))),) if len(poses) else ()
    for group in groups:
        if len(group) < FEWEST_VIEWS:
            for index in group:
                nearest = min(large, key=lambda own: min(abs(index - k) for k in own))
                nearest.append(index)
    return tuple(tuple(sorted(group)) for group in sorted(large))


def _going_on(place: _Place, index: int, poses: Sequence[Pose]) -> FloatArray | None:
    """The place with one more view, if it is in the middle part of the pictures of all of them."""
    views = [*place.views, index]
    point = _crossing([poses[k] for k in views])
    if point is None:
        return None
    return point if all(_is_middle(poses[k], point) for k in views) else None


def _crossing(poses: Sequence[Pose]) -> FloatArray | None:
    """The point (3,) nearest to the optical axes, by least squares; None if they are parallel.

    Σ (I - d dᵀ) (p - c) = 0
    """
    axes = np.array([pose.rotation[:, 2] for pose in poses])
    centres = np.array([pose.centre for pose in poses])
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    matrix = across.sum(axis=0)
    if np.linalg.cond(matrix) > 1.0 / MIDDLE_SHARE**4:
        return None
    found: FloatArray = np.linalg.solve(matrix, np.einsum("nij,nj->i", across, centres))
    return found


def _is_middle(pose: Pose, point: FloatArray) -> bool:
    """Whether a point is ahead, in the middle part of the picture."""
    x, y, z = pose.rotation.T @ (point - pose.centre)
    return bool(z > 0 and np.hypot(x, y) <= MIDDLE_SHARE * z)


def _together(places: Sequence[_Place], poses: Sequence[Pose]) -> list[list[int]]:
    """The views of places, of which those that are near one another are one."""
    groups: list[tuple[list[int], FloatArray | None]] = []
    for place in places:
        for views, point in groups:
            if point is None or place.point is None:
                continue
            both = [*views, *place.views]
            away = min(float(np.linalg.norm(poses[k].centre - point)) for k in both)
            if float(np.linalg.norm(point - place.point)) <= MIDDLE_SHARE * away:
                views.extend(place.views)
                break
        else:
            groups.append((list(place.views), place.point))
    return [views for views, _ in groups]
