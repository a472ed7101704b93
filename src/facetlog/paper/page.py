"""The page of a run: figures 8 to 14 beside what the paper prints, in one file."""

import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from facetlog import __version__
from facetlog.kb.explaining.verdict_text import format_holding
from facetlog.output_folder import output_folder
from facetlog.page.policy import find_scripts, make_head_lines
from facetlog.paper import pictures
from facetlog.paper.experiment import METRES_PER_INCH, Experiment, VertexRun
from facetlog.paper.printed import plane_iterations, point_iterations
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.mesh_export import render_viewer

PAGE_FILE = "paper.html"
SIGHTINGS = 6
"""2-D points of figure 11."""


def write_paper_page(folder: Path, run: Experiment, seed: int) -> None:
    """Write `paper.html` into a folder that appears as a whole; InputError if that cannot be."""
    about: dict[str, object] = {"facetlog": __version__, "scene": run.found.scene.name}
    with output_folder(folder, about) as made:
        (made / PAGE_FILE).write_text(page(run, seed), encoding="utf-8")


def deviations() -> list[dict[str, str]]:
    """Return where this program does other than the paper's text, and why (deviations.toml)."""
    text = files(__package__).joinpath("deviations.toml").read_text(encoding="utf-8")
    found: list[dict[str, str]] = tomllib.loads(text)["deviation"]
    return found


def page(run: Experiment, seed: int) -> str:
    """Return the page as text: no file and no network is needed to look at it."""
    environment = Environment(
        loader=PackageLoader(__package__ or "", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    return environment.get_template("page.html.jinja").render(_contents(run, seed))


def _contents(run: Experiment, seed: int) -> dict[str, Any]:
    scene, recognition = run.found.scene, run.found.recognition
    # The first picture with the most regions of grey: it shows three faces, as the paper's does.
    view = max(range(len(run.views)), key=lambda k: run.block.pictures[k].regions.labels.max())
    most_seen = run.shown_vertices[0]
    viewer = render_viewer(scene)
    return {
        "head": make_head_lines(find_scripts(viewer), version=__version__),
        "version": __version__,
        "seed": seed,
        "verdict": format_holding(v.summary for v in recognition.best),
        "map": pictures.camera_map(run),
        "thumbnails": _thumbnails(run),
        "shown": f"{run.views[view].name}, as the camera took it",
        "picture": pictures.encode_jpeg(run.views[view].image),
        "thresholded": pictures.draw_thresholded_picture(run.views[view].image),
        "regions": pictures.draw_regions_picture(run, view),
        "ungrown": run.ungrown,
        "grown": run.grown,
        "edges": pictures.draw_edges_picture(run, view),
        "labels": pictures.draw_labels_picture(run, view),
        "vertex_a": _vertex(most_seen, scene),
        "sightings": pictures.sightings(run, most_seen, SIGHTINGS),
        "vertices": [_vertex(v, scene) for v in run.vertices],
        "nees": f"{np.nanmean([v.nees for v in run.vertices]) / 3:.1f}",
        "curves": [
            {
                "label": v.label.replace("_", " "),
                "estimate": pictures.plot_estimate(v),
                "covariance": pictures.plot_covariance(v),
            }
            for v in run.shown_vertices
        ],
        "point_iterations": point_iterations(),
        "plane_iterations": plane_iterations(),
        "viewer": viewer,
        "angles": _angles(run),
        "model": files("facetlog.rules").joinpath("box.model").read_text(encoding="utf-8"),
        "proof": "\n".join(recognition.lines()),
        "picture_ms": f"{1e3 * run.seconds:.0f}",
        "total_s": f"{run.total_seconds:.1f}",
        "deviations": deviations(),
    }


def _thumbnails(run: Experiment) -> list[dict[str, str]]:
    each = len(run.views) // len(pictures.SET_NAMES)
    found = []
    for number, view in enumerate(run.views):
        x, y, z = view.pose.centre / METRES_PER_INCH
        found.append(
            {
                "image": pictures.thumbnail(view.image),
                "name": view.name,
                "set": f"SET-{pictures.SET_NAMES[number // each]}, map {number % each + 1}",
                "said": f"x = {x:.1f}, y = {y:.1f}, z = {z:.1f}",
            }
        )
    return found


def _vertex(run: VertexRun, scene: Scene) -> dict[str, object]:
    of_scene = [v.cov for v in scene.vertices if v.label == run.label]
    scene_sd = None
    if of_scene:
        scene_sd = float(np.sqrt(np.linalg.eigvalsh(of_scene[0])[-1])) / METRES_PER_INCH
    off = float(np.linalg.norm(run.points[-1] - run.true))
    sd = float(np.sqrt(np.linalg.eigvalsh(run.covs[-1])[-1]))
    return {
        "label": run.label.replace("_", " "),
        "views": len(run.views),
        "which": ", ".join(str(k + 1) for k in run.views),
        "point": ", ".join(f"{x:.2f}" for x in run.points[-1].round(2) + 0.0),
        "sd": f"{sd:.3f}",
        "scene_sd": "" if scene_sd is None else f"{scene_sd:.3f}",
        "off": f"{off:.3f}",
    }


def _angles(run: Experiment) -> list[dict[str, str]]:
    rows = [fact for fact in run.found.facts if fact[0] == "dihedral"]
    return [
        {"planes": f"{a} and {b}", "angle": f"{float(angle):.2f}", "sd": f"{float(sd):.2f}"}
        for _, a, b, angle, sd in rows
        if str(a) < str(b)
    ]
