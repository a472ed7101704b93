"""The page of a run: figures 8 to 14 beside what the paper prints, in one file."""

import tomllib
from base64 import b64encode
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from facetlog import __version__
from facetlog.kb.explaining.verdict_text import format_holding
from facetlog.output_folder import output_folder
from facetlog.page.policy import find_scripts, make_head_lines
from facetlog.paper.experiment import METRES_PER_INCH, Experiment, VertexRun
from facetlog.perception.detection.block_front_end.edge_lines import find_edge_pixels
from facetlog.perception.detection.block_front_end.localise import (
    PAPER_THRESHOLD,
    threshold_picture,
)
from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.plane_filter import Chart, plain_plane_recursion
from facetlog.perception.estimation.point_filter import run_printed_recursion
from facetlog.perception.pan_tilt import projection_matrix
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.mesh_export import render_viewer
from facetlog.perception.types import FloatArray, Image, Observation

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Iteration:
    """One printed step: its inputs, and for each output (name, printed, computed with one more
    digit).
    """

    number: int
    given: str
    rows: tuple[tuple[str, str, str], ...]


@cache
def printed() -> dict[str, Any]:
    """Return the figures of section 5.3 as printed.toml has them."""
    return tomllib.loads(files(__package__).joinpath("printed.toml").read_text(encoding="utf-8"))


def point_iterations() -> tuple[Iteration, ...]:
    """Return the two iterations of the point filter."""
    paper = printed()["point"]
    cases = paper["iteration"]
    poses = [(*case["pose"], paper["focal"]) for case in cases]
    projections = [projection_matrix(x, y, z, *angles) for x, y, z, *angles in poses]
    seen = [Observation(k, case["uv"], paper["noise"] * np.eye(2)) for k, case in enumerate(cases)]
    start = State(np.zeros(3), paper["s0"] * np.eye(3))
    found = []
    states = run_printed_recursion(seen, projections, start)
    for number, (case, state) in enumerate(zip(cases, states, strict=True), start=1):
        u, v = case["printed_uv"]
        x, y, z, pan, tilt, _ = case["printed_pose"]
        given = f"(u, v) = ({u}, {v}), pinhole ({x}, {y}, {z}), A = {pan}, B = {tilt}, C = 0"
        rows = [
            _row(name, p, c, 2) for name, p, c in zip("xyz", case["point"], state.mean, strict=True)
        ]
        digits = 1 if case["cov_tolerance"] > 0.01 else 2
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            name = f"S {'xyz'[i]}{'xyz'[j]}"
            rows.append(_row(name, case["cov"][i][j], float(state.cov[i, j]), digits))
        found.append(Iteration(number, given, tuple(rows)))
    return tuple(found)


def plane_iterations() -> tuple[Iteration, ...]:
    """Return the two iterations of the plane filter."""
    paper = printed()["plane"]
    cases = paper["iteration"]
    start = State(np.zeros(3), paper["s0"] * np.eye(3))
    points = [case["point"] for case in cases]
    states = plain_plane_recursion(points, paper["noise"] * np.eye(3), start, Chart.Z)
    return tuple(
        Iteration(
            number,
            f"(x, y, z) = {tuple(case['point'])}",
            tuple(
                _row(name, p, c, 3)
                for name, p, c in zip("abp", case["parameters"], state.mean, strict=True)
            ),
        )
        for number, (case, state) in enumerate(zip(cases, states, strict=True), start=1)
    )


def _row(name: str, given: float, computed: float, digits: int) -> tuple[str, str, str]:
    # One digit more than printed: two of the paper's figures are cut, not rounded.
    return name, f"{given:.{digits}f}", f"{computed + 0.0:.{digits + 1}f}"


SET_NAMES = ("I", "II", "III", "IV")
# Pictures on the page: pixels across of a thumbnail and half the side of what surrounds a vertex.
THUMBNAIL_PX = 200
AROUND_PX = 28
# What is shown round the block, as a share of its size, how wide that is, and its letters' size.
SURROUNDINGS, SHOWN_PX, LETTERS = 0.6, 640, 0.5
ENLARGED = 4
JPEG_QUALITY = 85


