"""A scene with its lengths multiplied: by a unit, or by a scale that is itself uncertain."""

from dataclasses import replace

import numpy as np

from facetlog.perception.scene import Patch, Plane, Scene, SeenLattice, SightLines
from facetlog.perception.types import FloatArray, Pose

__all__ = ["in_metres"]


def in_metres(scene: Scene, metres: float, relative_sd: float = 0.0) -> Scene:
    """The scene in metres, `metres` for each unit of its lengths; covariances scale along.

    `relative_sd` is the standard deviation of that scale over the scale. It moves all points
    together, to and from the scene's centre c, which covariances of single points cannot say. So
    each gets 2 ρ² (p - c)(p - c)' in addition, and each plane as much of its offset: then a length
    across the centre has the sd that follows from the scale, ρ times the length, and one to a side
    of it has more.
    """
    points = scene.points * metres
    centre = points.mean(axis=0) if len(points) else np.zeros(3)
    away = 2.0 * relative_sd**2
    vertices = tuple(
        replace(
            vertex,
            point=point,
            cov=vertex.cov * metres**2 + away * np.outer(point - centre, point - centre),
        )
        for vertex, point in zip(scene.vertices, points, strict=True)
    )
    faces = tuple(
        replace(face, plane=_plane(face.plane, metres, centre, away)) for face in scene.faces
    )
    return replace(
        scene,
        vertices=vertices,
        faces=faces,
        metric=True,
        patches=tuple(_patch(patch, metres) for patch in scene.patches),
        poses=tuple(Pose(pose.rotation, pose.centre * metres) for pose in scene.poses),
        sights=tuple(SightLines(s.origin * metres, s.ends * metres, s.view) for s in scene.sights),
        lattices=tuple(_lattice(lattice, metres) for lattice in scene.lattices),
    )


def _plane(plane: Plane, metres: float, centre: FloatArray, away: float) -> Plane:
    units = np.array([1.0, 1.0, 1.0, metres])
    scaled = Plane(plane.normal, plane.offset * metres, plane.cov * np.outer(units, units))
    cov = scaled.cov.copy()
    cov[3, 3] += away * float(scaled.distance(centre)) ** 2
    return replace(scaled, cov=cov)


def _patch(patch: Patch, metres: float) -> Patch:
    return replace(patch, points=patch.points * metres, areas=patch.areas * metres**2)


def _lattice(lattice: SeenLattice, metres: float) -> SeenLattice:
    return replace(
        lattice,
        corner=lattice.corner * metres,
        steps=lattice.steps * metres,
        origins=lattice.origins * metres,
    )
