"""Views into a scene: a front end finds and tracks the faces, the filters give their geometry."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from facetlog.errors import InconsistentViewsError
from facetlog.perception.detection.line_front_end.faces_from_lines import line_front_end
from facetlog.perception.detection.line_front_end.planes.level_direction import held_up
from facetlog.perception.detection.picture_faults import find_same_pictures, select_usable_views
from facetlog.perception.detection.tracked_faces import TrackedFace, TrackedFaces
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.estimation.lens_correction import (
    combine_lens_errors,
    corrected,
    explain_lens_errors,
)
from facetlog.perception.scene import Scene, Vertex
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.scene_from_tracks import Assembled, Stated, assemble
from facetlog.perception.surfaces.seeing.sights import add_sights
from facetlog.perception.types import Camera, FloatArray, LensError, PoseErrors, View

AS_STATED = LensError(1.0, 0.0, 0.0, 0.0)
LENS_PASSES = 3
# A focal length so little off, as a share, shows faces where they are: by a pixel at most.
NEAR_FOCAL = 0.005

UP_OF_GROUND = (
    "up is not stated: it is that of the ground, found by what is level and how the cameras were "
    "held; state up (an axis, or none) if that is not so"
)

NO_FACE = (
    "no face was found in {count} views: a face needs straight edges that at least three views "
    "from different places show whole; eight or more views round the thing are a good start. If "
    "these show such edges, check poses and focal length: far off, nothing agrees"
)

LEAST_ANGLE = np.radians(8.0)
"""On some hundred ways straight towards a rendered block or past it, 16 views each, corners came up
to 240 mm off where most are seen under less than 7 degrees, 11 mm at 7 to 9, 3 mm beyond."""

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
    """Return the scene that the views show; InconsistentViewsError if their poses contradict them.

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
    stated = Stated(name, up, metric, sd_limit, errors)
    method = _Method(stated, find_up, front_end, progress, clock or StepClock())
    with method.clock.step("pictures"):
        usable, left_out = select_usable_views(views)
        of_pictures = (*left_out, *find_same_pictures(usable))
    if errors is not None:
        kept = {id(view) for view in usable}
        errors = errors.of([k for k, view in enumerate(views) if id(view) in kept])
        method = replace(method, stated=replace(stated, errors=errors))
    try:
        found = _seen(usable, method)
        scene = found.assembled.scene
        if scene.lenses:
            found, scene = _reconstruct_with_lenses(found, usable, method)
    except InconsistentViewsError as exc:
        # What is wrong with pictures or places may be why they contradict one another.
        causes = (*of_pictures, *warn_of_one_direction(usable), *warn_of_outward_views(usable))
        raise InconsistentViewsError("; ".join((*causes, str(exc)))) from exc
    scene = found.complete(scene, method.clock)
    if metric and errors is not None:
        scene = replace(scene, scale_sd=errors.scale_sd)
    of_up = (UP_OF_GROUND,) if up is None and scene.up is not None else ()
    return replace(scene, warnings=(*of_pictures, *of_up, *scene.warnings))


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
        """Return the scene, `assembled.scene` or what became of it, with what each view saw of
        it.
        """
        tracked = self.tracked
        with clock.step("sights"):
            return add_sights(scene, self.views, tracked.weight, tracked.ground, tracked.landmarks)

    def complete(self, scene: Scene, clock: StepClock) -> Scene:
        """Return the scene as `seen`, observations in pixels of the pictures as stored, and what is
        to be said of the views.
        """
        scene = self.seen(scene, clock)
        corners = sorted({k for face in scene.faces for k in face.outline})
        said = warn_of_one_direction(self.views, scene.points[corners])
        if not scene.faces:
            said = (
                *said,
                *warn_of_outward_views(self.views),
                NO_FACE.format(count=len(self.views)),
            )
        vertices = tuple(_to_stored_pixels(vertex, self.views) for vertex in scene.vertices)
        return replace(scene, vertices=vertices, warnings=(*scene.warnings, *said))


def make_scene_of_faces(
    tracked: TrackedFaces, views: Sequence[View], stated: Stated, clock: StepClock
) -> SceneOfFaces:
    """Return what `assemble` makes of the tracked faces of the views that agree.

    The errors that are stated are those of all the views.
    """
    chosen = tuple(range(len(views))) if tracked.used is None else tracked.used
    used = [views[k] for k in chosen]
    if stated.errors is not None:
        stated = replace(stated, errors=stated.errors.of(chosen))
    with clock.step("vertices and planes"):
        found = assemble(tracked, used, stated)
    placed = tuple(replace(v, pose=p) for v, p in zip(used, found.scene.poses, strict=True))
    return SceneOfFaces(found, tracked, chosen, placed)


def _to_stored_pixels(vertex: Vertex, views: Sequence[View]) -> Vertex:
    seen = tuple(o.resized(views[o.view].enlargement) for o in vertex.observations)
    return replace(vertex, observations=seen)


