"""What a depth sensor at one place sees of a mesh that stands on a floor, noise and all.

The sensor is a Kinect of the first kind at 320 x 240: focal length and base by its calibrations
(K. Khoshelham, S. Elberink, "Accuracy and Resolution of Kinect Depth Data", 2012), disparity in
eighths of a pixel, and along the line of sight the noise of C. Nguyen, S. Izadi, D. Lovell,
"Modeling Kinect Sensor Noise", 2012.
"""

from dataclasses import dataclass

import numpy as np
import shapely
import trimesh
from numpy.typing import NDArray

from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.types import FloatArray

WIDTH, HEIGHT, FOCAL_PX = 320, 240, 292.5
BASE_M, DISPARITY_STEP_PX = 0.075, 0.125
LONGEST_M = 0.5
"""Things are as long as that: some hundred pixels."""
AWAY_M = 1.2
LOWEST_DEG, HIGHEST_DEG = 20.0, 55.0  # where the sensor is above the thing
SAMPLES_A_PIXEL = 12  # of the surface, so that none of it is seen through
# What lies so far behind a box's side is seen to: its noise, and a step of disparity 1.5 m away.
SDS, BLUR_M = 3.0, 1.5**2 * DISPARITY_STEP_PX / (FOCAL_PX * BASE_M)
FLOOR_SIZES = 1.5  # how far the floor reaches from the middle, in the longest side: what it sees


def single_view(
    mesh: Mesh, up: FloatArray, seed: int, *, name: str, place: bool, fine: int = 1
) -> Cloud:
    """Return the cloud of one view from a place by chance; `place` says whether the cloud has that.

    The thing is brought to its size (m) first; the floor is its lowest level along `up` (3,). With
    `fine` there are so many times more pixels each way.
    """
    generator = np.random.default_rng(seed)
    view = _view(mesh, up, generator, fine)
    ends = np.isfinite(view.depth)
    z = _measured(view.depth[ends], generator)
    found = view.eye + view.lines[ends] * z[:, None]
    seen_from = np.tile(view.eye, (len(found), 1)) if place else None
    return Cloud.of(found, name=name, seen_from=seen_from)


def measure_beyond_box(mesh: Mesh, up: FloatArray, seed: int) -> float:
    """Return the share of what that view shows of the thing that lies behind the sides and the top
    of the least upright box round it, by more than the sensor's noise; the floor's edge not
    counted.

    Where it is 0 nobody can tell from the view that the thing is no box.
    """
    view = _view(mesh, up, np.random.default_rng(seed))
    points = view.eye + view.lines[view.of_thing] * view.depth[view.of_thing, None]
    heights = points @ up
    unsure = np.asarray(SDS * _noise_sd(view.depth[view.of_thing]) + BLUR_M)
    above = heights > unsure
    if not above.any():
        return 0.0
    points, heights, unsure = points[above], heights[above], unsure[above]
    right, ahead = _axes(up, view.eye)[0], np.cross(up, _axes(up, view.eye)[0])
    plan = shapely.points(points @ right, points @ ahead)
    rim = shapely.boundary(shapely.oriented_envelope(shapely.multipoints(plan)))
    behind = np.minimum(shapely.distance(rim, plan), heights.max() - heights)
    return float((behind > unsure).mean())


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    # Where the sensor is (3,), what a metre of depth is in each pixel (h w, 3), how deep what it
    # sees is (h w,), infinite where nothing is, and whether that is the thing.
    eye: FloatArray
    lines: FloatArray
    depth: FloatArray
    of_thing: NDArray[np.bool_]


def _view(mesh: Mesh, up: FloatArray, generator: np.random.Generator, fine: int = 1) -> _View:
    points = _resized(mesh, up)
    eye = _eye(up, generator)
    samples = _surface(points, mesh, eye, generator, fine)
    axes = _axes(up, eye)
    lines = _sight_lines(fine) @ axes
    depth = np.full(len(lines), np.inf)
    pixel, away = _pixels(samples, eye, axes, fine)
    np.minimum.at(depth, pixel, away)
    floor = _floor_depth(lines, eye, up)
    return _View(eye, lines, np.minimum(depth, floor), np.isfinite(depth) & (depth < floor))


