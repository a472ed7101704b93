"""Rendered scenes of things of known kind: their facts, kept from run to run, and the truth.

Facts are kept by the content of all that they follow from: the world, the seed of the pictures'
noise, and the code that renders and reconstructs.
"""

import gzip
import hashlib
import json
import os
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np

import facetlog
from benchmarks.recognition import in_metres, tour_views
from facetlog.errors import FacetlogError
from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.step_clock import StepClock
from facetlog.pipeline import reconstruct_views
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import make_world

__all__ = ["KINDS", "OPEN", "TourScene", "main_thing", "tour_scene", "truth"]

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
    }
)
"""What a person would call the thing of each world; a desk is a table, too."""

OPEN = frozenset({("cabinet", "box"), ("boxes", "cabinet"), ("block", "cabinet")})
"""Worlds and models of which people would not agree: a closed block may be a box or a cabinet.

Other borders are sharp by decision: a bench and a stool are no tables, though the same shape in
another size might be one, and a model that cannot tell them apart is to be told so by its
calibration.
"""

FOLDER = ("facetlog", "benchmarks", "calibration")
# What facts follow from, besides the world's own content. The makers of solids are not among it.
ROBOT_CODE = (
    "rendering/rays.py",
    "rendering/render.py",
    "rendering/texture.py",
    "rendering/views.py",
    "rendering/world.py",
    "tour.py",
    "tour.csv",
)
# What of perception has no part in a reconstruction.
APART = frozenset(
    {
        "polyhedra.py",
        "exact_furniture.py",
        "builders.py",
        "draw.py",
        "mesh_export.py",
        "lettering.py",
    }
)
# Folders of perception that no such picture goes through: meshes and clouds, poses that drift.
FOLDERS_APART = frozenset({"shapes", "shape_files", "pose_refinement"})


@dataclass(frozen=True, slots=True)
class TourScene:
    """The facts of a tour through a world, and its main thing.

    Without facts there was an error, which `fault` names; without a thing nothing was found.
    """

    world: str
    seed: int
    facts: tuple[Fact, ...]
    thing: str | None
    fault: str = ""


def truth(world: str, model: str) -> bool | None:
    """Whether the main thing of the world is what the model describes; None where that is open."""
    return None if (world, model) in OPEN else model in KINDS[world]


def tour_scene(name: str, seed: int) -> TourScene:
    """The scene of the paper's tour through a world, rendered and reconstructed if it is new.

    Lengths are those of the real thing, in metres, where the world is a model of one.
    """
    world = make_world(name, seed)
    path = _folder() / f"{name}-{seed}-{_key(world, seed)}.json.gz"
    if path.exists():
        kept = json.loads(gzip.decompress(path.read_bytes()))
        facts = tuple(map(tuple, kept["facts"]))
        return TourScene(name, seed, facts, main_thing(facts), kept["fault"])
    facts, fault = _facts(world, seed)
    text = json.dumps({"facts": facts, "fault": fault})
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    part.write_bytes(gzip.compress(text.encode(), mtime=0))
    part.replace(path)
    return TourScene(name, seed, facts, main_thing(facts), fault)


def main_thing(facts: Iterable[Fact]) -> str | None:
    """The thing with the largest total area of faces; of several the first by name."""
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


def _facts(world: World, seed: int) -> tuple[tuple[Fact, ...], str]:
    try:
        views = in_metres(f"{world.name}-{seed}", tour_views(world, seed), world.model_scale)
        scene = reconstruct_views(views, clock=StepClock())
    except FacetlogError as exc:
        return (), type(exc).__name__
    return tuple((fact.functor, *fact.args) for fact in scene_facts(scene)), ""


def _folder() -> Path:
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path("~/.cache").expanduser()).joinpath(*FOLDER)


def _key(world: World, seed: int) -> str:
    total = hashlib.sha256(_code().encode())
    for solid in world.solids:
        total.update(np.ascontiguousarray(solid.vertices).tobytes())
        total.update(repr((solid.faces, solid.albedo, solid.prints, solid.curved)).encode())
    light = (world.background, world.ambient, world.sided, world.exposure, world.model_scale)
    total.update(repr((world.floor, world.sun.tolist(), light, seed)).encode())
    return total.hexdigest()[:16]


@cache
def _code() -> str:
    """SHA-256 of the files that render pictures and make facts of them."""
    source = Path(facetlog.__file__).parent
    files = [source / "robot" / name for name in ROBOT_CODE]
    files += sorted((source / "perception").rglob("*.py"))
    total = hashlib.sha256()
    for path in files:
        if path.name not in APART and FOLDERS_APART.isdisjoint(path.parts):
            total.update(path.name.encode())
            total.update(path.read_bytes())
    return total.hexdigest()
