"""Views into a scene: a front end finds and tracks the faces, the filters give their geometry."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from facetlog.perception.detection.block_front_end.faces_of_block import block_front_end
from facetlog.perception.detection.line_front_end.faces_from_lines import line_front_end
from facetlog.perception.detection.picture_faults import usable_views
from facetlog.perception.detection.tracked_faces import TrackedFace, TrackedFaces
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.estimation.pose_refinement.agreement import in_agreement
from facetlog.perception.scene import Scene, Vertex
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.scene_from_tracks import assemble
from facetlog.perception.surfaces.sights import with_sights
from facetlog.perception.types import FloatArray, PoseErrors, View

__all__ = ["reconstruct"]

NO_FACE = (
    "no face was found in {count} views: a face needs straight edges that at least three views "
    "from different places show whole; eight or more views round the thing are a good start"
)
# With fewer vertices a view than this there is too little to ask whether the poses are wrong.
MIN_VERTICES = 2.0


def reconstruct(
    views: Sequence[View],
    *,
    name: str,
    up: FloatArray | None = None,
    metric: bool = False,
    errors: PoseErrors | None = None,
    front_end: str = "lines",
    sd_limit: float | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    clock: StepClock | None = None,
) -> Scene:
    """The scene that the views show; InconsistentViewsError if their poses contradict them.

    `front_end` is "lines" for things in general, or "paper" for one bright block on a darker
    ground. `sd_limit`, in the unit of the poses, ends the filter of a vertex once its largest
    standard deviation is below. `up` and `metric` are what is known of the world frame, `errors`
    are those that are stated of the views' poses. Pictures that show nothing are named and left
    out; InputError where too few are left. Observations are in pixels of the pictures as stored,
    freed of lens distortion.
    """
    clock = clock or StepClock()
    given = views
    with clock.step("pictures"):
        views, left_out = usable_views(given)
    if front_end == "lines":
        tracked = line_front_end(views, up, clock, progress, in_agreement)
    else:
        tracked = _paper_front_end(views, up, clock, progress)
    if tracked.used is not None:
        views = tuple(views[k] for k in tracked.used)
    if errors is not None:
        kept = {id(view) for view in views}
        errors = errors.of([k for k, view in enumerate(given) if id(view) in kept])
    with clock.step("vertices and planes"):
        scene = assemble(
            tracked, views, name=name, up=up, metric=metric, sd_limit=sd_limit, errors=errors
        )
    with clock.step("sights"):
        placed = [replace(v, pose=pose) for v, pose in zip(views, scene.poses, strict=True)]
        scene = with_sights(scene, placed, tracked.weight, tracked.ground)
    no_face = () if scene.faces else (NO_FACE.format(count=len(views)),)
    vertices = tuple(_in_stored_pixels(vertex, views) for vertex in scene.vertices)
    return replace(scene, vertices=vertices, warnings=(*left_out, *scene.warnings, *no_face))


def _in_stored_pixels(vertex: Vertex, views: Sequence[View]) -> Vertex:
    seen = tuple(o.resized(views[o.view].enlargement) for o in vertex.observations)
    return replace(vertex, observations=seen)


def _paper_front_end(
    views: Sequence[View],
    up: FloatArray | None,
    clock: StepClock,
    progress: Callable[[str, int, int], None] | None,
) -> TrackedFaces:
    def report(done: int, total: int) -> None:
        if progress is not None:
            progress("features", done, total)

    with clock.step("features and tracks"):
        block = block_front_end(tuple(views), up=up, progress=report)
    found = sum(map(len, block.vertices))
    if not block.tracks and found >= MIN_VERTICES * len(views):
        # Vertices that agree in no two views: wrong poses, or a round thing, whose outline is
        # another in each view. Its straight edges tell; this raises InconsistentViewsError.
        line_front_end(views, up, clock)
    weight = view_graph(views).weight
    return TrackedFaces(
        block.tracks,
        tuple(TrackedFace(outline) for outline in block.outlines),
        tuple(map(float, weight)),
        warnings=block.warnings,
    )
