"""Junction types as marks of vertices that position labels do not distinguish.

Section 5.3 of the paper: where "more than one vertex in an image has the same label [...]
additional junction labeling scheme needs to be adopted", and names Waltz's. A junction has the same
type in pictures that show the same side of the object; from another side it has another one.
"""

from collections import Counter
from dataclasses import replace

from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.picture_drawing import picture_drawing
from facetlog.perception.detection.block_front_end.position_labels import LabelledVertex


def with_junctions(
    labelled: tuple[LabelledVertex, ...], lines: tuple[EdgeLine, ...], quarters: int | None
) -> tuple[LabelledVertex, ...]:
    """The vertices of one picture; those without a label get a mark that no other one has.

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
