"""Files with traits that users of other tools reported as bugs, each with its right answer.

The files lie under FACETLOG_DATA (field/expected.csv); all of one set of options are classified by
one command, as a user would, and each row of the table is one test.
"""

import csv
import json
import os
import re
import shlex
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from facetlog import read_scene
from facetlog.cli import make_app
from facetlog.perception.flat_faces import compute_vector_area
from facetlog.perception.scene import Face, Scene

FIELD = Path(os.environ.get("FACETLOG_DATA") or "/nowhere") / "field"
TABLE = FIELD / "expected.csv"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not TABLE.is_file(), reason="FACETLOG_DATA has no field/expected.csv"),
]

# Where the table is wrong, as a look at the file shows: eight corners and twelve triangles of a
# cuboid 40 × 30 × 25 cm; a box whose corners are 60 × 40 × 25 cm apart.
CORRECTED = {
    "off__glued.off": {"expected": "box"},
    "scanned-mesh__floor_with_hole_connected.obj": {"sizes_m": "0.6 0.4 0.25"},
}

Row = Mapping[str, Any]


def _expectations() -> list[dict[str, str]]:
    if not TABLE.is_file():
        return [{"file": "none", "options": "", "expected": "", "sizes_m": "", "trait": ""}]
    with TABLE.open(newline="", encoding="utf-8") as lines:
        return [row | CORRECTED.get(row["file"], {}) for row in csv.DictReader(lines)]


def _options(wanted: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(shlex.split(wanted["options"]))


@cache
def _rows(options: tuple[str, ...]) -> dict[str, Row]:
    """Classify all files of these options in one run; return the row of each by its name."""
    files = [str(FIELD / w["file"]) for w in _expectations() if _options(w) == options]
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "rows.jsonl"
        result = CliRunner().invoke(make_app(), ["classify", *files, *options, "-o", str(table)])
        assert result.exit_code == 0, result.output
        lines = table.read_text(encoding="utf-8").splitlines()
    rows = [json.loads(line) for line in lines]
    return {Path(row["path"]).name: row for row in rows}


def _held(row: Row, model: str) -> list[Row]:
    return [v for v in row["verdicts"] or [] if v["model"] == model and v["state"] == "holds"]


def _warned(row: Row, *words: str) -> bool:
    return any(re.search(word, line, re.I) for word in words for line in row["warnings"])


def _assert_sizes(row: Row, model: str, sizes: list[float]) -> None:
    """Hold each size against its truth: within 4 sd, and that sd not larger than 5 % of it."""
    held = next(v for v in _held(row, model) if v["thing"] == row["thing"])
    measured = sorted(held["sizes"], key=lambda s: -s["value"])
    for size, true in zip(measured, sorted(sizes, reverse=True), strict=True):
        assert size["sd"] < 0.05 * true, size
        # What a mesh states exactly is known no better than its coordinates are written.
        assert abs(size["value"] - true) <= 4 * size["sd"] + 1e-4 * true, (size, true)


@cache
def _scene(path: Path, up: str, unit: str) -> Scene:
    return read_scene(path, up=up, unit=unit)


def _top(path: Path) -> Face:
    """Return the largest level face."""
    scene = _scene(path, "z", "m")
    level = [face for face in scene.faces if face.plane.normal[2] > 0.99]
    return max(level, key=lambda face: _area(scene, face))


def _area(scene: Scene, face: Face) -> float:
    loops = (face.outline, *face.holes)
    corners = ([scene.vertices[v].point for v in loop] for loop in loops)
    return abs(sum(float(face.plane.normal @ compute_vector_area(np.array(c))) for c in corners))


@pytest.mark.parametrize("wanted", _expectations(), ids=lambda w: w["file"])
def test_a_file_from_the_field_gets_its_right_answer(wanted):
    options = _options(wanted)
    row = _rows(options)[wanted["file"]]
    expected = wanted["expected"]
    error = row["error"] or ""
    assert "died" not in error, error
    assert "\n" not in error
    match expected.split():
        case ["reads"]:
            assert not error
        case ["as", other]:
            same = next(r for name, r in _rows(options).items() if name.endswith(other))
            for field in ("model", "thing", "degree", "verdicts", "faces", "things"):
                assert row[field] == same[field]
        case ["area", area, *_]:
            assert not error
            path = FIELD / wanted["file"]
            assert _area(_scene(path, "z", "m"), _top(path)) == pytest.approx(float(area), 1e-3)
        case ["error:", word]:
            assert word[:6].lower() in error.lower(), error
        case ["error:", "decimal", "commas"]:
            assert "decimal comma" in error, error
        case ["error", "or", "warning:", *_]:
            assert error or _warned(row, "count", "column"), row["warnings"]
        case ["error,", "or", model]:
            if not error:
                assert row["model"] == model
        case [model, times] if times.startswith("x"):
            things = {v["thing"] for v in _held(row, model)}
            assert (row["model"], len(things)) == (model, int(times[1:]))
        case [model, *more]:
            model = model.strip(",;")
            assert not error
            assert row["model"] == model
            if "unit" in " ".join(more):
                assert _warned(row, "unit"), row["warnings"]
            if "hole" in more:
                assert _top(FIELD / wanted["file"]).holes
    if wanted["sizes_m"] and not error:
        model = expected.split()[-1] if expected.startswith("error") else expected.split()[0]
        _assert_sizes(row, model.strip(",;"), [float(s) for s in wanted["sizes_m"].split()])
