"""The pipeline: views, scene, facts, verdicts, each step timed.

    views → features → tracks → vertices → faces → facts → models → verdicts

Packages are imported where they are used: `--help` does not load them.
"""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from facetlog.errors import InputError
from facetlog.perception.step_clock import StepClock

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.perception.facts.known_length import KnownLength, Scale
    from facetlog.perception.length_units import Length
    from facetlog.perception.reading.read_views import ViewSet
    from facetlog.perception.scene import Scene
    from facetlog.perception.types import FloatArray, View

__all__ = [
    "DEMO_WORLD",
    "FrontEnd",
    "Progress",
    "Recognised",
    "apply_known_scale",
    "apply_stated_up",
    "check_up",
    "facts_of",
    "load_scene",
    "open_models",
    "read_views_from",
    "recognize_views",
    "reconstruct_views",
    "render_simulated_views",
    "write_scene_file",
]

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called with the step's name, how much of it is done, and of how much."""

Up: TypeAlias = "str | FloatArray | None"
"""Upwards, as `apply_stated_up` takes it."""

FlatFact: TypeAlias = tuple[str | int | float, ...]
"""A functor and its arguments."""

DEMO_WORLD = "block"


class FrontEnd(StrEnum):
    """How pictures become features: straight lines in general, or the paper's bright block."""

    LINES = "lines"
    PAPER = "paper"


@dataclass(frozen=True, slots=True)
class Method:
    """How views become a scene; `sd_limit` in metres (or units) is the filter's stopping rule,
    `scale` a length that is known in it."""

    front_end: FrontEnd = FrontEnd.LINES
    sd_limit: float | None = None
    scale: "KnownLength | None" = None


DEFAULT_METHOD = Method()


@dataclass(frozen=True, eq=False, slots=True)
class Recognised:
    """Everything that a run found, from the views to the verdicts; `scale` by a known length."""

    view_set: "ViewSet"
    scene: "Scene"
    facts: tuple[FlatFact, ...]
    recognition: "Recognition"
    clock: StepClock = field(default_factory=StepClock)
    scale: "Scale | None" = None

    @property
    def placed_views(self) -> "tuple[View, ...]":
        """Return the views with the poses and lenses with which a scene was found; as given where
        it has none.
        """
        return placed_views(self.view_set, self.scene)


def placed_views(view_set: "ViewSet", scene: "Scene") -> "tuple[View, ...]":
    """Return the views with the poses and lenses of a scene; as given where it has none."""
    from facetlog.perception.estimation.lens_correction import corrected

    poses = dict(zip(scene.views, scene.poses, strict=False))
    lenses = dict(zip(scene.views, scene.lenses, strict=False))
    placed = [replace(v, pose=poses.get(v.name, v.pose)) for v in view_set.views]
    return tuple(corrected(v, lenses[v.name]) if v.name in lenses else v for v in placed)


def read_views_from(
    path: Path,
    *,
    unit: str | None,
    up: Up = None,
    square: "Length | None" = None,
    keep: Path | None = None,
    trusted: bool = False,
    keep_poses: bool = False,
    progress: Progress | None,
    clock: StepClock,
) -> "ViewSet":
    """Read the views of a folder or poses file (see perception/reading/read_views.py).

    Poses that were counted up, with their covariances, are corrected by the pictures, unless they
    are to be kept. `up` is as in `apply_stated_up`; `square` is the side of a mat's squares if
    it was printed at another scale; `keep` is a folder for cameras that structure from motion
    finds.
    """
    from facetlog.perception.reading.read_views import read_views

    axis = _is_axis(up)
    _check_not_written(path)
    with clock.step("read pictures"):
        view_set = read_views(
            path,
            unit=unit,
            square=square,
            axis=axis,
            keep=keep,
            trusted=trusted,
            progress=progress,
        )
    view_set = apply_stated_up(view_set, up)
    if keep_poses or view_set.pose_errors is None:
        return view_set
    from facetlog.perception.estimation.pose_refinement.refine_poses import correct_poses

    with clock.step("poses"):
        return correct_poses(view_set, progress)


def holds_shape(path: Path) -> bool:
    """Return whether a path is a scene, mesh or cloud or the folder of one, and not pictures."""
    from facetlog.perception.reading.pose_files.register import has_only_pictures, has_poses
    from facetlog.query_shell.scene_files import SCENE_FILE, is_raw_shape

    if path.is_dir():
        written = (path / SCENE_FILE).is_file()
        if written and has_only_pictures(path):  # those show what was found
            return True
        return (written or is_raw_shape(path)) and not has_poses(path)
    return path.is_file() and _is_measured(path)


