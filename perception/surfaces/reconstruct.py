"""Views into a scene: a front end finds and tracks the faces, the filters give their geometry."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from facetlog.errors import InconsistentViewsError
from facetlog.perception.detection.line_front_end.faces_from_lines import line_front_end
from facetlog.perception.detection.line_front_end.planes.level_direction import held_up
from facetlog.perception.detection.picture_faults import same_pictures, usable_views
from facetlog.perception.detection.tracked_faces import TrackedFace, TrackedFaces
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.estimation.lens_correction import (
    combined,
    corrected,
    lens_warnings,
)
from facetlog.perception.scene import Scene
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.scene_of_faces import SceneOfFaces, scene_of_faces
from facetlog.perception.surfaces.view_directions import looking_apart, one_direction
from facetlog.perception.types import Camera, FloatArray, LensError, PoseErrors, View

__all__ = ["reconstruct"]

AS_STATED = LensError(1.0, 0.0, 0.0, 0.0)
LENS_PASSES = 3
# A focal length so little off, as a share, shows faces where they are: by a pixel at most.
NEAR_FOCAL = 0.005

UP_OF_GROUND = (
    "up is not stated: it is that of the ground, found by what is level and how the cameras were "
    "held; state up (an axis, or none) if that is not so"
)

Progress: TypeAlias = Callable[[str, int, int], None]

# With fewer vertices a view than this there is too little to ask whether the poses are wrong.
MIN_VERTICES = 2.0


def reconstruct(
    views: Sequence[View],
    *,
    name: str,
    up: FloatArray | None = None,
    metric: bool = False,
    errors: PoseErrors | None = None,
    find_up: bool = True,
    front_end: str = "lines",
    sd_limit: float | None = None,
    progress: Progress | None = None,
    clock: StepClock | None = None,
) -> Scene:
    """The scene that the views show; InconsistentViewsError if their poses contradict them.

    `front_end` is "lines" for things in general, or "paper" for one bright block on a darker
    ground. `sd_limit`, in the unit of the poses, ends the filter of a vertex once its largest
    standard deviation is below. `up` and `metric` are what is known of the world frame, `errors`
    are those that are stated of the views' poses; that of a metric world's unit is the scene's
    `scale_sd`. Pictures that show nothing are named and left
    out; InputError where too few are left. Observations are in pixels of the pictures as stored,
    freed of lens distortion. Lenses that the pictures show to be other than stated are corrected by
    what they show, with a warning. Where `up` is not known it is that of the ground, if there is
    one and the cameras were held upright over it, with a warning, too; without `find_up` it stays
    unknown.
    """
    method = _Method(name, up, metric, find_up, front_end, sd_limit, progress, clock or StepClock())
    with method.clock.step("pictures"):
        usable, left_out = usable_views(views)
        of_pictures = (*left_out, *same_pictures(usable))
    if errors is not None:
        kept = {id(view) for view in usable}
        errors = errors.of([k for k, view in enumerate(views) if id(view) in kept])
    try:
        found = _seen(usable, errors, method)
        scene = found.assembled.scene
        if scene.lenses:
            found, scene = _seen_anew(found, usable, errors, method)
    except InconsistentViewsError as exc:
        # What is wrong with pictures or places may be why they contradict one another.
        causes = (*of_pictures, *one_direction(usable), *looking_apart(usable))
        raise InconsistentViewsError("; ".join((*causes, str(exc)))) from exc
    scene = found.complete(scene, method.clock)
    if metric and errors is not None:
        scene = replace(scene, scale_sd=errors.scale_sd)
    of_up = (UP_OF_GROUND,) if up is None and scene.up is not None else ()
    return replace(scene, warnings=(*of_pictures, *of_up, *scene.warnings))


@dataclass(frozen=True, eq=False, slots=True)
class _Method:
    # As of `reconstruct`.
    name: str
    up: FloatArray | None
    metric: bool
    find_up: bool
    front_end: str
    sd_limit: float | None
    progress: Progress | None
    clock: StepClock


def _seen(
    views: Sequence[View], errors: PoseErrors | None, method: _Method, *, lens_is_off: bool = False
) -> SceneOfFaces:
    up, clock = method.up, method.clock
    if method.front_end == "lines":
        tracked = line_front_end(views, up, clock, method.progress)
    else:
        tracked = _paper_front_end(views, up, clock, method.progress)
    if up is None and method.find_up and tracked.ground is not None:
        up = tracked.ground[0] if held_up(views, tracked.ground[0]) else None
    return scene_of_faces(
        tracked,
        views,
        name=method.name,
        up=up,
        metric=method.metric,
        clock=clock,
        sd_limit=method.sd_limit,
        errors=errors,
        lens_is_off=lens_is_off,
    )


def _seen_anew(
    seen: SceneOfFaces,
    views: Sequence[View],
    errors: PoseErrors | None,
    method: _Method,
) -> tuple[SceneOfFaces, Scene]:
    """The same from views corrected by what their lenses were found to be off by.

    Through a lens that is not as stated faces are seen in part, and in wrong places: what is far
    off is found in steps.
    """
    known: dict[Camera, LensError] = {}
    for _ in range(LENS_PASSES):
        known |= _totals(known, seen, views)
        better = [corrected(v, known.get(v.camera, AS_STATED)) for v in views]
        seen = _seen(better, errors, method, lens_is_off=True)
        if all(abs(lens.focal - 1.0) < NEAR_FOCAL for lens in seen.assembled.scene.lenses):
            break
    found = known | _totals(known, seen, views)
    used = [views[k] for k in seen.used]
    said = lens_warnings(used, [found.get(view.camera, AS_STATED) for view in used])
    lenses = tuple(known.get(view.camera, AS_STATED) for view in used)
    scene = seen.assembled.scene
    return seen, replace(scene, lenses=lenses, warnings=(*said, *scene.warnings))


def _totals(
    known: Mapping[Camera, LensError], seen: SceneOfFaces, views: Sequence[View]
) -> dict[Camera, LensError]:
    # What the lenses of a scene's cameras are off by, known before and found beyond that.
    lenses = seen.assembled.scene.lenses
    beyond = {views[k].camera: e for k, e in zip(seen.used, lenses, strict=False)}
    return {c: combined(known[c], e) if c in known else e for c, e in beyond.items()}


def _paper_front_end(
    views: Sequence[View],
    up: FloatArray | None,
    clock: StepClock,
    progress: Progress | None,
) -> TrackedFaces:
    # Not at the top: it needs parts of scipy that take longer to load than a small set to be seen.
    from facetlog.perception.detection.block_front_end.faces_of_block import block_front_end

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