def make_figure(width: float, height: float) -> "Figure":
    """Return an empty figure of a size in inches that draws without a screen."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasSVG(figure)
    return figure


def encode_svg(figure: "Figure") -> str:
    """Return a figure as the address of an image that holds itself."""
    from matplotlib import rc_context

    out = BytesIO()
    with rc_context({"svg.hashsalt": "facetlog", "svg.fonttype": "none"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    return f"data:image/svg+xml;base64,{b64encode(out.getvalue()).decode()}"


def encode_jpeg(image: Image) -> str:
    """Return a picture (H, W) or (H, W, 3), blue first, as an address that holds it."""
    data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
    return f"data:image/jpeg;base64,{b64encode(data).decode()}"


def camera_map(run: Experiment) -> str:
    """Return figure 8: where the pinholes were and where they looked, in inches, by sets of six."""
    figure = make_figure(6.4, 6.0)
    axes = figure.subplots()
    scene = run.found.scene
    for face in scene.faces:
        ring = scene.points[[*face.outline, face.outline[0]]] / METRES_PER_INCH
        axes.fill(ring[:, 0], ring[:, 1], color="0.75", ec="0.3", lw=1)
    for number, view in enumerate(run.views):
        x, y, _ = view.pose.centre / METRES_PER_INCH
        ahead = view.pose.rotation[:2, 2]
        colour = f"C{number // (len(run.views) // len(SET_NAMES))}"
        turn = np.degrees(np.arctan2(ahead[1], ahead[0])) - 90.0
        axes.plot(x, y, marker=(3, 0, turn), ms=9, color=colour)
        axes.arrow(x, y, *(6.0 * ahead), color=colour, lw=0.8, head_width=1.2)
        axes.annotate(str(number % 6 + 1), (x, y), (0, 7), textcoords="offset points", fontsize=7)
    for k, name in enumerate(SET_NAMES):
        axes.plot([], [], "^", color=f"C{k}", label=f"SET-{name}")
    axes.legend(frameon=False, fontsize=8, loc="upper right")
    axes.set(aspect="equal", xlabel="x, inches", ylabel="y, inches")
    axes.grid(alpha=0.3)
    return encode_svg(figure)


def thumbnail(image: Image) -> str:
    """Return a picture made small."""
    height = round(THUMBNAIL_PX * image.shape[0] / image.shape[1])
    small = cv2.resize(image, (THUMBNAIL_PX, height), interpolation=cv2.INTER_AREA)
    return encode_jpeg(np.asarray(small, dtype=np.uint8))


def draw_thresholded_picture(image: Image) -> str:
    """Return figure 9 (b): black and white by the paper's threshold."""
    return encode_jpeg(threshold_picture(image, PAPER_THRESHOLD))


def draw_regions_picture(run: Experiment, view: int) -> str:
    """Draw the regions of one grey in colours."""
    found = run.block.pictures[view]
    labels = found.regions.labels
    colours = np.array([[60, 60, 60], [80, 170, 240], [120, 200, 90], [230, 150, 90]], np.uint8)
    picture = colours[np.where(labels > 0, 1 + (labels - 1) % 3, 0)]
    return encode_jpeg(_enlarged(picture, found.object.mask, cv2.INTER_NEAREST)[0])


def draw_edges_picture(run: Experiment, view: int) -> str:
    """Return figure 10: the Laplacian's edge pixels of the localised block."""
    mask = run.block.pictures[view].object.mask
    edges = find_edge_pixels(run.views[view].image, mask)
    drawn = np.where(edges, np.uint8(0), np.uint8(255))
    return encode_jpeg(_enlarged(drawn, mask, cv2.INTER_NEAREST)[0])


def draw_labels_picture(run: Experiment, view: int) -> str:
    """Return the straight edges and the vertices with their position labels."""
    mask = run.block.pictures[view].object.mask
    large, corner, factor = _enlarged(run.views[view].image, mask, cv2.INTER_CUBIC)
    image = cv2.cvtColor(large, cv2.COLOR_GRAY2BGR)

    def placed(uv: FloatArray) -> tuple[int, int]:
        u, v = np.rint((uv + 0.5 - corner) * factor).astype(int).tolist()
        return u, v

    for line in run.block.pictures[view].lines:
        cv2.line(image, placed(line.start), placed(line.end), (60, 160, 255), 2, cv2.LINE_AA)
    middle = image.shape[1] / 2
    for labelled in run.block.vertices[view]:
        u, v = placed(labelled.vertex.uv)
        cv2.circle(image, (u, v), 5, (60, 60, 220), -1, cv2.LINE_AA)
        name = str(labelled.label or "no label").replace("_", " ")
        width = cv2.getTextSize(name, 0, LETTERS, 1)[0][0]
        # Away from the block, on either side of it.
        at = (u + 10 if u > middle else u - 10 - width, v + (-8 if v < image.shape[0] / 2 else 16))
        for colour, thick in (((40, 40, 40), 3), ((255, 255, 255), 1)):
            cv2.putText(image, name, at, 0, LETTERS, colour, thick, cv2.LINE_AA)
    return encode_jpeg(np.asarray(image, dtype=np.uint8))


