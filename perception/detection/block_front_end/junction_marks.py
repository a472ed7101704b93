"""Junction types as marks of vertices that position labels do not distinguish.

Section 5.3 of the paper: where "more than one vertex in an image has the same label [...]
additional junction labeling scheme needs to be adopted", and names Waltz's. A junction has the same
type in pictures that show the same side of the object; from another side it has another one.
"""

from collections import Counter
from dataclasses import replace
from itertools import pairwise

import numpy as np

from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.image_vertices import ImageVertex
from facetlog.perception.detection.block_front_end.position_labels import LabelledVertex
from facetlog.perception.line_drawing import LineDrawing


def picture_drawing(
    vertices: tuple[ImageVertex, ...], lines: tuple[EdgeLine, ...]
) -> tuple[LineDrawing, tuple[int, ...]]:
    """Return the drawing, whose first points are the vertices, and which edge each of its lines is
    of.

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
        if any(not forward for _, forward in line.leaving(vertices[on[0]].uv)):
            points.append(line.start)
            on.insert(0, len(points) - 1)
        if any(forward for _, forward in line.leaving(points[on[-1]])):
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


def with_junctions(
    labelled: tuple[LabelledVertex, ...], lines: tuple[EdgeLine, ...], quarters: int | None
) -> tuple[LabelledVertex, ...]:
    """Return the vertices of one picture; those without a label get a mark that no other one has.

    `quarters` says which side the picture shows: marks of one side can be compared.
    """
    if quarters is None or all(v.block_label is not None for v in labelled):
        return labelled
    drawing, _ = picture_drawing(tuple(v.vertex for v in labelled), lines)
    kinds = [
        None
        if vertex.block_label is not None or rays is None
        else (f"{vertex.position}@{quarters}", rays.type.value)
        for vertex, rays in zip(labelled, drawing.rays, strict=False)
    ]
    count = Counter(kinds)
    return tuple(
        replace(vertex, mark=kind if count[kind] == 1 else None)
        for vertex, kind in zip(labelled, kinds, strict=True)
    )
