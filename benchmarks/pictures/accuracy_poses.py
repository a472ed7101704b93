"""How far may each pose be off on its own, or the lens, and what is left of that in the block?

The demo's tour of 24 views; each recorded pose is turned and shifted by normal errors, which the
views state or keep to themselves. The peer knows which pixels belong together, the size of the
errors and of the pixels' noise: scipy's least squares over all poses and corners. Wanted: a
box, with a NEES/3 of 1.5 at most. Lenses have another focal length than stated, or a distortion
that is not.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from benchmarks.common import Cell, Report, Row, Settings, Table
from benchmarks.pictures.recognition import (
    Run,
    Score,
    Shape,
    counted,
    get_true_block,
    in_metres,
    recognised,
    score,
    tour_views,
)
from facetlog.perception.types import FloatArray, PoseErrorKind, PoseErrors, View
from facetlog.pipeline import FrontEnd
from facetlog.robot.rendering.views import add_pose_noise
from facetlog.robot.rendering.worlds import INCH, make_world

NAME = "accuracy_poses"
SEEDS = 3
WORLD = "block"
# Degrees about each axis of the camera, millimetres along each axis of the world.
ERRORS = ((0.0, 0.0), (0.1, 1.0), (0.3, 5.0), (1.0, 10.0))
POSE_STREAM, PIXEL_STREAM = 3, 4  # apart from the world's own draws and the pictures' noise
# Times the true focal length is stated, and the k1 that is not.
LENSES = ((1.0, 0.0), (0.75, 0.0), (0.95, 0.0), (1.05, 0.0), (1.3, 0.0), (1.0, -0.2), (1.0, 0.1))
PIXEL_SD = 0.1
"""Of a corner for the peer, px: what those of the block's pictures have, about."""


def measure(settings: Settings) -> Report:
    """Measure all errors and seeds, stated and not."""
    seeds = settings.seeds(SEEDS)
    runs: dict[tuple[float, float, bool], list[Run]] = defaultdict(list)
    scores: dict[tuple[float, float, bool], list[Score]] = defaultdict(list)
    peers: dict[tuple[float, float], list[float]] = defaultdict(list)
    for seed in seeds:
        world = make_world(WORLD, seed)
        true = in_metres(WORLD, tour_views(world, seed))
        inches = get_true_block(world)
        shape = replace(inches, vertices=INCH * inches.vertices)
        for degrees, mm in ERRORS:
            rng = np.random.default_rng([seed, 0, POSE_STREAM])
            angle_sd, position_sd = float(np.radians(degrees)), mm / 1e3
            views = add_pose_noise(true.views, rng, position_sd=position_sd, angle_sd=angle_sd)
            cov = np.diag([position_sd**2] * 3 + [angle_sd**2] * 3)
            covs = np.tile(cov, (len(views), 1, 1))
            stated = PoseErrors(tuple(v.pose for v in views), covs, PoseErrorKind.INDEPENDENT)
            for errors in (None, stated) if degrees else (None,):
                key = degrees, mm, errors is not None
                run = recognised(replace(true, views=views, pose_errors=errors), FrontEnd.LINES)
                runs[key].append(run)
                if run.scene is not None:
                    centres = np.array([v.pose.centre for v in views])
                    scores[key].append(score(run.scene, shape, centres))
            rng = np.random.default_rng([seed, 0, PIXEL_STREAM])
            found = solve_peer_corners(true.views, views, shape, rng, position_sd, angle_sd)
            peers[degrees, mm].append(_rms(found - shape.vertices))
    rows = tuple(_row(key, runs[key], scores[key], peers[key[:2]]) for key in runs)
    lenses = tuple(_lens_row(stated, radial, seeds) for stated, radial in LENSES)
    return Report(
        NAME,
        (Table("Errors of each pose on its own", rows), Table("Lenses", lenses)),
        {"seeds": len(seeds), "first seed": seeds.start},
        (
            "Errors are in the world's frame, where all corners share what no picture shows.",
            "rms: root mean square over the seeds; NEES over all corners found.",
        ),
    )


def _row(
    key: tuple[float, float, bool],
    runs: Sequence[Run],
    scores: Sequence[Score],
    peers: Sequence[float],
) -> Row:
    degrees, mm, is_stated = key
    errors = [e for s in scores for e in s.vertex_errors]
    nees = [n for s in scores for n in s.vertex_nees]
    angles = [n for s in scores for n in s.angle_nees]
    sides = [abs(e / t) for s in scores for e, t in zip(s.edge_errors, s.edge_lengths, strict=True)]
    found: dict[str, Cell] = {
        "degrees": degrees,
        "mm": mm,
        "stated": "yes" if is_stated else "no",
        "answered": counted(run.outcome for run in runs),
        "corners": len(errors),
        "rms mm": round(1e3 * _rms(np.array(errors)[:, None]), 2) if errors else None,
        "peer's rms mm": round(1e3 * float(np.sqrt(np.mean(np.square(peers)))), 2),
        "NEES/3": round(float(np.mean(nees)), 2) if nees else None,
        "angles' NEES": round(float(np.mean(angles)), 2) if angles else None,
        "worst edge %": round(100 * max(sides), 2) if sides else None,
    }
    return found


