"""Tracked faces into a scene: geometry first, then what each view saw of it."""

from collections.abc import Sequence
from dataclasses import replace

from facetlog.perception.detection.tracked_faces import TrackedFaces
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.scene_from_tracks import Assembled, assemble
from facetlog.perception.surfaces.sights import with_sights
from facetlog.perception.types import FloatArray, PoseErrors, View

__all__ = ["scene_of_faces"]


def scene_of_faces(
    tracked: TrackedFaces,
    views: Sequence[View],
    *,
    name: str,
    up: FloatArray | None,
    metric: bool,
    clock: StepClock,
    sd_limit: float | None = None,
    errors: PoseErrors | None = None,
    lens_is_off: bool = False,
) -> tuple[Assembled, tuple[int, ...]]:
    """What `assemble` makes of the tracked faces of the views, with the scene's sights, and the
    views (indices) that it was found in: they agree with one another.

    `errors` are those of all the views; the other arguments are as in `assemble`.
    """
    chosen = tuple(range(len(views))) if tracked.used is None else tracked.used
    used = [views[k] for k in chosen]
    with clock.step("vertices and planes"):
        found = assemble(
            tracked,
            used,
            name=name,
            up=up,
            metric=metric,
            sd_limit=sd_limit,
            errors=None if errors is None else errors.of(chosen),
            lens_is_off=lens_is_off,
        )
    with clock.step("sights"):
        poses = found.scene.poses
        placed = [replace(v, pose=pose) for v, pose in zip(used, poses, strict=True)]
        scene = with_sights(found.scene, placed, tracked.weight, tracked.ground, tracked.landmarks)
    return replace(found, scene=scene), chosen
