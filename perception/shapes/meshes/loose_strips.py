"""Loose parts of a mesh that are too narrow to be a surface of it, where they are many.

Repair tools and scanners leave slivers behind, by the hundred thousand. Each would be an object
with two faces of its own, compared with every other one; of so many no facts are made.
"""

from dataclasses import replace

import numpy as np

from facetlog.perception.ragged import group_sums
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.shapes.meshes.clean_mesh import (
    MOST_LOST,
    Surface,
    boxes_round,
    clean_mesh,
)
from facetlog.perception.shapes.meshes.mesh_sides import SPACING_SHARE

__all__ = ["MANY_PARTS", "without_loose_strips"]

MANY_PARTS = 1_000
"""Parts that share no corner with others. With two faces each more have too many for facts
(most_faces.py)."""


def without_loose_strips(surface: Surface) -> Surface:
    """The surface, of which narrow loose parts are left out if there are many parts.

    They are open, and narrower than its samples lie apart. Where they are most of it, they stay.
    """
    count = int(surface.bodies.max()) + 1
    if count <= MANY_PARTS:
        return surface
    low, high = boxes_round(surface.corners, surface.bodies, count)
    areas = group_sums(surface.bodies, surface.areas, count)
    # Of a triangle that is the height on its longest side; of a box much more than any width.
    widths = 2.0 * areas / np.sqrt(((high - low) ** 2).sum(axis=1))
    is_open = np.bincount(surface.bodies, ~surface.closed, minlength=count) > 0
    strips = is_open & (widths < SPACING_SHARE * surface.size)
    if not strips.any():
        return surface
    left = strips[surface.bodies]
    share = float(surface.areas[left].sum() / surface.areas.sum())
    if share > MOST_LOST:
        return surface
    line = (
        f"{int(strips.sum()):,} loose parts narrower than {SPACING_SHARE:.1%} of the mesh were "
        f"left out, {100.0 * share:.2g}% of its surface"
    )
    mesh = Mesh(
        surface.points + surface.centre,
        surface.triangles[~left],
        name=surface.name,
        step=surface.step,
    )
    rest = clean_mesh(mesh)
    return replace(rest, warnings=(*surface.warnings, *rest.warnings, line))
