"""Flat and curved regions of closed sheets, the edges at which a solid is cut, and their frames.

A solid is cut along its concave edges. What hangs together without crossing one is a group: the
surface of a leg below a seat, or of a whole table whose legs are flush with its top.
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.flat_faces import cross
from facetlog.perception.pieces.exact.sheets import Sheets
from facetlog.perception.pieces.exact.wind_bodies import run_along
from facetlog.perception.ragged import Bools, Indices, joined, sum_by_group
from facetlog.perception.types import FloatArray

# Triangles that turn less are in one plane: exporters round the corners.
FLAT_DEG = 0.5
# A solid is cut where its surface turns inwards by more: less is the facets of a hollow.
CONCAVE_DEG = 12.0
# Facets of a round body turn less: a circle of twelve sides or more.
SMOOTH_DEG = 31.0
# Neighbouring facets of a round body are alike in area but for this factor.
ALIKE = 4.0
# They share sides at least so long, of the side of a square of their area.
SIDE_SHARE = 0.5
# A plane is known to so many times the distance within which corners are one.
PLANE_SLACK = 10.0
# Planes whose normals are within this angle of a frame's axes lie along it.
ALONG_DEG = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class Regions:
    """The region (m,) of each triangle; the regions' normals, offsets along them, and areas.

    Which of them are `curved` (r,); which of the sheets' pairs are `concave` (k,); and the `group`
    (m,) of triangles that no concave edge divides.
    """

    label: Indices
    normals: FloatArray
    offsets: FloatArray
    areas: FloatArray
    curved: Bools
    concave: Bools
    group: Indices


def find_regions(sheets: Sheets) -> Regions:
    """Return the regions of closed sheets."""
    one, two = sheets.pairs.T
    normals, corners = sheets.normals, sheets.points[sheets.triangles]
    both = cross(normals[one], normals[two])
    turn = np.degrees(
        np.arctan2(np.linalg.norm(both, axis=1), (normals[one] * normals[two]).sum(axis=1))
    )
    start = sheets.points[sheets.edges[:, 0]]
    # how far the corners of each lie off the other's plane, outwards
    off = [
        ((corners[b] - start[:, None]) * normals[a][:, None]).sum(axis=2)
        for a, b in ((one, two), (two, one))
    ]
    far = np.maximum(np.abs(off[0]).max(axis=1), np.abs(off[1]).max(axis=1))
    flat = (turn < FLAT_DEG) | ((far <= 4.0 * sheets.slack) & (turn < CONCAVE_DEG))
    count, label = joined(len(corners), sheets.pairs[flat])
    fits = _fit_planes(sheets, label, count)
    away = np.abs((corners * fits[0][label][:, None]).sum(axis=2) - fits[1][label][:, None])
    bent = np.zeros(count, dtype=np.bool_)
    np.logical_or.at(bent, label, away.max(axis=1) > PLANE_SLACK * sheets.slack)
    if bent.any():
        # a chain of small steps is no plane: each triangle by itself
        alone = bent[label]
        label = np.where(alone, count + np.arange(len(label)), label)
        label = np.unique(label, return_inverse=True)[1]
        count = int(label.max()) + 1
        fits = _fit_planes(sheets, label, count)
    areas = sum_by_group(label, sheets.areas, count)
    start, end = sheets.points[run_along(sheets.triangles[one], sheets.edges)]
    lengths = np.linalg.norm(end - start, axis=1)
    curved = _find_curved(label[sheets.pairs], turn, lengths, areas)
    concave = (turn > CONCAVE_DEG) & ((both * (end - start)).sum(axis=1) < 0.0)
    # two faces back to back with nothing between: parts that touch there
    concave |= turn > 180.0 - FLAT_DEG
    concave &= ~((turn < SMOOTH_DEG) & curved[label[one]] & curved[label[two]])
    group = joined(len(corners), sheets.pairs[~concave])[1]
    return Regions(label, *fits, areas, curved, concave, group)


def _fit_planes(sheets: Sheets, label: Indices, count: int) -> tuple[FloatArray, FloatArray]:
    """Return the unit normal and the offset of each region, weighed by area."""
    normals = sum_by_group(label, sheets.normals * sheets.areas[:, None], count)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    middles = sheets.points[sheets.triangles].mean(axis=1)
    heights = (middles * normals[label]).sum(axis=1)
    areas = sum_by_group(label, sheets.areas, count)
    return normals, sum_by_group(label, heights * sheets.areas, count) / areas


def _find_curved(links: Indices, turn: FloatArray, lengths: FloatArray, areas: FloatArray) -> Bools:
    """Return which regions are facets of a curved surface: with two smooth neighbours like them.

    `links` (k, 2) are the regions on both sides of edges with these turns and lengths (k,).
    """
    ratio = areas[links[:, 0]] / areas[links[:, 1]]
    alike = (links[:, 0] != links[:, 1]) & (turn < SMOOTH_DEG)
    alike &= (ratio < ALIKE) & (ratio > 1.0 / ALIKE)
    if not alike.any():
        return np.zeros(len(areas), dtype=np.bool_)
    ends, which = np.unique(np.sort(links[alike], axis=1), axis=0, return_inverse=True)
    # facets meet along their sides, not where one just touches the other
    along = np.bincount(which.ravel(), lengths[alike])
    ends = ends[along > SIDE_SHARE * np.sqrt(areas[ends].min(axis=1))]
    return np.asarray(np.bincount(ends.ravel(), minlength=len(areas)) >= 2)


def find_frame(
    normals: FloatArray, areas: FloatArray, leading: FloatArray | None = None
) -> FloatArray | None:
    """Return the frame (3, 3) of unit rows along which most area of flat regions lies, if any.

    Its first axis is that of most area, or of most `leading` area; the second has most of what is
    square to it.
    """
    first = _find_main(normals, areas if leading is None else leading)
    if first is None:
        return None
    square = np.abs(normals @ first) < np.sin(np.radians(ALONG_DEG))
    second = _find_main(normals[square], areas[square])
    if second is None:
        second = np.eye(3)[np.abs(first).argmin()]
    second = second - (second @ first) * first
    second /= np.linalg.norm(second)
    return np.stack([first, second, cross(first, second)])


def _find_main(normals: FloatArray, areas: FloatArray) -> FloatArray | None:
    """Return the mean direction of the most area of which the normals lie along one line."""
    if not areas.any():
        return None
    lead = np.argsort(-areas, kind="stable")[:64]
    along = np.abs(normals[lead] @ normals.T) > np.cos(np.radians(ALONG_DEG))
    best = int(lead[(along * areas).sum(axis=1).argmax()])
    same = np.abs(normals @ normals[best]) > np.cos(np.radians(ALONG_DEG))
    signs = np.sign(normals[same] @ normals[best])
    mean: FloatArray = (normals[same] * (areas[same] * signs)[:, None]).sum(axis=0)
    return mean / np.linalg.norm(mean)


def find_along(frame: FloatArray, normals: FloatArray) -> Indices:
    """Return the axis of the frame along which each normal (r, 3) lies, else -1."""
    turned = np.abs(normals @ frame.T)
    return np.where(
        turned.max(axis=1) > np.cos(np.radians(ALONG_DEG)), turned.argmax(axis=1), -1
    ).astype(np.int64)
