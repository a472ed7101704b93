"""Scenes of things of known kind: their facts, kept from run to run, and the truth.

Tours of pictures are rendered and reconstructed, from many views and from few; shapes are the
labelled meshes and scans of FACETLOG_DATA, both halves (a confidence is what strangers will see,
and no rule is developed on it); pictures are its path-traced sets of the same shapes. Facts are
kept by the content of all that they follow from: the world and the seed of the pictures' noise, or
the files, and the code.
"""

import gzip
import hashlib
import json
import os
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

import facetlog
from benchmarks.common import hash_tree
from benchmarks.pictures.recognition import in_metres, tour_views
from benchmarks.shapes.shape_judging import LISTED_APART, PERHAPS_BOXES, Task, scene_of
from facetlog.batch.labels import read_labels
from facetlog.errors import FacetlogError
from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import reconstruct_views
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import make_world

KINDS: Mapping[str, frozenset[str]] = MappingProxyType(
    {
        "block": frozenset({"box"}),
        "boxes": frozenset({"box"}),
        "wedge": frozenset(),
        "pyramid": frozenset(),
        "cylinder": frozenset(),
        "corner": frozenset({"room_corner"}),
        "table": frozenset({"table"}),
        "tables": frozenset({"table"}),
        "desk": frozenset({"desk", "table"}),
        "chair": frozenset({"chair"}),
        "chairs": frozenset({"chair"}),
        "bench": frozenset({"bench"}),
        "stool": frozenset({"stool"}),
        "shelf": frozenset({"shelf"}),
        "cabinet": frozenset({"cabinet"}),
        "stairs": frozenset({"stairs"}),
        "steps": frozenset({"step_stool"}),
        "bed": frozenset({"bed"}),
        "sofa": frozenset({"sofa"}),
        "crate": frozenset({"crate"}),
        "door": frozenset({"door"}),
        "frame": frozenset({"picture_frame"}),
    }
)
"""What a person would call the thing of each world; a desk is a table, too."""

OPEN = frozenset(
    {("cabinet", "box"), ("boxes", "cabinet"), ("block", "cabinet"), ("shelf", "bookcase")}
)
"""Worlds and models of which people would not agree: a closed block may be a box or a cabinet, a
high shelf is a bookcase.

Other borders are sharp by decision: a bench and a stool are no tables, though the same shape in
another size might be one, and a model that cannot tell them apart is to be told so by its
calibration.
"""

LABELS: Mapping[str, frozenset[str]] = MappingProxyType(
    {
        "armchair": frozenset({"chair"}),
        "desk": frozenset({"desk", "table"}),
        "open_box": frozenset({"crate"}),
        **{one: frozenset({one}) for one in ("box", "cabinet", "chair", "shelf", "stairs")},
        **{one: frozenset({one}) for one in ("stool", "table", "bed", "bench", "sofa", "door")},
    }
)
"""What a person would call the thing of each label; those that do not stand here are none of it."""

_APART = frozenset({"chair", "table", "box"})
_OPEN_LABELS: Mapping[str, frozenset[str]] = MappingProxyType(
    {
        **dict.fromkeys(LISTED_APART, _APART),
        **{one: frozenset({"box"}) for one in PERHAPS_BOXES},
        "cabinet": frozenset({"box", "shelf", "bookcase"}),
        "shelf": frozenset({"cabinet", "bookcase"}),
        "box": frozenset({"cabinet"}),
        "table": frozenset({"desk", "bench"}),
        "tv_unit": _APART | {"cabinet", "shelf"},
        "ottoman": _APART | {"stool", "bench"},
        "bench": _APART | {"sofa"},
        "sofa": frozenset({"bench"}),
        "sofa_or_bench": _APART | {"sofa", "bench"},
        "armchair": frozenset({"sofa"}),
        "carton": _APART | {"crate"},
        "picture": frozenset({"picture_frame"}),
    }
)
"""Labels and the models of which people would not agree, as accuracy_shapes counts them; and
cabinets with open shelves, closed boxes that may be cabinets, tables that may be desks or benches,
pictures that may be framed."""

WHOLE_ROOMS = "scan_scene"  # of many things: there is no main one

