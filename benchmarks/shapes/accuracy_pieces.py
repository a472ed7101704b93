"""Are the solid pieces of a mesh the parts that the thing was built of?

Things of wood in 16 families, every length varied by a fifth, in random frames, subdivided up to
twice; as one union (where manifold3d is installed), as bodies with shared vertices, and as bodies
of their own. As built: as many pieces as parts, each overlapping its part by most of its box.
"""

import statistics
import time
from importlib.util import find_spec

import numpy as np
from scipy.optimize import linear_sum_assignment

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.shapes.built_things import FAMILIES, Parts, iter_variants, list_builds
from facetlog.perception.pieces.exact.cut_pieces import CutPieces
from facetlog.perception.pieces.exact.find_pieces import find_solid_pieces
from facetlog.perception.types import FloatArray

NAME = "accuracy_pieces"
VARIANTS = 200
# Boxes of a part and its piece overlap by at least this share of both: joints may be cut otherwise.
OVERLAP = 0.6


def is_as_built(parts: Parts, found: CutPieces, turn: FloatArray) -> bool:
    """Return whether pieces in a frame turned by `turn` (3, 3) are the parts, one by one."""
    if len(found.pieces) != len(parts):
        return False
    a = np.array([part.bounds for part in parts])
    b = np.array([[p.min(axis=0), p.max(axis=0)] for p in (x.hull @ turn for x in found.pieces)])
    sides = np.minimum(a[:, None, 1], b[None, :, 1]) - np.maximum(a[:, None, 0], b[None, :, 0])
    common = np.clip(sides, 0.0, None).prod(axis=2)
    volumes = [np.ptp(each, axis=1).prod(axis=1) for each in (a, b)]
    overlap = common / (volumes[0][:, None] + volumes[1] - common)
    return bool(overlap[linear_sum_assignment(-overlap)].min() >= OVERLAP)


def measure(settings: Settings) -> Report:
    """Measure every family; the number of seeds is that of variants of each."""
    ways = ["joined", "separate"] + ["union"] * (find_spec("manifold3d") is not None)
    rows = [_measure_family(family, settings.seeds(VARIANTS), ways) for family in FAMILIES]
    notes = ("Wanted: 98 % as built in every family. Unions are measured with manifold3d alone.",)
    return Report(
        NAME,
        (Table("Pieces as built", tuple(rows)),),
        {"variants": settings.number(VARIANTS)},
        notes,
    )


def _measure_family(family: str, seeds: range, ways: list[str]) -> Row:
    row: dict[str, float | str | None] = {"family": family}
    times, triangles = [], []
    for way in ways:
        right = 0
        for parts, points, faces, turn in iter_variants(family, seeds, way):
            start = time.process_time()
            found = find_solid_pieces(points, faces)
            times.append(1e3 * (time.process_time() - start))
            triangles.append(len(faces))
            right += any(is_as_built(each, found, turn) for each in list_builds(family, parts))
        row[way] = round(right / len(seeds), 3)
    row["union"] = row.get("union")
    row |= {"triangles": statistics.median(triangles), "ms": round(statistics.median(times))}
    return row | {"most ms": round(max(times))}
