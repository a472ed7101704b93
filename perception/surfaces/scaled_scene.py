"""A scene with its lengths multiplied: by a unit, or by a scale that is itself uncertain."""

from dataclasses import replace

import numpy as np

from facetlog.perception.scene import Patch, Plane, Scene, SeenLattice, SightLines
from facetlog.perception.types import Pose


def in_metres(scene: Scene, metres: float, relative_sd: float = 0.0) -> Scene:
    """Return the scene in metres, `metres` for each unit of its lengths; covariances scale along.

    `relative_sd` is the standard deviation of that scale over the scale. It moves all points
    together, which covariances of single points cannot say: the scene states it as `scale_sd`.
    """
    points = scene.points * metres
    vertices = tuple(
        replace(vertex, point=point, cov=vertex.cov * metres**2)
        for vertex, point in zip(scene.vertices, points, strict=True)
    )
    faces = tuple(replace(face, plane=_plane(face.plane, metres)) for face in scene.faces)
    return replace(
        scene,
        vertices=vertices,
        faces=faces,
        metric=True,
        patches=tuple(_patch(patch, metres) for patch in scene.patches),
        poses=tuple(Pose(pose.rotation, pose.centre * metres) for pose in scene.poses),
        sights=tuple(SightLines(s.origin * metres, s.ends * metres, s.view) for s in scene.sights),
        lattices=tuple(_lattice(lattice, metres) for lattice in scene.lattices),
        scale_sd=float(np.hypot(scene.scale_sd, relative_sd)),
    )


def _plane(plane: Plane, metres: float) -> Plane:
    units = np.array([1.0, 1.0, 1.0, metres])
    return Plane(plane.normal, plane.offset * metres, plane.cov * np.outer(units, units))


def _patch(patch: Patch, metres: float) -> Patch:
    return replace(patch, points=patch.points * metres, areas=patch.areas * metres**2)


def _lattice(lattice: SeenLattice, metres: float) -> SeenLattice:
    return replace(
        lattice,
        corner=lattice.corner * metres,
        steps=lattice.steps * metres,
        origins=lattice.origins * metres,
    )
