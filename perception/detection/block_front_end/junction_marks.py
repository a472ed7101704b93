"""What tells vertices apart that position labels do not: the junctions that they are.

Section 5.3 of the paper: where "more than one vertex in an image has the same label [...]
additional junction labeling scheme needs to be adopted", and names Waltz's. A junction looks alike
in pictures that show the same side of the object; from another side it is another one.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.picture_drawing import picture_drawing
from facetlog.perception.detection.block_front_end.position_labels import LabelledVertex
from facetlog.perception.line_drawing import LineDrawing

__all__ = ["LineLabels", "with_junctions"]

LineLabels = Callable[[LineDrawing], Mapping[int, str]]
"""Labels of those lines of a drawing (by number) that have one, as rules/line_labels.pl gives."""


def with_junctions(
    labelled: tuple[LabelledVertex, ...],
    lines: tuple[EdgeLine, ...],
    quarters: int | None,
    line_labels: LineLabels | None = None,
) -> tuple[LabelledVertex, ...]:
    """The vertices of one picture; those without a label get a mark that no other one has.

    `quarters` says which side the picture shows: marks of one side can be compared. With
    `line_labels` they say what the lines are edges of, where the junction alone is not enough.
    """
    if quarters is None or all(v.block_label is not None for v in labelled):
        return labelled
    drawing, _ = picture_drawing(tuple(v.vertex for v in labelled), lines)
    known = {} if line_labels is None else line_labels(drawing)
    # What a vertex without a label is, first by the junction alone, then by its lines as well.
    kinds: list[tuple[str, ...]] = []
    for vertex, rays in zip(labelled, drawing.rays, strict=False):
        if vertex.block_label is not None or rays is None:
            kinds.append(())
        else:
            words = (known.get(line, "?") for line in rays.line.tolist())
            kinds.append((vertex.position, rays.type.value, *words))
    marked = []
    for vertex, kind in zip(labelled, kinds, strict=True):
        alone = next((n for n in (2, len(kind)) if _count(kinds, kind[:n]) == 1), None)
        among = f"{vertex.position}@{quarters}"
        mark = (among, " ".join(kind[1:alone])) if kind and alone is not None else None
        marked.append(replace(vertex, mark=mark))
    return tuple(marked)


def _count(kinds: list[tuple[str, ...]], begin: tuple[str, ...]) -> int:
    return sum(kind[: len(begin)] == begin for kind in kinds)
