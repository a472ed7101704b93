"""How well do the front ends see corners, and the paper's front end the paper's block?

The tour of 24 views (noise of 5 grey levels, blur of 1 px, shadow, textured floor): recall and
precision of 2-D vertices, their error against the bound from the visible edges that meet there,
honest covariance, agreement of labels, correct tracks and outlines, error of the tracks' points
(inches), and CPU time per picture. Of corners the same is asked of both front ends, of the block
with clutter beside it as it is and in steps of 10 grey levels. Wanted: of all corners .90, in steps
.75, of the block's all, in steps .90; errors of 1.8 and 2 times the bound.
"""

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.common import Cell, Report, Row, Settings, Table
from benchmarks.pictures.recognition import in_steps, tour_views
from facetlog.errors import FacetlogError
from facetlog.perception.detection.block_front_end.face_outlines import track_points
from facetlog.perception.detection.block_front_end.faces_of_block import (
    BlockFeatures,
    block_front_end,
    picture_features,
)
from facetlog.perception.detection.line_front_end.faces_from_lines import line_front_end
from facetlog.perception.detection.tracked_faces import TrackedFaces
from facetlog.perception.step_clock import StepClock
from facetlog.perception.types import FloatArray, View
from facetlog.pipeline import FrontEnd
from facetlog.robot.rendering.rays import first_hits, seen_by
from facetlog.robot.rendering.world import SolidTruth, World
from facetlog.robot.rendering.worlds import make_world

__all__ = ["NAME", "measure"]

NAME = "accuracy_front_end"
SEEDS = 5
WORLDS = ("block", "clutter_block")
MATCH_PX = 3.0  # a found vertex this near to a true one is that one
RIM_PX = 3.0  # true vertices nearer to the rim of the picture are not asked for
NOISE_GREY, BLUR_PX = 5.0, 1.0
CORNERS_OF = "clutter_block"
LIGHTS: Mapping[str, Callable[[World], World]] = {
    "as it is": lambda world: world,
    "in steps of 10 grey levels": lambda world: in_steps(world, 10.0),
}
# Wanted in either light: recall of all corners and of the block's, and error over the bound.
WANTED = {"as it is": (0.9, 1.0, 1.8), "in steps of 10 grey levels": (0.75, 0.9, 2.0)}
# What is nearer than a corner by less than this share of its depth does not hide it: rounding.
HIDING_SHARE = 1e-3


class Corner(Protocol):
    """A vertex in a picture: its pixel (2,) and its covariance (2, 2)."""

    @property
    def uv(self) -> FloatArray:
        """Pixel (2,)."""

    @property
    def cov(self) -> FloatArray:
        """Of the pixel, (2, 2)."""


Corners = Sequence[Sequence[Corner]]
"""Of each view."""


@dataclass
class Tally:
    """Counts and errors over all seeds."""

    true: int = 0
    found: int = 0
    hit: int = 0
    errors: list[float] = field(default_factory=list)
    over_bound: list[float] = field(default_factory=list)
    squares: list[float] = field(default_factory=list)
    labelled: int = 0
    label_right: int = 0
    labels_all: int = 0
    tracks: int = 0
    tracks_pure: int = 0
    observations: int = 0
    observations_right: int = 0
    vertices_tracked: int = 0
    vertices: int = 0
    outlines: int = 0
    outlines_right: int = 0
    faces_seen: int = 0
    point_errors: list[float] = field(default_factory=list)
    rms: list[float] = field(default_factory=list)
    ms_per_picture: list[float] = field(default_factory=list)
    ms_matching: list[float] = field(default_factory=list)


