"""Tracked faces into a scene: geometry first, then what each view saw of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from facetlog.perception.detection.tracked_faces import TrackedFaces
from facetlog.perception.scene import Scene, Vertex
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.scene_from_tracks import Assembled, assemble
from facetlog.perception.surfaces.seeing.sights import with_sights
from facetlog.perception.surfaces.view_directions import looking_apart, one_direction
from facetlog.perception.types import FloatArray, PoseErrors, View

__all__ = ["SceneOfFaces", "scene_of_faces"]

NO_FACE = (
    "no face was found in {count} views: a face needs straight edges that at least three views "
    "from different places show whole; eight or more views round the thing are a good start. If "
    "these show such edges, check poses and focal length: far off, nothing agrees"
)


@dataclass(frozen=True, eq=False, slots=True)
class SceneOfFaces:
    """The geometry of tracked faces, and the views it was found in: they agree with one another.

    `used` are these views (indices) of all that were given, `views` the same at the poses of the
    scene.
    """

    assembled: Assembled
    tracked: TrackedFaces
    used: tuple[int, ...]
    views: tuple[View, ...]

    def seen(self, scene: Scene, clock: StepClock) -> Scene:
        """The scene, `assembled.scene` or what became of it, with what each view saw of it."""
        tracked = self.tracked
        with clock.step("sights"):
            return with_sights(scene, self.views, tracked.weight, tracked.ground, tracked.landmarks)

    def complete(self, scene: Scene, clock: StepClock) -> Scene:
        """The scene as `seen`, observations in pixels of the pictures as stored, and what is to be
        said of the views.
        """
        scene = self.seen(scene, clock)
        corners = sorted({k for face in scene.faces for k in face.outline})
        said = one_direction(self.views, scene.points[corners])
        if not scene.faces:
            said = (*said, *looking_apart(self.views), NO_FACE.format(count=len(self.views)))
        vertices = tuple(_in_stored_pixels(vertex, self.views) for vertex in scene.vertices)
        return replace(scene, vertices=vertices, warnings=(*scene.warnings, *said))


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
) -> SceneOfFaces:
    """What `assemble` makes of the tracked faces of the views that agree.

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
    placed = tuple(replace(v, pose=p) for v, p in zip(used, found.scene.poses, strict=True))
    return SceneOfFaces(found, tracked, chosen, placed)


def _in_stored_pixels(vertex: Vertex, views: Sequence[View]) -> Vertex:
    seen = tuple(o.resized(views[o.view].enlargement) for o in vertex.observations)
    return replace(vertex, observations=seen)