def _check_not_written(path: Path) -> None:
    """Raise InputError for a folder of results, whose pictures only show what was found, and for a
    file that is a scene, mesh or cloud already.
    """
    from facetlog.output_folder import list_written_files
    from facetlog.perception.reading.pose_files.register import has_only_pictures
    from facetlog.query_shell.scene_files import SCENE_FILE

    if path.is_file() and _is_measured(path):
        raise InputError(
            f"{path} is measured already, no poses of pictures: facetlog recognize {path} says "
            f"what it is, facetlog why {path} MODEL why"
        )
    if SCENE_FILE in list_written_files(path) and has_only_pictures(path):
        raise InputError(
            f"{path} is what a run wrote (-o), and its pictures show what was found: ask its scene "
            f"(facetlog recognize {path / SCENE_FILE}, facetlog query {path / SCENE_FILE}), or "
            "give the folder of the pictures it was made from"
        )


def _is_measured(path: Path) -> bool:
    """Return whether a file is a scene by its schema, or a mesh or cloud by its suffix."""
    from facetlog.perception.reading.pose_files.file_values import read_json
    from facetlog.perception.reading.pose_files.register import has_poses
    from facetlog.perception.shapes.shape_options import find_shape_files, is_scene_file

    if not is_scene_file(path.name):
        return bool(find_shape_files((path.name,))) and not has_poses(path)
    try:
        document = read_json(path)
    except InputError:  # who reads it for poses says what is wrong
        return False
    return isinstance(document, dict) and str(document.get("schema")).startswith("facetlog-scene/")


def check_up(up: Up) -> None:
    """Raise InputError for a word that names no direction: to be called before any long work."""
    _is_axis(up)


def _is_axis(up: Up) -> bool:
    """Return whether up is stated by the axes of the poses' world."""
    from facetlog.perception.shapes.shape_options import parse_up

    return up is not None and (not isinstance(up, str) or parse_up(up) is not None)


def apply_stated_up(view_set: "ViewSet", up: Up) -> "ViewSet":
    """Return the views with the stated up: a unit vector (3,), or an axis by a word, as "-y"; as
    the file says, or else that of the ground (`auto`, None); or unknown (`none`). Raise InputError
    for another word.
    """
    import numpy as np

    from facetlog.perception.shapes.shape_options import NOT_GIVEN, parse_up

    if isinstance(up, str) and up == NOT_GIVEN:
        return replace(view_set, up=None, find_up=False)
    axis = parse_up(up) if isinstance(up, str) else up
    return view_set if axis is None else replace(view_set, up=np.array(axis))


def render_simulated_views(
    world: str, seed: int, *, progress: Progress | None, clock: StepClock
) -> "ViewSet":
    """Render the paper's tour of 24 views through a simulated world, in metres; InputError lists
    the worlds.

    The world's noise, floor, light and place follow from the seed.
    """
    import numpy as np

    from facetlog.perception.reading.read_views import ViewSet
    from facetlog.perception.types import Pose, View
    from facetlog.robot.rendering.views import views_of
    from facetlog.robot.rendering.worlds import INCH, WORLDS, make_world
    from facetlog.robot.tour import tour_camera, tour_poses

    if world not in WORLDS:
        raise InputError(f"there is no world {world!r}: use one of {', '.join(WORLDS)}")
    if seed < 0:
        raise InputError(f"the seed is {seed}: give a whole number from 0")
    poses = tour_poses()
    with clock.step("render pictures"):
        if progress is not None:
            progress("pictures", 0, len(poses))
        made = make_world(world, seed)
        in_inches = views_of(made, poses, tour_camera(), seed=seed)
        if progress is not None:
            progress("pictures", len(poses), len(poses))
    # Furniture is rendered at the size of the block; its lengths are those of the real thing.
    metres = INCH * made.model_scale
    views: tuple[View, ...] = tuple(
        View(v.name, v.image, v.camera, Pose(v.pose.rotation, v.pose.centre * metres))
        for v in in_inches
    )
    up = np.array([0.0, 0.0, 1.0])  # the z axis of simulated worlds and of the paper's tour
    return ViewSet(f"{world}-{seed}", views, up=up, metric=True)