def _lens_row(stated: float, radial: float, seeds: Sequence[int]) -> Row:
    runs, focal, bent, errors, nees = [], [], [], [], []
    for seed in seeds:
        world = make_world(WORLD, seed)
        true = in_metres(WORLD, tour_views(world, seed))
        inches = get_true_block(world)
        shape = replace(inches, vertices=INCH * inches.vertices)
        views = tuple(replace(_bent(v, radial), camera=v.camera.zoomed(stated)) for v in true.views)
        run = recognised(replace(true, views=views), FrontEnd.LINES)
        runs.append(run)
        if run.scene is None:
            continue
        lens = run.scene.lenses[0] if run.scene.lenses else None
        focal.append(stated * (1.0 if lens is None else lens.focal))
        bent.append(0.0 if lens is None else lens.radial)
        found = score(run.scene, shape, np.array([v.pose.centre for v in views]))
        errors += list(found.vertex_errors)
        nees += list(found.vertex_nees)
    row: dict[str, Cell] = {
        "focal length stated": stated,
        "k1 not stated": radial,
        "answered": counted(run.outcome for run in runs),
        "focal length found": round(float(np.mean(focal)), 4) if focal else None,
        "k1 found": round(float(np.mean(bent)), 3) if bent else None,
        "rms mm": round(1e3 * _rms(np.array(errors)[:, None]), 2) if errors else None,
        "NEES/3": round(float(np.mean(nees)), 2) if nees else None,
    }
    return row


def _bent(view: View, radial: float) -> View:
    """Return the view as a lens with this k1 takes it."""
    if not radial:
        return view
    height, width = view.image.shape
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.float64)
    straight = cv2.undistortPoints(
        grid.reshape(-1, 1, 2),
        view.camera.matrix,
        np.array([radial, 0.0, 0.0, 0.0]),
        P=view.camera.matrix,
    )
    u, v = np.moveaxis(straight.reshape(height, width, 2).astype(np.float32), -1, 0)
    image = cv2.remap(view.image, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return replace(view, image=np.asarray(image, dtype=np.uint8))


def _rms(errors: FloatArray) -> float:
    return float(np.sqrt((errors**2).sum(axis=-1).mean()))


def solve_peer_corners(
    true: Sequence[View],
    views: Sequence[View],
    shape: Shape,
    rng: np.random.Generator,
    position_sd: float,
    angle_sd: float,
) -> FloatArray:
    """Return the corners (n, 3) by least squares over poses and corners, from noisy pixels of the
    truth.

    A corner is seen where one of its faces looks to the camera; the prior of the poses is known.
    """
    count, corners = len(views), shape.vertices
    seen = np.zeros((count, len(corners)), np.bool_)
    for k, view in enumerate(true):
        for face in shape.seen_faces(view.pose.centre[None]):
            seen[k, list(shape.faces[face])] = True
    seen[:, seen.sum(axis=0) < 2] = False
    matrices = np.array([v.camera.matrix for v in views])

    def projected(rotations: FloatArray, centres: FloatArray, points: FloatArray) -> FloatArray:
        rays = (points[None] - centres[:, None]) @ rotations
        h = rays @ matrices.transpose(0, 2, 1)
        return np.asarray((h[..., :2] / h[..., 2:])[seen])

    rotations, places = (
        np.array([getattr(v.pose, part) for v in true]) for part in ("rotation", "centre")
    )
    uv = projected(rotations, places, corners)
    uv = uv + rng.normal(0.0, PIXEL_SD, uv.shape)
    given = np.array([v.pose.rotation for v in views])
    centres = np.array([v.pose.centre for v in views])
    # Exact poses have a prior too, that no pixel moves.
    sds = np.repeat([max(angle_sd, 1e-7), max(position_sd, 1e-7)], 3)

    def residuals(unknown: FloatArray) -> FloatArray:
        off = unknown[: 6 * count].reshape(count, 6)
        turned = given @ Rotation.from_rotvec(off[:, :3] * sds[:3]).as_matrix()
        points = unknown[6 * count :].reshape(-1, 3)
        pixels = projected(turned, centres + off[:, 3:] * sds[3:], points)
        return np.concatenate([((pixels - uv) / PIXEL_SD).ravel(), off.ravel()])

    start = np.concatenate([np.zeros(6 * count), corners.ravel()])
    found = least_squares(residuals, start, x_scale="jac").x[6 * count :].reshape(-1, 3)
    return np.where(seen.any(axis=0)[:, None], found, corners)
