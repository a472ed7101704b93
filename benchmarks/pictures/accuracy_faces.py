"""How much of the flat surface that pictures show becomes faces, and how much of these is true?

Third-party sets of pictures of furniture under FACETLOG_DATA, each with its true mesh and with the
program that measures a scene by it; without them, or without what that program needs (embreex), the
benchmark is skipped. Recall: share of the visible flat area that a face covers within 3 degrees and
1 % of the thing's diagonal, of the thing and of the cuboids beside it. Precision: share of the
faces' area, ground and walls left out, that lies on true surface.
"""

import sys
import time
from importlib import util
from pathlib import Path
from types import ModuleType

import numpy as np

from benchmarks.common import Cell, Report, Row, Settings, Table, find_data_set, hash_tree
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.reconstruct import reconstruct

NAME = "accuracy_faces"
SETS = "pictures"
PROGRAM = "evaluate_pictures.py"


def measure(settings: Settings) -> Report:
    """Measure all sets, or the first so many of them."""
    folder = find_data_set(SETS)
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    if util.find_spec("embreex") is None:
        return Report(NAME, skipped=f"{PROGRAM} needs the package embreex")
    evaluation = _evaluation(folder.parent / PROGRAM)
    sets = sorted(path for path in folder.iterdir() if (path / "ground_truth.json").exists())
    sets = sets[: settings.number(len(sets))]
    rows, results = [], []
    for path in sets:
        views = read_views(path)
        before = time.process_time()
        scene = reconstruct(views.views, name=path.name, up=views.up, metric=views.metric)
        seconds = time.process_time() - before
        result = evaluation.evaluate(path, _outlines(scene))
        results.append({**result, "seconds": seconds})
        rows.append(_row(path.name, results[-1]))
    return Report(
        NAME,
        (Table("All sets", (_mean(results),)), Table("Each set", tuple(rows))),
        {"sets": len(sets), "data": hash_tree(folder)},
    )


def _evaluation(path: Path) -> ModuleType:
    spec = util.spec_from_file_location("evaluate_pictures", path)
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look themselves up
    spec.loader.exec_module(module)
    return module


def _outlines(scene: Scene) -> list[np.ndarray]:
    points = scene.points
    return [points[list(face.outline)] for face in scene.faces]


def _row(name: str, result: dict[str, float]) -> Row:
    return {"set": name, "label": str(result["label"]), **_figures(result)}


def _figures(result: dict[str, float]) -> dict[str, Cell]:
    keys = ("recall", "boxes", "precision", "ground")
    figures: dict[str, Cell] = {
        key: None if np.isnan(result[key]) else round(float(result[key]), 3) for key in keys
    }
    return {**figures, "faces": int(result["faces"]), "CPU s": round(result["seconds"], 1)}


def _mean(results: list[dict[str, float]]) -> Row:
    true, wrong = (sum(result[key] for result in results) for key in ("true", "wrong"))
    means = {
        key: float(np.nanmean([result[key] for result in results]))
        for key in ("recall", "boxes", "ground", "faces", "seconds")
    }
    return _figures({**means, "precision": true / (true + wrong)})
