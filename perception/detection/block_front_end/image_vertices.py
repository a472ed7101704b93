"""2-D vertices: where straight edges of one picture meet, to a fraction of a pixel.

A vertex is where edges end together (L, arrow and Y junctions) or one ends on another (T), with
at least the paper's 30 degrees between two of them.
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.detection.block_front_end.edge_lines import (
    SLOPE_CHANGE,
    EdgeLine,
    cut_straight_pieces,
    extend_line,
    find_edge_pixels,
    fit_edge_line,
    trace_chains,
)
from facetlog.perception.types import FloatArray, Image

# Edges shorter than this share of the root of the region's area are no sides of the object (a
# block's shortest visible side is a third of its size at worst), nor shorter than LEAST_EDGE_PX:
# two supports of the slope, one for each end.
LEAST_EDGE_SHARE = 0.08
LEAST_EDGE_PX = 10.0
# Two pieces are one edge if they are parallel within this angle and within this distance across
# (sd of the two lines where they are nearest, and an absolute part in px), and the gap is small.
SAME_LINE_ANGLE = np.deg2rad(4.0)
SAME_LINE_PX = 0.7
SAME_LINE_SD = 4.0
# Edges are cut short at both ends by the slope's support and by the smoothing, px; a vertex lies
# within this reach of the ends of its edges. Larger objects lose more at faint junctions.
REACH_PX = 8.0
REACH_SHARE = 0.05
# The first fit of a piece only starts the drawing out, which is fitted anew.
FIRST_FIT_STEPS = 2
# Crossings nearer than this are one vertex, px and in sd.
SAME_VERTEX_PX = 3.0
# Chi-square of one line's distance from the vertex, 1 degree of freedom, .1 %.
LINE_GATE = 10.83
# Distance of a crossing from the picture's rim below which it is an artefact of the rim, px.
RIM_PX = 2.0


@dataclass(frozen=True, eq=False, slots=True)
class ImageVertex:
    """A 2-D vertex: pixel (2,), covariance (2, 2) in px², and the indices of its edge lines."""

    uv: FloatArray
    cov: FloatArray
    lines: tuple[int, ...]


def find_edge_lines(image: Image, mask: Image, noise: float) -> tuple[EdgeLine, ...]:
    """Find the straight edges in and round the localised region `mask`, longest first.

    `noise` is that of the picture in grey levels.
    """
    size = float(np.sqrt(np.count_nonzero(mask)))
    least = max(LEAST_EDGE_PX, LEAST_EDGE_SHARE * size)
    pieces = [
        piece
        for chain in trace_chains(find_edge_pixels(image, mask, noise), int(least))
        for piece in cut_straight_pieces(chain, least)
    ]
    lines: list[EdgeLine] = []
    for piece in sorted(pieces, key=len, reverse=True):
        line = fit_edge_line(image, piece, noise, steps=FIRST_FIT_STEPS)
        # A longer piece of the same edge may have been drawn out over this one already.
        if line is None or any(_covers_edge(other, line) for other in lines):
            continue
        # It is drawn out to where its step ends, and refitted over that length.
        start, end = extend_line(image, line, noise)
        lines.append(_refitted(image, start, end, noise) or line)
    return merge_lines(image, tuple(lines), noise, _reach(size))


def _reach(size: float) -> float:
    return max(REACH_PX, REACH_SHARE * size)


def _refitted(image: Image, start: FloatArray, end: FloatArray, sd_grey: float) -> EdgeLine | None:
    """Return the line fitted between two ends, and reaching to their feet on it."""
    steps = np.linspace(0.0, 1.0, int(np.hypot(*(end - start))) + 2)[:, None]
    line = fit_edge_line(image, start + (end - start) * steps, sd_grey)
    if line is None:
        return None
    # The fit leaves the bent stretches at both ends out, alike, so its middle stays the middle.
    low, high = sorted(float((p - line.start) @ line.direction) for p in (start, end))
    return EdgeLine(
        line.start + low * line.direction,
        line.start + high * line.direction,
        line.cov,
        line.contrast,
    )


def _is_one_edge(a: EdgeLine, b: EdgeLine, gap: float) -> bool:
    """Return whether two lines (a the longer) are pieces of one edge, brighter on the same side."""
    if a.direction @ b.direction < np.cos(SAME_LINE_ANGLE):
        return False
    ends = np.array([(p - a.start) @ a.direction for p in (b.start, b.end)])
    if ends.min() > a.length + gap or ends.max() < -gap:
        return False
    nearest = b.start if abs(ends[0] - a.length / 2) < abs(ends[1] - a.length / 2) else b.end
    far = b.end if nearest is b.start else b.start
    for point, slack in ((nearest, 1.0), (far, 2.0)):
        across = abs(float((point - a.start) @ a.normal))
        sd = np.sqrt(a.compute_offset_variance(point) + b.compute_offset_variance(point))
        if across > slack * (SAME_LINE_PX + SAME_LINE_SD * sd):
            return False
    return True


def _covers_edge(long: EdgeLine, short: EdgeLine) -> bool:
    """Return whether the longer line is the same edge as the shorter and reaches over all of it."""
    along = [float((p - long.start) @ long.direction) for p in (short.start, short.end)]
    return min(along) >= 0 and max(along) <= long.length and _is_one_edge(long, short, 0.0)


def merge_lines(
    image: Image, lines: tuple[EdgeLine, ...], sd_grey: float, gap: float
) -> tuple[EdgeLine, ...]:
    """Return the lines with pieces of one edge joined and refitted over their common length."""
    todo = sorted(lines, key=lambda line: -line.length)
    done: list[EdgeLine] = []
    while todo:
        line = todo.pop(0)
        for other in todo:
            if not _is_one_edge(line, other, gap):
                continue
            along = [(p - line.start) @ line.direction for p in (other.start, other.end)]
            low, high = min(0.0, *map(float, along)), max(line.length, *map(float, along))
            ends = line.start + line.direction * np.array([[low], [high]])
            joined = _refitted(image, ends[0], ends[1], sd_grey)
            todo.remove(other)
            if joined is not None and joined.length >= line.length:
                line = joined
            todo.insert(0, line)
            break
        else:
            done.append(line)
    return tuple(sorted(done, key=lambda line: -line.length))


def _ends_near(line: EdgeLine, point: FloatArray, reach: float) -> bool:
    return bool(min(np.hypot(*(point - line.start)), np.hypot(*(point - line.end))) <= reach)


def _passes_point(line: EdgeLine, point: FloatArray) -> bool:
    along = float((point - line.start) @ line.direction)
    return 0.0 <= along <= line.length


def _meeting(
    lines: tuple[EdgeLine, ...], members: set[int], first: FloatArray
) -> tuple[FloatArray, FloatArray, set[int]] | None:
    """Return the vertex (2,), covariance and lines after lines that miss it are left out, or None.

    Covariance (sum n n^T / v)^-1 over the lines, v each line's variance at the vertex.
    """
    point = first
    used = set(members)
    while len(used) >= 2:
        information = np.zeros((2, 2))
        right = np.zeros(2)
        for i in used:
            n = lines[i].normal
            weight = 1.0 / lines[i].compute_offset_variance(point)
            information += weight * np.outer(n, n)
            right += weight * n * float(n @ lines[i].start)
        cov = np.asarray(np.linalg.inv(information), dtype=np.float64)
        point = cov @ right
        misses = {
            i: float(lines[i].normal @ (point - lines[i].start)) ** 2
            / lines[i].compute_offset_variance(point)
            for i in used
        }
        worst = max(sorted(misses), key=lambda i: misses[i])
        if len(used) == 2 or misses[worst] <= LINE_GATE:
            return point, cov, used
        used.discard(worst)
    return None


def _measure_widest_angle(lines: tuple[EdgeLine, ...], used: set[int]) -> float:
    """Return the largest angle (0..pi/2) between two of the lines."""
    directions = np.array([lines[i].direction for i in sorted(used)])
    return float(np.arccos(np.clip(np.abs(directions @ directions.T), 0.0, 1.0)).max())


def find_vertices(lines: tuple[EdgeLine, ...], mask: Image) -> tuple[ImageVertex, ...]:
    """Find the vertices where the lines meet, inside the picture, each once; best fixed first."""
    reach = _reach(float(np.sqrt(np.count_nonzero(mask))))
    height, width = mask.shape
    crossings: list[tuple[FloatArray, int, int]] = []
    for i, a in enumerate(lines):
        for j in range(i + 1, len(lines)):
            b = lines[j]
            if _measure_widest_angle(lines, {i, j}) < SLOPE_CHANGE:
                continue
            normals = np.array([a.normal, b.normal])
            point = np.linalg.solve(normals, [a.normal @ a.start, b.normal @ b.start])
            if not (RIM_PX <= point[0] <= width - 1 - RIM_PX):
                continue
            if not (RIM_PX <= point[1] <= height - 1 - RIM_PX):
                continue
            a_ends, b_ends = _ends_near(a, point, reach), _ends_near(b, point, reach)
            if (a_ends and (b_ends or _passes_point(b, point))) or (
                b_ends and _passes_point(a, point)
            ):
                crossings.append((point, i, j))
    groups: list[tuple[set[int], list[FloatArray]]] = []
    for point, i, j in crossings:
        for members, points in groups:
            if np.hypot(*(np.mean(points, axis=0) - point)) <= max(SAME_VERTEX_PX, reach / 2):
                members.update((i, j))
                points.append(point)
                break
        else:
            groups.append(({i, j}, [point]))
    vertices = []
    for members, points in groups:
        met = _meeting(lines, members, np.median(points, axis=0))
        if met is not None and _measure_widest_angle(lines, met[2]) >= SLOPE_CHANGE:
            vertices.append(ImageVertex(met[0], met[1], tuple(sorted(met[2]))))
    vertices.sort(key=lambda vertex: float(np.trace(vertex.cov)))
    kept: list[ImageVertex] = []
    for vertex in vertices:
        if all(np.hypot(*(vertex.uv - other.uv)) > SAME_VERTEX_PX for other in kept):
            kept.append(vertex)
    return tuple(kept)
