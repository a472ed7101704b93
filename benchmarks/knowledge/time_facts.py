"""How long do a scene's facts take, from its JSON on, and which step takes it?

Exact scenes of 6 to 60 faces; and the space of things with its measures, and with their pieces: of
a mesh, of a scan, and of what 24 views looked at. Processor time of one process, the least of the
repeats: what else the machine does can only add to it.
"""

import cProfile
import pstats
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.shapes.time_mesh import table_mesh
from facetlog.perception.facts.all_facts import LEVEL_KINDS, fact_columns, fact_rows, scene_facts
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Body, Scene, SightLines
from facetlog.perception.shapes.meshes.mesh_scene import scene_of_mesh
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved, together
from facetlog.perception.surfaces.scene_file import scene_from_json, scene_to_json

__all__ = ["NAME", "measure"]

NAME = "time_facts"
REPEATS = 30
DOZEN = 12
# The steps of fact_rows by its makers; what several need is counted with the first of them.
STEPS = {
    "of": "faces",
    "edge_facts": "edges",
    "size_facts": "sizes",
    "thing_facts": "things",
    "box_facts": "boxes",
    "share_facts": "shares",
    "protrusion_facts": "protrusions",
    "gap_facts": "gaps",
    "angle_facts": "angles",
    "opposite_facts": "opposite",
    "meeting_facts": "where faces meet",
    "body_facts": "heights",
    "overlap_facts": "plans",
    "clear_facts": "clear below",
    "rim_facts": "at the rim",
}
MADE_IN = (
    "/perception/facts/part_facts.py",
    "/perception/facts/thing_facts.py",
    "/perception/facts/scene_memo.py",
)
# Facts that are measured in the space of things.
OF_SPACE = frozenset({"whole", "footprint", "solidity", *LEVEL_KINDS, "unseen_bounds"})
OF_PIECES = OF_SPACE | {kind.functor for kind in PIECE_KINDS}
# Views round a table, and lines of sight of each that end on the floor about it.
VIEWS, LINES = 24, 1600


def scenes() -> dict[str, Scene]:
    """Scenes by name, of few faces and of many."""
    blocks = [moved(cuboid(), translation=(0.5 * i, 0.1 * i, 0.0)) for i in range(10)]
    return {
        "a cuboid": build("cuboid", {}),
        "two cuboids": together(*blocks[:2]),
        "stairs": build("stairs", {}),
        "a bench": build("bench", {}),
        "a table": build("table", {}),
        "a shelf": build("shelf", {}),
        "a shelf of nine boards": build("shelf", {"boards": 9}),
        "ten cuboids": together(*blocks),
    }


def spacious() -> dict[str, Scene]:
    """Scenes by name, each a thing whose space is known by something else."""
    table = build("table", {})
    mesh = table_mesh(3)
    meshed = Mesh.of(mesh.vertices, mesh.faces, name="table")
    lines = _looked_at(table)
    body = (Body(tuple(range(len(table.faces)))),)
    return {
        f"a mesh of {len(mesh.faces)} triangles": scene_of_mesh(meshed, up=(0.0, 0.0, 1.0)),
        "a scan from one place": replace(table, bodies=body, sights=lines[:1]),
        f"{VIEWS} views": replace(table, sights=lines),
    }


def _looked_at(scene: Scene) -> tuple[SightLines, ...]:
    """Lines of sight from places round the scene to the floor under it and about it."""
    low, high = scene.points.min(axis=0), scene.points.max(axis=0)
    rng = np.random.default_rng(0)
    around = np.linspace(0.0, 2.0 * np.pi, VIEWS, endpoint=False)
    places = 2.0 * np.column_stack([np.cos(around), np.sin(around), np.full(VIEWS, 0.7)])
    low, high = low - (high - low), high + (high - low)
    low[2] = high[2] = scene.points[:, 2].min()
    ends = rng.uniform(low, high, (VIEWS, LINES, 3))
    return tuple(map(SightLines, places, ends))


def least_ms(work: Callable[[], object], repeats: int) -> float:
    """Least processor time of the work, milliseconds."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1e3 * min(times)


def dozen_ms(scene: Scene, repeats: int) -> float:
    """Least processor time of a scene's facts, milliseconds, where a dozen are made together."""
    return least_ms(lambda: fact_columns([scene] * DOZEN), max(1, repeats // DOZEN)) / DOZEN


def shares_of_steps(scene: Scene, repeats: int) -> dict[str, float]:
    """Share of fact_rows that each of its steps takes, per cent, by Python's profiler."""
    profile = cProfile.Profile()
    profile.enable()
    for _ in range(repeats):
        fact_rows(scene)
    profile.disable()
    spent: dict[str, float] = dict.fromkeys(STEPS, 0.0)
    total = 0.0
    statistics = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    for (path, _, name), (_, _, _, cumulative, _) in statistics.items():
        if path.endswith(MADE_IN) and name in spent:
            spent[name] = cumulative
        elif path.endswith("/perception/facts/all_facts.py") and name == "fact_rows":
            total = cumulative
    return {STEPS[name]: 100.0 * each / total for name, each in spent.items()}


def measure(settings: Settings) -> Report:
    """Times of every scene; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    times: list[Row] = []
    steps: list[Row] = []
    for name, scene in scenes().items():
        text = scene_to_json(scene)
        facts = scene_facts(scene)
        times.append(
            {
                "scene": name,
                "faces": len(scene.faces),
                "facts": len(facts),
                "JSON to scene, ms": least_ms(lambda text=text: scene_from_json(text), repeats),
                "fact_rows, ms": least_ms(lambda scene=scene: fact_rows(scene), repeats),
                "of a dozen, ms": dozen_ms(scene, repeats),
                "scene_facts, ms": least_ms(lambda scene=scene: scene_facts(scene), repeats),
            }
        )
        steps.append({"scene": name, **shares_of_steps(scene, repeats)})
    space: list[Row] = [
        {
            "of": name,
            "space and its measures, ms": least_ms(
                lambda scene=scene: fact_rows(scene, OF_SPACE), repeats
            ),
            "with pieces, ms": least_ms(lambda scene=scene: fact_rows(scene, OF_PIECES), repeats),
        }
        for name, scene in spacious().items()
    ]
    tables = (
        Table("Processor time", tuple(times)),
        Table("Share of fact_rows, %", tuple(steps)),
        Table("Space", tuple(space)),
    )
    notes = ("Wanted: space, its measures and pieces within 100 ms of a mesh, 200 ms of 24 views.",)
    return Report(NAME, tables, {"repeats": repeats}, notes)