def true_pixels(solid: SolidTruth, view: View) -> tuple[FloatArray, list[int], list[int]]:
    """Pixels (n, 2) of all vertices, indices of the visible ones, indices of the visible faces."""
    corners = np.array(solid.vertices)
    projected = np.column_stack([corners, np.ones(len(corners))]) @ view.projection.T
    pixels = projected[:, :2] / projected[:, 2:]
    faces = []
    for index, face in enumerate(solid.faces):
        a, b, c = corners[list(face[:3])]
        if np.cross(b - a, c - b) @ (view.pose.centre - a) > 0:
            faces.append(index)
    seen = sorted({i for f in faces for i in solid.faces[f]})
    size = np.array([view.camera.width, view.camera.height]) - 1 - RIM_PX
    inside = [i for i in seen if (pixels[i] > RIM_PX).all() and (pixels[i] < size).all()]
    return pixels, inside, faces


def hidden_corners(world: World, solid: SolidTruth, view: View) -> NDArray[np.bool_]:
    """Which vertices (n,) of a solid anything of the world stands before."""
    corners = np.array(solid.vertices)
    h = np.column_stack([corners, np.ones(len(corners))]) @ view.projection.T
    screen = seen_by(world, view.camera, view.pose)
    hits = first_hits(world, view.camera, view.pose, screen, (h[:, :2] / h[:, 2:]).T)
    return np.asarray(hits.depth < (1 - HIDING_SHARE) * h[:, 2])


def corner_bound(solid: SolidTruth, view: View, pixels: FloatArray, corner: int) -> float:
    """Cramér-Rao bound (px, root mean square of both axes) of a corner from its visible edges.

    Edge-offset variance per pixel sd² 2 sqrt(pi) blur / C², times 4 / length at the edge's end;
    the contrast C is read from the picture beside the middle of the edge.
    """
    _, _, faces = true_pixels(solid, view)
    visible = {
        frozenset(pair)
        for f in faces
        for pair in zip(solid.faces[f], (*solid.faces[f][1:], solid.faces[f][0]), strict=True)
    }
    information = np.zeros((2, 2))
    image = view.image.astype(np.float64)
    for edge in visible:
        if corner not in edge:
            continue
        (other,) = edge - {corner}
        along = pixels[other] - pixels[corner]
        length = float(np.hypot(*along))
        normal = np.array([-along[1], along[0]]) / length
        sides = []
        for sign in (-4.0, 4.0):
            at = pixels[corner] + np.linspace(0.2, 0.8, 30)[:, None] * along + sign * normal
            u = np.clip(np.rint(at[:, 0]).astype(int), 0, image.shape[1] - 1)
            v = np.clip(np.rint(at[:, 1]).astype(int), 0, image.shape[0] - 1)
            sides.append(image[v, u].mean())
        contrast = max(abs(sides[1] - sides[0]), 1.0)
        variance = NOISE_GREY**2 * 2 * np.sqrt(np.pi) * BLUR_PX / contrast**2 * 4.0 / length
        information += np.outer(normal, normal) / variance
    return float(np.sqrt(np.trace(np.linalg.inv(information)) / 2.0))


def tally_pictures(
    tally: Tally, solids: Sequence[int], views: Sequence[View], found: Corners, world: World
) -> list[dict[int, int]]:
    """Adds the 2-D figures of these solids; returns for each view which true vertex each found one
    is, by its number in its solid."""
    matches = []
    for view, corners in zip(views, found, strict=True):
        true = []
        for solid in (world.truth.solids[index] for index in solids):
            pixels, inside, _ = true_pixels(solid, view)
            hidden = hidden_corners(world, solid, view)
            true += [(solid, corner, pixels) for corner in inside if not hidden[corner]]
        tally.true += len(true)
        tally.found += len(corners)
        match: dict[int, int] = {}
        if corners and true:
            uv = np.array([c.uv for c in corners])
            at = np.array([pixels[corner] for _, corner, pixels in true])
            distance = np.linalg.norm(uv[:, None] - at[None], axis=2)
            rows, columns = linear_sum_assignment(np.minimum(distance, 10 * MATCH_PX))
            for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
                if distance[row, column] > MATCH_PX:
                    continue
                solid, corner, pixels = true[column]
                match[row] = corner
                error = uv[row] - at[column]
                tally.hit += 1
                tally.errors.append(float(np.hypot(*error)))
                bound = corner_bound(solid, view, pixels, corner)
                tally.over_bound.append(float(np.hypot(*error) / np.sqrt(2.0) / bound))
                square = error @ np.linalg.solve(corners[row].cov, error)
                tally.squares.append(float(square))
        matches.append(match)
    return matches