def _resized(mesh: Mesh, up: FloatArray) -> FloatArray:
    """Return the vertices with the thing's footing at the origin's level, above it, in metres."""
    used = mesh.vertices[np.unique(mesh.triangles)]
    low, high = used.min(axis=0), used.max(axis=0)
    points = (mesh.vertices - (low + high) / 2.0) * LONGEST_M / float((high - low).max())
    level: FloatArray = points - float((points[np.unique(mesh.triangles)] @ up).min()) * up
    return level


def _eye(up: FloatArray, generator: np.random.Generator) -> FloatArray:
    first = np.cross(up, np.eye(3)[int(np.abs(up).argmin())])
    first /= np.linalg.norm(first)
    around = generator.uniform(0.0, 2.0 * np.pi)
    over = np.deg2rad(generator.uniform(LOWEST_DEG, HIGHEST_DEG))
    level = np.cos(around) * first + np.sin(around) * np.cross(up, first)
    eye: FloatArray = AWAY_M * (np.cos(over) * level + np.sin(over) * up)
    return eye


def _surface(
    points: FloatArray, mesh: Mesh, eye: FloatArray, generator: np.random.Generator, fine: int
) -> FloatArray:
    solid = trimesh.Trimesh(points, mesh.triangles, process=False)
    pixel_m = float(np.linalg.norm(eye)) / (fine * FOCAL_PX)
    count = int(np.clip(SAMPLES_A_PIXEL * solid.area / pixel_m**2, 1_000, 2_000_000))
    found, _ = trimesh.sample.sample_surface(solid, count, seed=generator)
    return np.asarray(found, dtype=np.float64)


def _axes(up: FloatArray, eye: FloatArray) -> FloatArray:
    """Return the sensor's right, down and forward (3, 3), as rows; it looks at the origin."""
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(forward, right), forward])


def _sight_lines(fine: int) -> FloatArray:
    """Return what a metre of depth is in each pixel (h w, 3), along the sensor's axes."""
    width, height, focal = fine * WIDTH, fine * HEIGHT, fine * FOCAL_PX
    row, column = np.divmod(np.arange(width * height), width)
    across = (column - (width - 1) / 2.0) / focal
    down = (row - (height - 1) / 2.0) / focal
    return np.column_stack([across, down, np.ones(width * height)])


def _pixels(
    points: FloatArray, eye: FloatArray, axes: FloatArray, fine: int
) -> tuple[Indices, FloatArray]:
    """Return pixel and depth of the points in view."""
    width, height, focal = fine * WIDTH, fine * HEIGHT, fine * FOCAL_PX
    x, y, z = axes @ (points - eye).T
    column = np.rint(focal * x / z + (width - 1) / 2.0).astype(np.intp)
    row = np.rint(focal * y / z + (height - 1) / 2.0).astype(np.intp)
    there = (z > 0.0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    return (row * width + column)[there], z[there]


def _floor_depth(seen: FloatArray, eye: FloatArray, up: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore"):
        depth = -float(eye @ up) / (seen @ up)
    depth = np.where(depth > 0.0, depth, np.inf)
    with np.errstate(invalid="ignore"):
        reach = np.linalg.norm(eye + seen * depth[:, None], axis=1)
    within: FloatArray = np.where(reach <= FLOOR_SIZES * LONGEST_M, depth, np.inf)
    return within


def _measured(depth: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Return depths (n,) as the sensor gives them."""
    noisy = depth + generator.normal(size=len(depth)) * _noise_sd(depth)
    disparity = FOCAL_PX * BASE_M / noisy
    steps = np.maximum(np.rint(disparity / DISPARITY_STEP_PX), 1.0)
    measured: FloatArray = FOCAL_PX * BASE_M / (steps * DISPARITY_STEP_PX)
    return measured


def _noise_sd(depth: FloatArray) -> FloatArray:
    """Return the noise of depths (n,), metres, along the line of sight."""
    return np.asarray(0.0012 + 0.0019 * (depth - 0.4) ** 2)