FOLDER = ("facetlog", "benchmarks", "calibration")
# What facts follow from, besides the world's own content. The makers of solids are not among it.
ROBOT_CODE = (
    "rendering/render.py",
    "rendering/texture.py",
    "rendering/views.py",
    "rendering/world.py",
    "tour.py",
    "tour.csv",
)
TOUR = "tours: "
TOUR_STRIDES = (1, 2, 4)
"""Each nth view of a tour of 24 is used, by the seed: from many views, some and few."""
PICTURE_STRIDES = (1, 3)
"""Steps between the pictures that are used of a set of 16."""
# What of perception has no part in a reconstruction.
APART = frozenset(
    {
        "polyhedra.py",
        "builders.py",
        "draw.py",
        "mesh_export.py",
        "lettering.py",
    }
)
# Folders of perception that no such picture goes through: meshes and clouds, poses that drift.
FOLDERS_APART = frozenset({"shapes", "shape_files", "pose_refinement"})


@dataclass(frozen=True, slots=True)
class LabelledScene:
    """The facts of a scene whose main thing is known: of a world or label, from some source.

    Things of one source were made alike: a world of the tours, a collection of shapes. Without
    facts there was an error, which `fault` names; without a thing nothing was found.
    """

    label: str
    source: str
    facts: tuple[Fact, ...]
    thing: str | None
    fault: str = ""


def get_world_truth(world: str, model: str) -> bool | None:
    """Return whether the main thing of the world is what the model describes; None where that is
    open.
    """
    return None if (world, model) in OPEN else model in KINDS[world]


def truth(scene: LabelledScene, model: str) -> bool | None:
    """Return the same of any labelled scene."""
    if scene.source.startswith(TOUR):
        return get_world_truth(scene.label, model)
    if model in _OPEN_LABELS.get(scene.label, ()):
        return None
    return model in LABELS.get(scene.label, ())


def load_tour_scene(name: str, seed: int) -> LabelledScene:
    """Return the scene of the paper's tour through a world, rendered and reconstructed if it is
    new; from each view, each second or each fourth, by the seed.

    Lengths are those of the real thing, in metres, where the world is a model of one.
    """
    world = make_world(name, seed)
    facts, fault = _kept(f"{name}-{seed}-{_key(world, seed)}", lambda: _facts(world, seed))
    return LabelledScene(name, f"{TOUR}{name}", facts, find_main_thing(facts), fault)


def iter_shape_scenes(folder: Path) -> Iterator[LabelledScene]:
    """Yield the scenes of a folder's labelled shapes."""
    for label in read_labels(folder / "labels.csv").values():
        path = Path(label.file)
        name = path.relative_to(folder).as_posix()
        if label.label == WHOLE_ROOMS:
            continue
        task = Task.of_file(label, name)
        total = hashlib.sha256(_code(frozenset()).encode() + path.read_bytes())
        total.update(repr((task.up, task.unit)).encode())
        key = f"{name.replace('/', '-')}-{total.hexdigest()[:16]}"
        facts, fault = _kept(key, partial(_shape_facts, task))
        yield LabelledScene(label.label, name.split("/")[0], facts, find_main_thing(facts), fault)


def iter_picture_scenes(folder: Path) -> Iterator[LabelledScene]:
    """Yield the scenes of a folder's sets of pictures, from all of a set and from some.

    Their source is the collection that the mesh is from: what it shows is alike.
    """
    for path in sorted(folder.glob("*/ground_truth.json")):
        known = json.loads(path.read_text(encoding="utf-8"))
        for stride in PICTURE_STRIDES:
            about = (hash_tree(path.parent), stride, _code(frozenset()))
            digest = hashlib.sha256(repr(about).encode()).hexdigest()[:16]
            make = partial(_picture_facts, path.parent, stride)
            facts, fault = _kept(f"set-{path.parent.name}-{stride}-{digest}", make)
            source = str(known["mesh"]).split("/")[0]
            yield LabelledScene(known["label"], source, facts, find_thing_at_origin(facts), fault)


def _picture_facts(folder: Path, stride: int) -> tuple[tuple[Fact, ...], str]:
    views = read_views(folder)
    used = replace(views, views=views.views[::stride])
    try:
        scene = reconstruct_views(used, clock=StepClock())
    except FacetlogError as exc:
        return (), type(exc).__name__
    return tuple(fact.row for fact in scene_facts(scene)), ""


