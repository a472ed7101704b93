"""The line drawing of one picture: its edges, cut at the vertices that lie on them."""

from itertools import pairwise

import numpy as np

from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.image_vertices import ImageVertex
from facetlog.perception.line_drawing import LineDrawing
from facetlog.perception.types import FloatArray

# A line that passes a vertex by more than this share of its length on both sides ends elsewhere.
PASSING_SHARE = 0.2


def leaving(line: EdgeLine, uv: FloatArray) -> list[tuple[FloatArray, bool]]:
    """Far ends (2,) of the line as seen from a vertex on it, and whether the line runs that way."""
    along = float((uv - line.start) @ line.direction) / line.length
    ends = []
    if along < 1.0 - PASSING_SHARE:
        ends.append((line.end, True))
    if along > PASSING_SHARE:
        ends.append((line.start, False))
    return ends


def picture_drawing(
    vertices: tuple[ImageVertex, ...], lines: tuple[EdgeLine, ...]
) -> tuple[LineDrawing, tuple[int, ...]]:
    """The drawing, whose first points are the vertices, and which edge each of its lines is of.

    A line's direction is that of its edge, as uncertain as this is. Where an edge goes on beyond
    its last vertex, it ends in a point of its own.
    """
    points = [vertex.uv for vertex in vertices]
    pieces: dict[frozenset[int], tuple[int, int, int]] = {}
    for number, line in enumerate(lines):
        on = [i for i, vertex in enumerate(vertices) if number in vertex.lines]
        if not on:
            continue
        on.sort(key=lambda i: float((vertices[i].uv - line.start) @ line.direction))
        if any(not forward for _, forward in leaving(line, vertices[on[0]].uv)):
            points.append(line.start)
            on.insert(0, len(points) - 1)
        if any(forward for _, forward in leaving(line, points[on[-1]])):
            points.append(line.end)
            on.append(len(points) - 1)
        for a, b in pairwise(on):
            pieces.setdefault(frozenset((a, b)), (a, b, number))
    found = np.array(list(pieces.values()), dtype=np.intp).reshape(-1, 3)
    along = np.array([lines[k].direction for k in found[:, 2]]).reshape(-1, 2)
    sds = np.sqrt([float(lines[k].cov[1, 1]) for k in found[:, 2]])
    # v runs down: counter-clockwise as one sees it
    angles = np.arctan2(-along[:, 1], along[:, 0])
    drawing = LineDrawing(np.array(points).reshape(-1, 2), found[:, :2], angles, sds)
    return drawing, tuple(found[:, 2].tolist())