def tally_labels(tally: Tally, found: BlockFeatures, matches: list[dict[int, int]]) -> None:
    """Adds how many vertices have a label, and how many the one that their corner mostly has."""
    votes: dict[int, Counter[str]] = {}
    given = []
    for labelled, match in zip(found.vertices, matches, strict=True):
        tally.labels_all += len(match)
        for index, corner in match.items():
            label = labelled[index].block_label
            if label is not None:
                votes.setdefault(corner, Counter())[label] += 1
                given.append((corner, label))
    tally.labelled += len(given)
    tally.label_right += sum(votes[c].most_common(1)[0][0] == label for c, label in given)


def tally_tracks(
    tally: Tally, solid: SolidTruth, views: tuple[View, ...], found: BlockFeatures
) -> None:
    """Adds the figures of tracks, their points and outlines."""
    corners = np.array(solid.vertices)
    owners = []
    for track in found.tracks:
        names: Counter[int] = Counter()
        for seen in track.observations:
            pixels, inside, _ = true_pixels(solid, views[seen.view])
            near = np.linalg.norm(pixels[inside] - seen.uv, axis=1)
            best = int(np.argmin(near))
            names[inside[best] if near[best] <= MATCH_PX else -1] += 1
        owner, count = names.most_common(1)[0]
        owners.append(owner)
        tally.observations += len(track.observations)
        tally.observations_right += count if owner >= 0 else 0
        tally.tracks_pure += int(owner >= 0 and count == len(track.observations))
    tally.tracks += len(found.tracks)
    tally.vertices += len(corners)
    tally.vertices_tracked += len({o for o in owners if o >= 0})
    points = track_points(found.tracks, views)
    errors = [
        float(np.linalg.norm(point - corners[owner]))
        for point, owner in zip(points, owners, strict=True)
        if owner >= 0
    ]
    tally.point_errors += errors
    tally.rms.append(float(np.sqrt(np.mean(np.square(errors)))) if errors else float("nan"))
    seen_faces = {f for view in views for f in true_pixels(solid, view)[2]}
    true_faces = {frozenset(solid.faces[f]) for f in seen_faces}
    tally.faces_seen += len(true_faces)
    tally.outlines += len(found.outlines)
    tally.outlines_right += sum(
        frozenset(owners[i] for i in outline) in true_faces for outline in found.outlines
    )


def tallied(name: str, seeds: range) -> Tally:
    """All figures of the first solid of a world over the seeds."""
    tally = Tally()
    for seed in seeds:
        world = make_world(name, seed)
        views = tour_views(world, seed, noise_sd=NOISE_GREY, blur_px=BLUR_PX)
        begin = time.process_time()
        for view in views:
            picture_features(view.image)
        middle = time.process_time()
        found = block_front_end(views)
        end = time.process_time()
        per_picture = (middle - begin) / len(views)
        tally.ms_per_picture.append(1e3 * per_picture)
        tally.ms_matching.append(1e3 * (end - middle - (middle - begin)))
        solid = world.truth.solids[0]
        corners = [[v.vertex for v in labelled] for labelled in found.vertices]
        tally_labels(tally, found, tally_pictures(tally, [0], views, corners, world))
        tally_tracks(tally, solid, views, found)
    return tally


