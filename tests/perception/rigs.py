"""Cameras round the origin, with points between them and their pixels, of exact ground truth."""

import numpy as np

from facetlog.perception.types import Observation

PIXEL_SD = 0.5
INTRINSICS = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])


def ring(views, arc=2 * np.pi, distance=3.0):
    """Projections (V, 3, 4) of cameras on an arc, level 1.5 and looking to the middle."""
    projections = []
    for k in range(views):
        turn = arc * k / views
        c = np.array([distance * np.cos(turn), distance * np.sin(turn), 1.5 + 0.2 * np.sin(3 * k)])
        z = -c / np.linalg.norm(c)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        R = np.array([x, np.cross(z, x), z])
        projections.append(INTRINSICS @ np.column_stack([R, -R @ c]))
    return np.array(projections)


def project(projections, points):
    h = np.einsum("vij,nj->nvi", projections[:, :, :3], points) + projections[:, :, 3]
    return h[..., :2] / h[..., 2:]


def pictured(rng, count, projections, wrong=0.0, sd=PIXEL_SD):
    """Points (n, 3), noisy pixels (n, V, 2), covariances (n, V, 2, 2), wrong matches (n, V)."""
    points = rng.uniform(-0.3, 0.3, (count, 3))
    uv = project(projections, points)
    uv = uv + sd * rng.normal(size=uv.shape)
    bad = rng.random(uv.shape[:2]) < wrong
    uv[bad] = rng.uniform([100, 50], [540, 430], (int(bad.sum()), 2))
    cov = np.broadcast_to(sd**2 * np.eye(2), (*uv.shape, 2)).copy()
    return points, uv, cov, bad


def observations(uv, cov):
    return [Observation(v, uv[v], cov[v]) for v in range(len(uv))]


def moved(projections, rotation, shift, scale):
    """Return the cameras in a world turned, scaled and shifted: new = scale * R old + shift."""
    old_from_new = np.eye(4)
    old_from_new[:3, :3] = rotation.T / scale
    old_from_new[:3, 3] = -rotation.T @ shift / scale
    return projections @ old_from_new


def rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)
