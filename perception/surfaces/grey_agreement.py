"""How far the regions of one grey in a picture are the faces that were found in 3-D."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.drawing.hidden_surface import hidden_surface
from facetlog.perception.types import View

# A region is a face's own where they share more than this of what either covers: no region can be
# that of two faces.
OWN_SHARE = 0.5
# Of the faces' pixels in the picture, below which a face is a sliver that shows no grey of its own.
LEAST_SHARE = 0.02


@dataclass(frozen=True, eq=False, slots=True)
class GreyAgreement:
    """`faces` are those in sight (indices), `own` tells which have a region of their own, and
    `overlap` how much of face and region together both cover, at best.

    `rand` is the adjusted Rand index (Hubert and Arabie 1985) of regions and faces over the pixels
    that belong to both: 1 where they are the same parts, 0 as by chance; None without such pixels.
    """

    faces: tuple[int, ...]
    own: tuple[bool, ...]
    overlap: tuple[float, ...]
    rand: float | None


def grey_agreement(labels: NDArray[np.int32], scene: Scene, view: View) -> GreyAgreement:
    """Compare regions (H, W), 0 outside the object, with the scene's faces as the view has them."""
    height, width = labels.shape
    foremost = hidden_surface(view, scene).face
    faces = cv2.resize(
        foremost.astype(np.float32), (width, height), interpolation=cv2.INTER_NEAREST
    ).astype(np.int64)
    count = np.zeros((int(labels.max()) + 1, len(scene.faces) + 1), dtype=np.int64)
    np.add.at(count, (labels.ravel(), faces.ravel() + 1), 1)
    of_face = count.sum(axis=0)[1:]
    seen = np.flatnonzero(of_face >= LEAST_SHARE * max(of_face.sum(), 1))
    overlap = []
    for face in seen:
        both = count[1:, face + 1]
        either = count[1:].sum(axis=1) + of_face[face] - both
        overlap.append(float((both / np.maximum(either, 1)).max(initial=0.0)))
    return GreyAgreement(
        tuple(seen.tolist()),
        tuple(share > OWN_SHARE for share in overlap),
        tuple(overlap),
        _compute_adjusted_rand(count[1:, 1:]),
    )


def _compute_adjusted_rand(count: NDArray[np.int64]) -> float | None:
    # Pairs of pixels that both partitions hold together, against what chance would have.
    def pairs(n: NDArray[np.int64]) -> float:
        return float((n * (n - 1) / 2).sum())

    total = pairs(count.sum(keepdims=True))
    if total == 0.0:
        return None
    together = pairs(count)
    rows, columns = pairs(count.sum(axis=1)), pairs(count.sum(axis=0))
    chance, most = rows * columns / total, (rows + columns) / 2
    return 1.0 if most == chance else (together - chance) / (most - chance)