@dataclass(frozen=True, eq=False, slots=True)
class _Method:
    # As of `reconstruct`.
    stated: Stated
    find_up: bool
    front_end: str
    progress: Progress | None
    clock: StepClock


def _seen(views: Sequence[View], method: _Method) -> SceneOfFaces:
    stated, clock = method.stated, method.clock
    up = stated.up
    if method.front_end == "lines":
        tracked = line_front_end(views, up, clock, method.progress)
    else:
        tracked = _run_paper_front_end(views, method)
    if up is None and method.find_up and tracked.ground is not None:
        up = tracked.ground[0] if held_up(views, tracked.ground[0]) else None
    return make_scene_of_faces(tracked, views, replace(stated, up=up), clock)


def _reconstruct_with_lenses(
    seen: SceneOfFaces, views: Sequence[View], method: _Method
) -> tuple[SceneOfFaces, Scene]:
    """Return the scene of views corrected by what their lenses were found to be off by.

    Through a lens that is not as stated faces are seen in part, and in wrong places: what is far
    off is found in steps.
    """
    method = replace(method, stated=replace(method.stated, lens_is_off=True))
    known: dict[Camera, LensError] = {}
    for _ in range(LENS_PASSES):
        known |= _add_lens_errors(known, seen, views)
        better = [corrected(v, known.get(v.camera, AS_STATED)) for v in views]
        seen = _seen(better, method)
        if all(abs(lens.focal - 1.0) < NEAR_FOCAL for lens in seen.assembled.scene.lenses):
            break
    found = known | _add_lens_errors(known, seen, views)
    used = [views[k] for k in seen.used]
    said = explain_lens_errors(used, [found.get(view.camera, AS_STATED) for view in used])
    lenses = tuple(known.get(view.camera, AS_STATED) for view in used)
    scene = seen.assembled.scene
    return seen, replace(scene, lenses=lenses, warnings=(*said, *scene.warnings))


def _add_lens_errors(
    known: Mapping[Camera, LensError], seen: SceneOfFaces, views: Sequence[View]
) -> dict[Camera, LensError]:
    # What the lenses of a scene's cameras are off by, known before and found beyond that.
    lenses = seen.assembled.scene.lenses
    beyond = {views[k].camera: e for k, e in zip(seen.used, lenses, strict=False)}
    return {c: combine_lens_errors(known[c], e) if c in known else e for c, e in beyond.items()}


def _run_paper_front_end(views: Sequence[View], method: _Method) -> TrackedFaces:
    # Not at the top: it needs parts of scipy that take longer to load than a small set to be seen.
    from facetlog.perception.detection.block_front_end.faces_of_block import block_front_end

    up, clock = method.stated.up, method.clock

    def report(done: int, total: int) -> None:
        if method.progress is not None:
            method.progress("features", done, total)

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


def warn_of_one_direction(
    views: Sequence[View], corners: FloatArray | None = None
) -> tuple[str, ...]:
    """Return a warning where all views see most corners of faces (n, 3) from one direction.

    Without a corner the point that the views look at stands for them.
    """
    points = view_graph(views).focus[None] if corners is None or not len(corners) else corners
    angle = float(
        np.median(_compute_widest_angles(points, np.array([v.pose.centre for v in views])))
    )
    if not angle < LEAST_ANGLE:
        return ()
    return (
        f"the cameras look from one direction, within {np.degrees(angle):.0f} degrees: depth is "
        "hardly known, and faces may be far off; take views from different sides",
    )


def warn_of_outward_views(views: Sequence[View]) -> tuple[str, ...]:
    """Return a line where most cameras have the point behind them that their axes pass nearest to.

    Such cameras may see a room; no thing that stands between them.
    """
    focus = view_graph(views).focus
    ahead = [(focus - v.pose.centre) @ v.pose.rotation[:, 2] > 0 for v in views]
    if 2 * sum(ahead) > len(ahead):
        return ()
    return (
        "the cameras look away from one another: place them round the thing, turned towards it, "
        "or check which way the axes of their poses point",
    )


def _compute_widest_angles(points: FloatArray, centres: FloatArray) -> FloatArray:
    # The angle (n,) between the rays to each point (n, 3) that are farthest apart: from the first
    # ray to the one farthest from it, and from there again. At least half of the widest, and all
    # of it for cameras on a line or an arc.
    rays = points[:, None] - centres
    rays /= np.maximum(np.linalg.norm(rays, axis=-1, keepdims=True), np.finfo(float).tiny)
    from_ = rays[:, 0]
    for _ in range(2):
        apart = np.linalg.norm(rays - from_[:, None], axis=-1)
        from_ = rays[np.arange(len(rays)), apart.argmax(axis=1)]
    # The chord between unit vectors.
    return np.asarray(2.0 * np.arcsin(np.minimum(apart.max(axis=1) / 2.0, 1.0)))