def _enlarged(image: Image, mask: Image, how: int) -> tuple[Image, FloatArray, float]:
    """Return the part of a picture round the object, its top-left corner (2,) and how often
    enlarged.
    """
    u, v, width, height = cv2.boundingRect(mask)
    wide = round(max(width, height) * SURROUNDINGS)
    left, top = max(u - wide, 0), max(v - wide // 2, 0)
    part = image[top : v + height + wide // 2, left : u + width + wide]
    factor = SHOWN_PX / part.shape[1]
    size = (SHOWN_PX, round(factor * part.shape[0]))
    large = np.asarray(cv2.resize(part, size, interpolation=how), dtype=np.uint8)
    return large, np.array([left, top], dtype=np.float64), factor


def sightings(run: Experiment, track: VertexRun, count: int) -> list[tuple[str, str]]:
    """Return figure 11: the first views of a vertex, each with its pixel (u, v) and its
    surroundings.
    """
    found = []
    for view, uv in list(zip(track.views, track.pixels, strict=True))[:count]:
        image = run.views[view].image
        padded = np.pad(image, AROUND_PX, constant_values=128)
        u, v = np.rint(uv).astype(int).tolist()
        crop = padded[v : v + 2 * AROUND_PX + 1, u : u + 2 * AROUND_PX + 1]
        large = cv2.resize(crop, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_CUBIC)
        colour = cv2.cvtColor(large, cv2.COLOR_GRAY2BGR)
        middle = tuple(round(float(ENLARGED * (AROUND_PX + off + 0.5))) for off in uv - np.rint(uv))
        cv2.drawMarker(colour, middle, (40, 40, 230), cv2.MARKER_CROSS, 24, 1, cv2.LINE_AA)
        where = f"{run.views[view].name}: ({uv[0]:.2f}, {uv[1]:.2f})"
        found.append((where, encode_jpeg(np.asarray(colour, dtype=np.uint8))))
    return found


def plot_estimate(vertex: VertexRun) -> str:
    """Return figure 12: x, y and z less the truth after each view, with three standard deviations,
    and the printed recursion's from its zero start beside it.
    """
    figure = make_figure(6.8, 4.4)
    panels = figure.subplots(3, 1, sharex=True)
    views = np.arange(1, len(vertex.views) + 1)
    for k, axes in enumerate(panels):
        off = vertex.points[:, k] - vertex.true[k]
        sd = np.sqrt(vertex.covs[:, k, k])
        axes.fill_between(views, off - 3 * sd, off + 3 * sd, color="C0", alpha=0.2, lw=0)
        axes.plot(views, off, ".-", color="C0", label="this recursion, ± 3 sd")
        plain = vertex.plain_points[:, k] - vertex.true[k]
        axes.plot(views, plain, "--", color="C1", lw=1, label="as printed, from zero")
        axes.axhline(vertex.at_once[k] - vertex.true[k], color="C2", lw=1, label="all at once")
        # The zero start is inches off at first: what the views settle on is to be seen.
        reach = 1.1 * float(np.nanmax(np.abs(off) + 3 * sd))
        axes.set(ylim=(-reach, reach), ylabel=f"{'xyz'[k]} – true, in")
        axes.grid(alpha=0.3)
    panels[0].legend(frameon=False, fontsize=8, ncol=3, loc="upper right")
    panels[-1].set_xlabel("views that showed it")
    return encode_svg(figure)


def plot_covariance(vertex: VertexRun) -> str:
    """Return figure 13: the elements on the covariance's diagonal after each view."""
    figure = make_figure(6.8, 2.8)
    axes = figure.subplots()
    views = np.arange(1, len(vertex.views) + 1)
    for k in range(3):
        name = f"S {'xyz'[k]}{'xyz'[k]}"
        axes.semilogy(views, vertex.covs[:, k, k], ".-", color=f"C{k}", label=name)
        axes.semilogy(views, vertex.plain_covs[:, k, k], "--", color=f"C{k}", lw=1)
    axes.plot([], [], "--", color="0.4", lw=1, label="as printed, from zero")
    axes.set(xlabel="views that showed it", ylabel="variance, in²")
    axes.legend(frameon=False, fontsize=8, ncol=2)
    axes.grid(alpha=0.3)
    return encode_svg(figure)


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
        "map": camera_map(run),
        "thumbnails": _thumbnails(run),
        "shown": f"{run.views[view].name}, as the camera took it",
        "picture": encode_jpeg(run.views[view].image),
        "thresholded": draw_thresholded_picture(run.views[view].image),
        "regions": draw_regions_picture(run, view),
        "ungrown": run.ungrown,
        "grown": run.grown,
        "edges": draw_edges_picture(run, view),
        "labels": draw_labels_picture(run, view),
        "vertex_a": _vertex(most_seen, scene),
        "sightings": sightings(run, most_seen, SIGHTINGS),
        "vertices": [_vertex(v, scene) for v in run.vertices],
        "nees": f"{np.nanmean([v.nees for v in run.vertices]) / 3:.1f}",
        "curves": [
            {
                "label": v.label.replace("_", " "),
                "estimate": plot_estimate(v),
                "covariance": plot_covariance(v),
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
    each = len(run.views) // len(SET_NAMES)
    found = []
    for number, view in enumerate(run.views):
        x, y, z = view.pose.centre / METRES_PER_INCH
        found.append(
            {
                "image": thumbnail(view.image),
                "name": view.name,
                "set": f"SET-{SET_NAMES[number // each]}, map {number % each + 1}",
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
