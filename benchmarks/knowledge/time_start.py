"""How long does a single question take to start, and a mesh that was classified before?

CPU time of `facetlog --help`, and of `classify` and `why` of a mesh that is kept; and of upright
third-party meshes (shapes/labels.csv), from file to row: at first, again with one model more, and
again with the same. The number of seeds is that of the meshes.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.common import (
    Report,
    Row,
    Settings,
    Table,
    compute_median_and_spread,
    find_data_set,
)
from facetlog.batch.engine import SceneEngine
from facetlog.batch.labels import Label, read_labels
from facetlog.batch.settings import Item
from facetlog.batch.settings import Settings as BatchSettings
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.shapes.shape_options import NOT_GIVEN, UP_AXES
from facetlog.perception.surfaces.exact_solids.polyhedra import table
from facetlog.perception.surfaces.mesh_export import write_mesh

NAME = "time_start"
MESHES = 155
REPEATS = 5
OTHER = "model platform\n  face deck where deck is level\n\n  up: deck is upward\n"


def _seconds(words: Sequence[str], environment: dict[str, str]) -> float:
    """Return CPU time of a command and the processes that it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-m", "facetlog", *words],
        env=environment,
        capture_output=True,
        check=True,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _time_commands(folder: Path, repeats: int) -> tuple[Row, ...]:
    mesh = folder / "table.ply"
    write_mesh(table(), mesh)
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache"), "OMP_NUM_THREADS": "1"}
    commands = {
        "--help": ["--help"],
        "classify, one mesh": ["classify", str(mesh), "--up=z", "--unit=m"],
        "why, one mesh": ["why", str(mesh), "table", "--up=z", "--unit=m"],
    }
    rows = []
    for name, words in commands.items():
        first = _seconds(words, environment)
        again = [_seconds(words, environment) for _ in range(repeats)]
        rows.append({"what": name, "first": first, **compute_median_and_spread(again)})
    return tuple(rows)


def _make_item(label: Label) -> Item:
    return Item(label.file, label.up, label.unit if label.unit in METRES_PER else NOT_GIVEN)


def _time_meshes(items: Sequence[Item], folder: Path) -> tuple[Row, ...]:
    other = folder / "platform.model"
    other.write_text(OTHER, encoding="utf-8")
    runs = {"first": (), "with one model more": (str(other),), "again with it": (str(other),)}
    rows = []
    for name, models in runs.items():
        settings = BatchSettings(models, keep=str(folder / "kept"), profile=True)
        engine = SceneEngine(settings)
        times = []
        for item in items:
            start = time.process_time()
            engine.row(item)
            times.append(1e3 * (time.process_time() - start))
        stages = {s: round(1e3 * t / len(items), 1) for s, t in engine.profile.stages.items()}
        engine.close()
        mean = round(float(np.mean(times)), 1)
        spread = compute_median_and_spread(times, digits=1)
        rows.append({"what": name, "mean": mean, **spread, **stages})
    return tuple(rows)


def measure(settings: Settings) -> Report:
    """Measure commands, and meshes if there are any."""
    count = settings.number(MESHES)
    found = find_data_set("shapes")
    tables = []
    with tempfile.TemporaryDirectory() as name:
        rows = _time_commands(Path(name), REPEATS)
        tables.append(Table("A command, CPU s", rows))
        if isinstance(found, Path):
            labels = read_labels(found / "labels.csv").values()
            upright = [label for label in labels if label.kind == "mesh" and label.up in UP_AXES]
            items = [_make_item(label) for label in upright[:: max(1, len(upright) // count)]]
            rows = _time_meshes(items[:count], Path(name))
            tables.append(Table("A mesh from file to row, CPU ms", rows))
    notes = (
        "Wanted: --help 0.2 s, classify and why of a kept mesh 0.8 s, a kept mesh 40 ms.",
        *([found] if isinstance(found, str) else []),
    )
    return Report(NAME, tuple(tables), {"meshes": count, "repeats": REPEATS}, notes)