def _shape_facts(task: Task) -> tuple[tuple[Fact, ...], str]:
    try:
        scene = scene_of(task)
    except FacetlogError as exc:
        return (), type(exc).__name__
    return tuple(fact.row for fact in scene_facts(scene)), ""


def _kept(
    name: str, make: Callable[[], tuple[tuple[Fact, ...], str]]
) -> tuple[tuple[Fact, ...], str]:
    """Return the facts and the fault of this name, made if they are not kept yet."""
    path = _folder() / f"{name}.json.gz"
    if not path.exists():
        facts, fault = make()
        text = json.dumps({"facts": facts, "fault": fault})
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f"{path.name}.{os.getpid()}.part")
        part.write_bytes(gzip.compress(text.encode(), mtime=0))
        part.replace(path)
    kept = json.loads(gzip.decompress(path.read_bytes()))
    return tuple(map(tuple, kept["facts"])), kept["fault"]


def find_main_thing(facts: Iterable[Fact]) -> str | None:
    """Return the thing with the largest total area of faces; of several the first by name."""
    areas: dict[str, float] = {}
    things: defaultdict[str, float] = defaultdict(float)
    owner: dict[str, str] = {}
    for functor, *arguments in facts:
        match functor, arguments:
            case "area", [str(face), float(area), _]:
                areas[face] = area
            case "part_of", [str(face), str(thing)]:
                owner[face] = thing
            case "thing", [str(thing)]:
                things[thing] += 0.0
    for face, area in areas.items():
        if face in owner:
            things[owner[face]] += area
    return min(things, key=lambda t: (-things[t], t), default=None)


def find_thing_at_origin(facts: Iterable[Fact]) -> str | None:
    """Return the thing whose corners lie round the origin most closely: where sets of pictures have
    what they show."""
    points, owner, faces = {}, {}, defaultdict(list)
    for functor, *arguments in facts:
        match functor, arguments:
            case "point", [str(vertex), *xyz]:
                points[vertex] = np.array(xyz, dtype=float)
            case "part_of", [str(face), str(thing)]:
                owner[face] = thing
            case "corner", [str(face), _, str(vertex)]:
                faces[face].append(vertex)
    corners: defaultdict[str, list[np.ndarray]] = defaultdict(list)
    for face, vertices in faces.items():
        if face in owner:
            corners[owner[face]] += [points[v] for v in vertices]

    def away(thing: str) -> tuple[float, float]:
        low, high = np.min(corners[thing], axis=0)[:2], np.max(corners[thing], axis=0)[:2]
        outside = np.maximum(0.0, np.maximum(low, -high))
        return float(np.hypot(*outside)), float(np.hypot(*(low + high))) / 2

    return min(sorted(corners), key=away, default=None)


def _facts(world: World, seed: int) -> tuple[tuple[Fact, ...], str]:
    used = tour_views(world, seed)[:: TOUR_STRIDES[seed % len(TOUR_STRIDES)]]
    try:
        views = in_metres(f"{world.name}-{seed}", used, world.model_scale)
        scene = reconstruct_views(views, clock=StepClock())
    except FacetlogError as exc:
        return (), type(exc).__name__
    return tuple(fact.row for fact in scene_facts(scene)), ""


def _folder() -> Path:
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path("~/.cache").expanduser()).joinpath(*FOLDER)


def _key(world: World, seed: int) -> str:
    total = hashlib.sha256(_code(FOLDERS_APART).encode())
    for solid in world.solids:
        total.update(np.ascontiguousarray(solid.vertices).tobytes())
        total.update(repr((solid.faces, solid.albedo, solid.prints, solid.curved)).encode())
    light = (world.background, world.ambient, world.sided, world.exposure, world.model_scale)
    total.update(repr((world.floor, world.sun.tolist(), light, seed, TOUR_STRIDES)).encode())
    return total.hexdigest()[:16]


@cache
def _code(folders_apart: frozenset[str]) -> str:
    """Return SHA-256 of the files that render pictures and make facts of them, but for some
    folders.
    """
    source = Path(facetlog.__file__).parent
    files = [source / "robot" / name for name in ROBOT_CODE]
    files += sorted((source / "perception").rglob("*.py"))
    total = hashlib.sha256()
    for path in files:
        if path.name not in APART and folders_apart.isdisjoint(path.parts):
            total.update(path.name.encode())
            total.update(path.read_bytes())
    return total.hexdigest()