def open_models(
    model_paths: tuple[Path, ...] = (),
    *,
    trusted: bool = False,
    crisp: bool = False,
    raw: bool = False,
) -> "KnowledgeBase":
    """Open a knowledge base with the built-in models and the user's; a crisp one has no degrees, a
    raw one no confidences.

    Raise InputError for models that cannot be used, EngineError without an engine: to be called
    before any long work, all of which would be lost.
    """
    from facetlog.kb.recognize import open_knowledge_base

    for path in model_paths:
        if not path.exists():
            raise InputError(f"{path} does not exist: give a model file or a folder of them")
    return open_knowledge_base(model_paths, trusted=trusted, crisp=crisp, raw=raw)


def reconstruct_views(
    view_set: "ViewSet",
    *,
    method: Method = DEFAULT_METHOD,
    progress: Progress | None = None,
    clock: StepClock,
) -> "Scene":
    """Reconstruct the scene that the views show, in their unit; raise InconsistentViewsError if
    their poses contradict them.
    """
    from facetlog.one_thread import use_one_thread
    from facetlog.perception.surfaces.reconstruct import reconstruct

    with use_one_thread():
        return reconstruct(
            view_set.views,
            name=view_set.name,
            up=view_set.up,
            find_up=view_set.find_up,
            metric=view_set.metric,
            errors=view_set.pose_errors,
            front_end=method.front_end.value,
            sd_limit=method.sd_limit,
            progress=progress,
            clock=clock,
        )


def apply_known_scale(scene: "Scene", method: Method) -> "tuple[Scene, Scale | None]":
    """Scale the scene to metres by the known length of the method; return it with the scale, if
    any.
    """
    from facetlog.perception.facts.known_length import scale_by_known_length

    return (scene, None) if method.scale is None else scale_by_known_length(scene, method.scale)


def write_scene_file(scene: "Scene", path: Path) -> None:
    """Write the scene as facetlog-scene/1."""
    from facetlog.perception.surfaces.scene_file import write_scene

    write_scene(scene, path)


def recognize_views(
    view_set: "ViewSet",
    *,
    base: "KnowledgeBase | None" = None,
    method: Method = DEFAULT_METHOD,
    progress: Progress | None = None,
    clock: StepClock,
    near: bool = False,
) -> Recognised:
    """Find scene, facts and verdicts for the views, by the models of `base` (else the built-in
    ones); `near` as for `judge_loaded_scene`.
    """
    scene = reconstruct_views(view_set, method=method, progress=progress, clock=clock)
    scene, scale = apply_known_scale(scene, method)
    return recognize_scene(scene, view_set, base=base, scale=scale, clock=clock, near=near)


def recognize_scene(
    scene: "Scene",
    view_set: "ViewSet",
    *,
    base: "KnowledgeBase | None" = None,
    scale: "Scale | None" = None,
    clock: StepClock,
    near: bool = False,
) -> Recognised:
    """Find facts and verdicts for a scene, by the models of `base` (else the built-in ones);
    `near` as for `judge_loaded_scene`.

    `view_set` has the views that it was reconstructed from, if any.
    """
    from facetlog.kb.recognize import judge_loaded_scene

    with clock.step("facts"):
        facts = facts_of(scene)
    with clock.step("verdicts"), ExitStack() as stack:
        models = base or stack.enter_context(open_models())
        load_scene(models, scene, facts)
        try:
            recognition = judge_loaded_scene(models, scene.name, near=near)
        finally:
            models.drop_scene(scene.name)
    return Recognised(view_set, scene, facts, recognition, clock, scale)


def facts_of(scene: "Scene") -> tuple[FlatFact, ...]:
    """Return the facts of a scene as plain rows, for the knowledge base."""
    from facetlog.perception.facts.all_facts import scene_facts

    return tuple(fact.row for fact in scene_facts(scene))


def load_scene(
    base: "KnowledgeBase", scene: "Scene", facts: tuple[FlatFact, ...] | None = None
) -> None:
    """Load the scene under its name, with these facts if they are known already.

    Facts on demand are made once they are asked for.
    """
    from facetlog.perception.facts.all_facts import facts_on_demand

    base.load_scene(
        scene.name,
        facts_of(scene) if facts is None else facts,
        on_demand=lambda: (fact.row for fact in facts_on_demand(scene)),
    )
