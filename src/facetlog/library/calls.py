"""Recognise, classify and ask in one call each."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from facetlog.errors import InputError, make_missing_extra_error
from facetlog.library.result import Result, model_paths
from facetlog.perception.step_clock import StepClock

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow

    from facetlog.batch.settings import Settings
    from facetlog.perception.facts.known_length import KnownLength
    from facetlog.perception.length_units import Length
    from facetlog.perception.reading.read_views import ViewSet
    from facetlog.perception.scene import Scene
    from facetlog.perception.types import FloatArray, View

__all__ = ["Models", "Source", "Up", "ask", "classify", "classify_batch", "read_scene", "recognize"]

Models: TypeAlias = str | Path | Sequence[str | Path]
"""A model file or a folder of them, or several."""

Up: TypeAlias = str | Sequence[float] | None
"""Upwards: what `--up` takes, as "z" or "auto", or a vector (3,) of any length."""

Source: TypeAlias = "str | Path | Scene | Result | Iterable[View]"
"""A folder of pictures with poses or its poses file; a scene, mesh or cloud, or the result of one;
or views."""


_SOURCES = "give the folder of pictures or the file as one path, a scene, or a list of views"


def recognize(
    source: Source,
    *,
    models: Models = (),
    up: Up = None,
    unit: str | None = None,
    scale: str | None = None,
    square: str | None = None,
    cameras: str | Path | None = None,
    trust: bool = False,
    raw: bool = False,
) -> Result:
    """Recognize what is there: return the scene, and the verdicts of all models on each thing in
    it.

    `up` and `unit` (m, cm, mm, in, ft) say what a file does not, `scale` as in read_scene. Of
    pictures on a printed mat `square` is the side of a square, as "17.6 ± 0.02 mm", if its bar was
    off. Cameras of pictures without poses and mat, which take minutes to find, are kept in the
    folder `cameras`. Models in Prolog need `trust`; `raw` verdicts have no confidence. Raises
    InputError for a source, RuleSyntaxError for a model that cannot be used, EngineError without
    SWI-Prolog.
    """
    from facetlog.kb.recognize import judge_loaded_scene
    from facetlog.perception.facts.known_length import KnownLength
    from facetlog.perception.length_units import parse_length
    from facetlog.pipeline import load_scene, open_models

    paths = model_paths(models)
    known = None if scale is None else KnownLength.parse(scale, "scale")
    stated = _Stated(
        up,
        unit,
        trust,
        None if square is None else parse_length(square, "square"),
        None if cameras is None else Path(cameras),
    )
    # Before any long work: a model that cannot be used would lose it.
    with open_models(paths, trusted=trust, raw=raw) as base:
        measured, view_set = _measure(source, stated)
        scene = _apply_scale(measured, known)
        load_scene(base, scene)
        return Result(scene, judge_loaded_scene(base, scene.name), paths, trust, raw, view_set)


def read_scene(
    path: str | Path, *, up: Up = None, unit: str | None = None, scale: str | None = None
) -> "Scene":
    """Read the scene in a file: one of facetlog's, a mesh, a cloud, or the folder of a COLMAP model
    or one that `-o` wrote.

    Without `up` it is what the file says, or is found from a floor. `scale` is a length that is
    known where the unit is not, as "v3 v7 = 25 cm", "e5 = 25 ± 0.1 cm" or "height = 74 cm". Raises
    InputError for a file that cannot be read.
    """
    from facetlog.perception.facts.known_length import KnownLength

    known = None if scale is None else KnownLength.parse(scale, "scale")
    return _apply_scale(_read_scene(Path(path), up, unit), known)


def classify(
    paths: str | Path | Sequence[str | Path],
    *,
    models: Models = (),
    up: Up = None,
    unit: str | None = None,
    workers: int | None = None,
    trust: bool = False,
) -> "pd.DataFrame":
    """Classify scenes, meshes or clouds: return a row of model, thing and confidence for each.

    `paths` are files, folders or globs. The columns are those of `classify -o`; what
    cannot be read has its reason in `error`. It takes `workers` processes, one a core if not given.
    Raise InputError for options, RuleSyntaxError for models that cannot be used.
    """
    import os

    from facetlog.batch.inputs import find_scene_paths
    from facetlog.batch.pool import Pool
    from facetlog.batch.run import Plan, classified
    from facetlog.batch.settings import Item

    given = [paths] if isinstance(paths, str | Path) else list(paths)
    items = tuple(map(Item, find_scene_paths([str(path) for path in given])))
    settings = _make_settings(models, up, unit, trusted=trust)
    count = len(os.sched_getaffinity(0)) if workers is None else workers
    frame = _import_data_frame()
    with (
        Pool(settings, min(count, len(items))) as crew,
        classified(Plan(items, settings), crew) as done,
    ):
        return frame(list(done.rows()))


def classify_batch(
    table: "pyarrow.Table",
    *,
    models: Models = (),
    up: Up = None,
    unit: str | None = None,
    sensor: str | Sequence[float] | None = None,
    override: bool = False,
    trust: bool = False,
    crisp: bool = False,
    raw: bool = False,
    seconds: float | None = None,
    memory_mb: int | None = None,
    keep: str | Path | None = None,
) -> "pyarrow.Table":
    """Classify the scenes of a pyarrow Table or RecordBatch, as Dask, Ray, Daft and Spark hand them
    over: return another one.

    The table has the paths of scenes, meshes or clouds in its column `path`, and may have `up`,
    `unit` and `override` for single ones. Rows come in its order with the columns of `classify -o`;
    what cannot be read has its reason in `error`. Limits for a scene are `seconds` of processor
    time (default: 60) and `memory_mb` (default: the memory of the machine by its cores). The engine
    is kept for the next table. Raise InputError for options or a table, RuleSyntaxError for models
    that cannot be used.
    """
    from facetlog.batch.arrow_batch import classify_arrow

    if sensor is not None and not isinstance(sensor, str):
        sensor = ",".join(repr(float(each)) for each in sensor)
    more = {
        "trusted": trust,
        "crisp": crisp,
        "raw": raw,
        "override": override,
        "sensor": sensor,
        "seconds": seconds,
        "memory_mb": memory_mb,
        "keep": None if keep is None else str(Path(keep).resolve()),
    }
    given = {name: value for name, value in more.items() if value is not None}
    return classify_arrow(table, _make_settings(models, up, unit, **given))


def _make_settings(models: Models, up: Up, unit: str | None, **more: Any) -> "Settings":
    from facetlog.batch.settings import Settings
    from facetlog.perception.shapes.shape_options import FROM_THE_FLOOR, NOT_GIVEN

    _parse_unit(unit)
    direction = _parse_up(up)
    if direction is None or isinstance(up, str):
        axis = up if isinstance(up, str) else FROM_THE_FLOOR
    else:
        axis = ",".join(map(repr, direction))
    named = tuple(str(path.resolve()) for path in model_paths(models))
    return Settings(named, up=axis, unit=unit or NOT_GIVEN, **more)


def ask(
    scenes: "Source | Sequence[str | Path | Scene | Result]",
    goal: str,
    *,
    models: Models = (),
    up: Up = None,
    unit: str | None = None,
    most: int | None = None,
    trust: bool = False,
) -> "pd.DataFrame":
    """Answer a question (docs/queries.md): return a column for each variable of the goal.

    Of several scenes the first column, `Scene`, is the name of each answer's. A goal without
    variables has one row and the column `holds`, True or False. At most `most` answers are read.
    Raise QueryError for a question that cannot be asked.
    """
    from facetlog.kb.engine.terms import Atom
    from facetlog.pipeline import load_scene, open_models

    frame = _import_data_frame()
    with open_models(model_paths(models), trusted=trust) as base:
        for scene in _make_names_distinct(_read_sources(scenes, _Stated(up, unit, trust))):
            load_scene(base, scene)
        with base.query(goal, most=most) as answers:
            if not answers.names:  # a row without columns is none in a table
                return frame({"holds": [next(answers, None) is not None]})
            columns = {
                name: [str(value) if isinstance(value, Atom) else value for value in values]
                for name, values in answers.arrays().items()
            }
            return frame(columns, columns=list(answers.names))


def _import_data_frame() -> "type[pd.DataFrame]":
    """Import what makes a table; to be called before any work, for it may not be installed."""
    try:
        import pandas as pd
    except ImportError:
        raise make_missing_extra_error("tables", "pandas", "tables") from None
    frame: type[pd.DataFrame] = pd.DataFrame
    return frame


def _parse_up(up: Up) -> "tuple[float, float, float] | None":
    """Return the unit vector that is meant, if any."""
    import numpy as np

    from facetlog.perception.shapes.shape_options import parse_up

    if up is None or isinstance(up, str):
        return None if up is None else parse_up(up, "up")
    try:
        vector = np.asarray(up, dtype=np.float64)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    length = float(np.linalg.norm(vector))
    if vector.shape != (3,) or not 0.0 < length < np.inf:
        raise InputError(f"up {up!r:.40}: give three numbers that are not all 0")
    x, y, z = (vector / length).tolist()
    return x, y, z


def _normalize_up(up: Up) -> Up:
    """Return upwards where it is stated; "auto" states nothing."""
    from facetlog.perception.shapes.shape_options import FROM_THE_FLOOR

    return None if isinstance(up, str) and up == FROM_THE_FLOOR else up


def _parse_unit(unit: str | None) -> str | None:
    from facetlog.perception.shapes.shape_options import parse_unit

    return None if unit is None else parse_unit(unit, "unit")


@dataclass(frozen=True, slots=True)
class _Stated:
    """Statements about a source, as the arguments of `recognize`."""

    up: Up
    unit: str | None
    trust: bool
    square: "Length | None" = None
    cameras: Path | None = None


def _read_source(source: Source, stated: _Stated) -> "Scene":
    return _measure(source, stated)[0]


def _measure(source: Source, stated: _Stated) -> "tuple[Scene, ViewSet | None]":
    """Return the scene, and the views that it was reconstructed from, if any."""
    from facetlog.perception.reading.pose_files.register import find_poses, has_poses
    from facetlog.perception.reading.shape_files.clouds.colmap_model import find_colmap_model
    from facetlog.perception.scene import Scene
    from facetlog.perception.shapes.read_shape import ShapeOptions
    from facetlog.perception.shapes.read_shape import stated as as_stated

    up, unit = _normalize_up(stated.up), _parse_unit(stated.unit)
    _parse_up(up)  # a word that is none is refused before any long work
    if isinstance(source, Scene):
        return as_stated(source, ShapeOptions(_parse_up(up), up is None, unit, override=True)), None
    if isinstance(source, Result):
        return as_stated(
            source.scene, ShapeOptions(_parse_up(up), up is None, unit, override=True)
        ), None
    if not isinstance(source, str | Path):
        view_set = _make_view_set(source, up)
        return _reconstruct(view_set), view_set
    path = Path(source)
    if not path.exists():
        raise InputError(f"{path}: there is no such file or folder")
    if _find_written_scene(path) is None and has_poses(path):
        view_set = _read_views(path, stated)
        return _reconstruct(view_set), view_set
    if stated.square is not None:
        raise InputError(f"square is for pictures of a mat, and {path} holds none: omit it")
    if path.is_dir() and _find_written_scene(path) is None and find_colmap_model(path) is None:
        find_poses(path)  # which lists what the folder would need
    return _read_scene(path, up, unit), None


def _read_scene(path: Path, up: Up, unit: str | None) -> "Scene":
    from facetlog.kept_scenes import read_stated
    from facetlog.perception.shapes.shape_options import ShapeOptions

    up = _normalize_up(up)
    if not path.exists():
        raise InputError(
            f"{path} does not exist: give a scene, mesh or cloud, or the folder of one"
        )
    inside = _find_written_scene(path)
    return read_stated(
        inside or path, ShapeOptions(_parse_up(up), up is None, _parse_unit(unit), override=True)
    )


def _find_written_scene(path: Path) -> Path | None:
    """Return the scene file in a folder that `-o` wrote; the pictures there only show what was
    found.
    """
    from facetlog.query_shell.scene_files import SCENE_FILE

    inside = path / SCENE_FILE
    return inside if inside.is_file() else None


def _apply_scale(scene: "Scene", known: "KnownLength | None") -> "Scene":
    from facetlog.perception.facts.known_length import scale_by_known_length

    return scene if known is None else scale_by_known_length(scene, known)[0]


def _read_sources(
    scenes: "Source | Sequence[str | Path | Scene | Result]", stated: _Stated
) -> "list[Scene]":
    from facetlog.perception.types import View

    # Several views are one source.
    one = not isinstance(scenes, list | tuple) or any(isinstance(each, View) for each in scenes)
    several = cast("Sequence[Source]", [scenes] if one else scenes)
    return [
        each.scene if isinstance(each, Result) else _read_source(each, stated) for each in several
    ]


def _make_names_distinct(scenes: "Iterable[Scene]") -> "Iterable[Scene]":
    """Yield the scenes; a name that occurred before gets a number."""
    names: set[str] = set()
    for scene in scenes:
        name, count = scene.name, 1
        while name in names:
            count += 1
            name = f"{scene.name} {count}"
        names.add(name)
        yield scene if name == scene.name else replace(scene, name=name)


def _convert_up(up: Up) -> "str | FloatArray | None":
    """Return upwards as the pipeline takes it."""
    import numpy as np

    if up is None or isinstance(up, str):
        return up
    vector = _parse_up(up)
    return None if vector is None else np.array(vector)


def _read_views(path: Path, stated: _Stated) -> "ViewSet":
    from facetlog.pipeline import read_views_from

    return read_views_from(
        path,
        unit=_parse_unit(stated.unit),
        up=_convert_up(_normalize_up(stated.up)),
        square=stated.square,
        keep=stated.cameras,
        trusted=stated.trust,
        progress=None,
        clock=StepClock(),
    )


def _make_view_set(views: "Iterable[View]", up: Up) -> "ViewSet":
    from facetlog.perception.reading.read_views import LEAST_VIEWS, ViewSet
    from facetlog.perception.types import View
    from facetlog.pipeline import apply_stated_up

    if not isinstance(views, Iterable):
        raise InputError(f"{views!r:.40} is no source: {_SOURCES}")
    found = tuple(views)
    for view in found:
        if not isinstance(view, View):
            raise InputError(f"{view!r:.40} is no View, of which a list consists: {_SOURCES}")
    if len(found) < LEAST_VIEWS:
        raise InputError(f"{len(found)} views, {LEAST_VIEWS} are needed, from different places")
    return apply_stated_up(ViewSet("views", found), _convert_up(up))


def _reconstruct(view_set: "ViewSet") -> "Scene":
    from facetlog.pipeline import reconstruct_views

    scene = reconstruct_views(view_set, clock=StepClock())
    return replace(scene, warnings=(*view_set.problems, *scene.warnings))
