"""Edges of a scene against the true ones of a ground_truth.json."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from facetlog.perception.scene import Scene
from facetlog.perception.types import FloatArray

# A found edge is a true one if each of its ends lies within this share of the edge's length.
END_SHARE = 0.15


@dataclass(frozen=True, eq=False)
class EdgeMatch:
    """`pairs` of found and true edges (indices), and all lengths, in the scene's unit."""

    pairs: tuple[tuple[int, int], ...]
    found_lengths: FloatArray
    true_lengths: FloatArray


def read_true_edges(path: Path) -> FloatArray:
    """True edges (n, 2, 3): the sides of all faces of the file, each once."""
    truth = json.loads(path.read_text())
    loops = [face["vertices"] for face in truth["faces"]]
    pairs = {tuple(sorted(p)) for f in loops for p in zip(f, f[1:] + f[:1], strict=True)}
    return np.array(truth["vertices"], dtype=np.float64)[np.array(sorted(pairs))]


def match_edges(scene: Scene, true: FloatArray) -> EdgeMatch:
    """The scene's edges and the true ones (n, 2, 3) that agree in both ends, each at most once."""
    ends = [(scene.vertices[e.start].point, scene.vertices[e.end].point) for e in scene.edges]
    found = np.array(ends).reshape(-1, 2, 3)
    true_lengths = np.linalg.norm(true[:, 1] - true[:, 0], axis=1)
    # The farther end decides, whichever way round an edge is written.
    cost = np.minimum(
        *(
            np.linalg.norm(found[:, None] - way[None], axis=-1).max(axis=-1)
            for way in (true, true[:, ::-1])
        )
    )
    share = cost / true_lengths
    rows, columns = linear_sum_assignment(np.minimum(share, 10.0 * END_SHARE))
    return EdgeMatch(
        tuple(
            (int(r), int(c)) for r, c in zip(rows, columns, strict=True) if share[r, c] < END_SHARE
        ),
        np.linalg.norm(found[:, 1] - found[:, 0], axis=1),
        true_lengths,
    )
