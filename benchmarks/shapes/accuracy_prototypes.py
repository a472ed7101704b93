"""For which models is a solid found that they describe, and how long does it take?

The built-in models, own texts (drawn_texts), and those of newcomers in FACETLOG_DATA. `least` is
the least margin of a condition: 1 is the middle of its limits, 0 a limit; a share to be at
least 80 % has .25 at most. `as mesh` is what the model says of the drawn GLB file, read anew.
Seconds are those of this process, the engine's included.
"""

import os
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.common import DATA_VARIABLE, Report, Row, Settings, Table
from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.kb.recognize import open_knowledge_base
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape
from facetlog.perception.surfaces.mesh_export import write_mesh
from facetlog.prototype.objective import EXPECTED
from facetlog.prototype.search import searched
from facetlog.prototype.workbench import Workbench

NAME = "accuracy_prototypes"
EFFORT = 240
FOLDER = Path(__file__).resolve().parent / "drawn_texts"
NEWCOMERS = ("newcomer/models", "newcomer2")


def measure(settings: Settings) -> Report:
    """Measure one row a model; seeds play no part, since nothing is drawn by chance."""
    del settings
    tables = [Table("built-in models", tuple(_rows((), BUILTIN_MODELS)))]
    data = os.environ.get(DATA_VARIABLE, "")
    folders = {"own texts": FOLDER} | {
        f"a newcomer's models, {folder}": Path(data) / folder for folder in NEWCOMERS if data
    }
    for title, folder in folders.items():
        paths = sorted(folder.glob("*.model"))
        rows = [row for path in paths for row in _rows((path,), (path.stem,))]
        tables.append(Table(title, tuple(rows)))
    notes: tuple[str, ...] = (
        () if data else (f"a newcomer's models are not there: set {DATA_VARIABLE}",)
    )
    return Report(NAME, tuple(tables), {"effort": EFFORT}, notes)


def _rows(paths: tuple[Path, ...], models: tuple[str, ...]) -> Iterator[Row]:
    with open_knowledge_base(paths, trusted=True) as base:
        for model in models:
            bench, start = Workbench(base, model), time.process_time()
            best = searched(bench, EFFORT).best
            seconds, judged = time.process_time() - start, bench.judged
            hard = [m for key, m in best.judged.margins.items() if key[0] != EXPECTED]
            with TemporaryDirectory() as folder:
                mesh = Path(folder) / "drawn.glb"
                write_mesh(best.judged.scene, mesh)
                read = read_shape(mesh, ShapeOptions(None, find_floor=True, unit="m"))
            yield {
                "model": model,
                "says": best.judged.verdict.state.value,
                "degree": round(best.judged.verdict.degree, 2),
                "least": round(min(hard), 2),
                "as mesh": bench.judge(read, {}).verdict.state.value,
                "judged": judged,
                "seconds": round(seconds, 1),
                "form": best.form.name,
            }
