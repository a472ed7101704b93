"""Edges that bound no face, with one more view: each is a line in space, whose ends are hardly
known along it.
"""

from dataclasses import replace

import numpy as np

from facetlog.perception.detection.line_front_end.faces_from_lines import Pictures
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.estimation.incidence import GATE
from facetlog.perception.estimation.lines.image_line import fit_image_line
from facetlog.perception.estimation.lines.space_line import line_of_points
from facetlog.perception.estimation.pose_noise import pixel_covs
from facetlog.perception.online.in_sight import in_sight
from facetlog.perception.scene import Edge, Scene
from facetlog.perception.surfaces.drawing.hidden_surface import HiddenSurface
from facetlog.perception.types import View

__all__ = ["with_loose_lines"]


def with_loose_lines(
    scene: Scene,
    looked: Pictures,
    given: View,
    hidden: HiddenSurface,
    extra_px: float,
    factor: float,
) -> tuple[Scene, int]:
    """The scene with its loose edges updated by the one view of `looked`, and how many were.

    `given` is that view with the covariance of its pose, `hidden` what it sees of the scene's
    faces; the variance of pixels is `factor` times
    one to which `extra_px` was added (scene_from_tracks.Assembled).
    """
    loose = _loose(scene)
    if not loose:
        return scene, 0
    (view,), (edges,) = looked.views, looked.maps
    ends = scene.points[np.array([(e.start, e.end) for e in loose])]
    shown = in_sight(hidden, ends, view)
    (fits,) = fit_sides(ends, shown[:, None], [view], [edges])
    vertices = list(scene.vertices)
    updated = 0
    for k in np.flatnonzero(fits.good).tolist():
        pair = loose[k].start, loose[k].end
        pixels = (
            project_points(view.projection, ends[k])[0] + fits.offset[k, :, None] * fits.normal[k]
        )
        across = np.outer(fits.normal[k], fits.normal[k])
        # Along it the readings say nothing, and a line of them asks for nothing.
        noise = (fits.variance[k, :, None, None] + extra_px**2) * factor * across
        noise += pixel_covs(given, ends[k]) * float(np.mean(looked.factors)) ** 2
        known = [vertices[n].cov for n in pair]
        line = line_of_points(ends[k], known)
        line, chi2 = line.seen(fit_image_line(pixels, noise), view.projection)
        if chi2 > GATE:
            continue
        for n, point, cov in zip(pair, ends[k], known, strict=True):
            on, cov_on = line.near(point, cov)
            vertices[n] = replace(vertices[n], point=on, cov=cov_on)
        updated += 1
    return replace(scene, vertices=tuple(vertices)), updated


def _loose(scene: Scene) -> tuple[Edge, ...]:
    """The edges that share no vertex with a face."""
    of_faces = {k for face in scene.faces for ring in (face.outline, *face.holes) for k in ring}
    return tuple(e for e in scene.edges if not of_faces.intersection((e.start, e.end)))
