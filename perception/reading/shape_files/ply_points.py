"""Points of a PLY file: its vertices, in text or binary of either byte order, with lists or not."""

from itertools import chain
from typing import BinaryIO

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.ply_rows import (
    PlyBytes,
    PlyText,
    find_rows,
    parse_ply_header,
)
from facetlog.perception.reading.shape_files.point_table import (
    NORMALS,
    PLACE,
    PointTable,
    columns_of,
)

__all__ = ["read_ply_points"]

WANTED = {*PLACE, *chain.from_iterable(NORMALS)}


def read_ply_points(file: BinaryIO, name: str, most: int) -> PointTable:
    """The vertices of a PLY; InputError where it is damaged or has more than `most`."""
    order, elements, body = parse_ply_header(file.read(), name)
    vertices = next((element for element in elements if element.name == "vertex"), None)
    if vertices is None:
        raise InputError(f"{name}: has no vertices; export the cloud again")
    if vertices.count > most:
        raise InputError(f"{name}: has {vertices.count} points, more than {most}; thin the cloud")
    source = PlyBytes(body) if order else PlyText(body, name)
    place = 0
    for element in elements[: elements.index(vertices)]:
        place = find_rows(source, element, place, name).end
    rows = find_rows(source, vertices, place, name)
    fields = [
        field
        for field in vertices.properties
        if field.count_kind is None and field.name.lower() in WANTED
    ]
    columns = [source.values(rows.starts[field.name], field.kind) for field in fields]
    table = np.column_stack(columns) if columns else np.zeros((vertices.count, 0))
    return columns_of(name, tuple(field.name for field in fields), table)
