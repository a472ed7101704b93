"""How long does a mesh of a million triangles take to become a scene?

Furniture of boxes that reach into one another, each side cut into ever smaller triangles, is read
from a PLY and from an STL file (whose triangles share no corners) and made into a scene. The peer,
in the same run: trimesh loads the same file and finds its facets. CPU time, medians.
"""

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import trimesh

from benchmarks.common import Report, Row, Settings, Table
from facetlog.perception.reading.shape_files.meshes.mesh_files import read_mesh
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene

NAME = "time_mesh"
REPEATS = 3
# A table's 60 triangles, each cut into four so many times: 15,360 and 983,040.
CUTS = (4, 7)
SUFFIXES = (".ply", ".stl")
TOP_M, LEG_M, HEIGHT_M = (1.2, 0.8, 0.04), 0.06, 0.74
INSET_M, OVERLAP_M = 0.05, 0.02


def make_table_mesh(cuts: int) -> Any:
    """Return a table of five boxes whose legs reach into the top, as a mesh, in metres."""
    length, width, thickness = TOP_M
    under = HEIGHT_M - thickness
    parts = [trimesh.creation.box(bounds=[(0.0, 0.0, under), (length, width, HEIGHT_M)])]
    parts += [
        trimesh.creation.box(bounds=[(x, y, 0.0), (x + LEG_M, y + LEG_M, under + OVERLAP_M)])
        for x in (INSET_M, length - INSET_M - LEG_M)
        for y in (INSET_M, width - INSET_M - LEG_M)
    ]
    mesh = trimesh.util.concatenate(parts)
    for _ in range(cuts):
        mesh = mesh.subdivide()
    return mesh


def _seconds(work: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """Return median CPU time of the work, and its last result."""
    times, result = [], None
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        times.append(time.process_time() - start)
    return statistics.median(times), result


def measure(settings: Settings) -> Report:
    """Measure both sizes and kinds of file; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        for cuts in CUTS:
            mesh = make_table_mesh(cuts)
            for suffix in SUFFIXES:
                path = Path(folder, f"table{suffix}")
                mesh.export(path)
                rows.append({"triangles": len(mesh.faces), "file": suffix, **_row(path, repeats)})
    notes = ("Wanted: at a million triangles at most 3 times trimesh.",)
    return Report(NAME, (Table("CPU seconds", tuple(rows)),), {"repeats": repeats}, notes)


def _row(path: Path, repeats: int) -> Row:
    loading, loaded = _seconds(lambda: trimesh.load_mesh(path), repeats)
    # facets are kept with a mesh once they were found, so each time counts one load
    both, facets = _seconds(lambda: len(trimesh.load_mesh(path).facets), repeats)
    reading, mesh = _seconds(lambda: read_mesh(path), repeats)
    making, scene = _seconds(lambda: make_mesh_scene(mesh), repeats)
    del loaded
    return {
        "trimesh loads": round(loading, 3),
        "and facets": round(both, 3),
        "its facets": facets,
        "read": round(reading, 3),
        "made a scene": round(making, 3),
        "its faces": len(scene.faces),
        "times trimesh": round((reading + making) / both, 2),
    }