def corner_row(light: str, front_end: FrontEnd, seeds: range) -> Row:
    """How many corners of the scene, and of its block, that front end finds in that light."""
    everything, block = Tally(), Tally()
    for seed in seeds:
        world = LIGHTS[light](make_world(CORNERS_OF, seed))
        views = tour_views(world, seed, noise_sd=NOISE_GREY, blur_px=BLUR_PX)
        found = corners_of(front_end, views)
        # The facets of a curved surface meet in no corner.
        flat = [index for index, solid in enumerate(world.solids) if not solid.curved]
        tally_pictures(everything, flat, views, found, world)
        tally_pictures(block, [0], views, found, world)
    all_, of_block, error = WANTED[light]
    over_bound = everything.over_bound
    return {
        "light": light,
        "front end": front_end.value,
        "corners": everything.true,
        "recall": round(everything.hit / everything.true, 3),
        "wanted": all_,
        "of the block": round(block.hit / block.true, 3),
        "wanted of it": of_block,
        "precision": round(everything.hit / everything.found, 3) if everything.found else None,
        "over the bound": round(float(np.median(over_bound)), 2) if over_bound else None,
        "at most": error,
    }


def corners_of(front_end: FrontEnd, views: Sequence[View]) -> Corners:
    """What the front end finds in each view; nothing where it gives up."""
    if front_end is FrontEnd.PAPER:
        pictures = block_front_end(tuple(views)).vertices
        return [[labelled.vertex for labelled in picture] for picture in pictures]
    up = np.array([0.0, 0.0, 1.0])
    try:
        tracked = line_front_end(views, up, StepClock())
    except FacetlogError:
        tracked = TrackedFaces((), (), ())
    found: list[list[Corner]] = [[] for _ in views]
    used = range(len(views)) if tracked.used is None else tracked.used
    for track in tracked.tracks:
        for seen in track.observations:
            found[used[seen.view]].append(seen)
    return found


def measure(settings: Settings) -> Report:
    """A row of corners for each light and front end, and a column of figures for each world."""
    seeds = settings.seeds(SEEDS)
    columns = {name: _figures(tallied(name, seeds)) for name in WORLDS}
    figures = columns[WORLDS[0]]
    return Report(
        NAME,
        (
            Table(
                "Corners of all things in the pictures, and of the block among them",
                tuple(corner_row(light, f, seeds) for light in LIGHTS for f in FrontEnd),
            ),
            Table(
                "The paper's front end: the block, alone and with clutter beside it",
                tuple(
                    {"figure": figure, **{name: columns[name][figure] for name in WORLDS}}
                    for figure in figures
                ),
            ),
        ),
        {
            "seeds": len(seeds),
            "first seed": seeds.start,
            "views": 24,
            "noise": NOISE_GREY,
            "blur px": BLUR_PX,
        },
        (
            f"A vertex found within {MATCH_PX:g} px of a true one is that one. Of the front end "
            "lines they are those of its faces. over the bound: median error. NEES: median of the "
            "squared error over its variance, over what is expected; 1 is honest.",
        ),
    )


def _figures(tally: Tally) -> dict[str, Cell]:
    def quantile(values: list[float], share: float) -> float:
        return round(float(np.quantile(values, share)), 4)

    return {
        "recall": round(tally.hit / tally.true, 4),
        "precision": round(tally.hit / tally.found, 4),
        "error px, median": quantile(tally.errors, 0.5),
        "error px, 90 %": quantile(tally.errors, 0.9),
        "error over the bound, median": quantile(tally.over_bound, 0.5),
        # Median of chi-square with 2 degrees of freedom over its expectation 2 ln 2.
        "NEES": round(quantile(tally.squares, 0.5) / (2 * np.log(2)), 3),
        "vertices with a label": round(tally.labelled / tally.labels_all, 4),
        "labels as their corner mostly has": round(tally.label_right / max(1, tally.labelled), 4),
        "tracks": tally.tracks,
        "tracks without a wrong observation": tally.tracks_pure,
        "observations right": round(tally.observations_right / max(1, tally.observations), 4),
        "vertices tracked": f"{tally.vertices_tracked} of {tally.vertices}",
        "outlines right": f"{tally.outlines_right} of {tally.outlines}",
        "faces seen": tally.faces_seen,
        "error of points in, median": quantile(tally.point_errors, 0.5),
        "rms of a block in, worst": quantile(tally.rms, 1.0),
        "CPU ms a picture, median": quantile(tally.ms_per_picture, 0.5),
        "CPU ms labels, tracks, outlines, median": quantile(tally.ms_matching, 0.5),
    }
