"""What do junctions and line labels add to correspondence, and are they right?

Boxes, L-blocks, wedges and stairs from the tour's poses (noise of 5 grey levels, blur of 1 px), and
the photographed cube: recall and precision of the paper's front end in matching vertices, from each
two successive views and from six, by position labels alone, and with junctions where these are
missing or repeated. Of junctions and line labels it is asked which share is
as the solid has it, in the pictures and in exact drawings from the same places.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import Cell, Report, Row, Settings, Table, data_set
from benchmarks.pictures.accuracy_front_end import (
    BLUR_PX,
    MATCH_PX,
    NOISE_GREY,
    hidden_corners,
    true_pixels,
)
from benchmarks.pictures.accuracy_pictures import CUBE, true_shape
from benchmarks.pictures.recognition import tour_views
from facetlog.kb.engine.terms import Atom
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.detection.block_front_end.correspondence import track_vertices
from facetlog.perception.detection.block_front_end.faces_of_block import (
    PictureFeatures,
    labelled_pictures,
    picture_features,
)
from facetlog.perception.detection.block_front_end.position_labels import picture_drawing
from facetlog.perception.facts.drawing_facts import drawing_rows, flat_along
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.line_drawing import LineDrawing
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.surfaces.exact_solids.polyhedra import polyhedron
from facetlog.perception.surfaces.visible_lines import visible_lines
from facetlog.perception.types import View
from facetlog.robot.rendering.solids import placed, prism
from facetlog.robot.rendering.world import SolidTruth, World
from facetlog.robot.rendering.worlds import BLOCK_CENTRE, make_world

__all__ = ["NAME", "measure"]

NAME = "accuracy_junctions"
SEEDS = 5
CUBE_SIDES = (0.084, 0.084, 0.084)
A_SIDE = 6  # views of the tour from one side of the block
L_PLAN = ((-5.0, -4.0), (5.0, -4.0), (5.0, 0.0), (0.0, 0.0), (0.0, 4.0), (-5.0, 4.0))
L_HEIGHT = 6.0
POSITION, JUNCTIONS = "position labels", "and junctions"
WAYS = (POSITION, JUNCTIONS)

LineLabels = Callable[[LineDrawing], Mapping[int, str]]
"""From a drawing to the labels of those of its lines (by number) that have one."""


def l_world(seed: int) -> World:
    """An L-block where the block of that seed stands."""
    block = make_world("block", seed)
    yaw = float(np.random.default_rng([seed, 1]).uniform(-np.pi, np.pi))
    solid = placed(prism(L_PLAN, L_HEIGHT, name="l_block"), *BLOCK_CENTRE, yaw=yaw)
    return replace(block, solids=(solid,), name="l_block")


MAKERS: Mapping[str, Callable[[int], World]] = {
    "boxes": lambda seed: make_world("boxes", seed),
    "L-blocks": l_world,
    "wedges": lambda seed: make_world("wedge", seed),
    "stairs": lambda seed: make_world("stairs", seed),
}


@dataclass
class Matched:
    """Counts over pairs or sixes of views."""

    true: int = 0
    found: int = 0
    right: int = 0

    def row(self) -> dict[str, Cell]:
        """Recall and precision."""
        recall = round(self.right / self.true, 3) if self.true else None
        return {
            "vertices": self.true,
            "recall": recall,
            "precision": round(self.right / self.found, 3) if self.found else None,
        }


@dataclass
class Right:
    """How many were asked for, how many have an answer, and how many of these are right."""

    asked: int = 0
    given: int = 0
    right: int = 0
    of_types: Counter[str] = field(default_factory=Counter)

    def add(self, given: str | None, true: str) -> None:
        """One more."""
        self.asked += 1
        self.given += given is not None
        self.right += given == true
        self.of_types[f"{true}: {given}"] += 1

    def cells(self, name: str) -> dict[str, Cell]:
        """Shares, under that name."""
        return {
            name: self.asked,
            f"{name} given": round(self.given / self.asked, 3) if self.asked else None,
            f"{name} right": round(self.right / self.given, 3) if self.given else None,
        }


def by_rules(base: KnowledgeBase) -> LineLabels:
    """Labels of drawings' lines by rules/line_labels.pl."""

    def labels(drawing: LineDrawing) -> dict[int, str]:
        points = [f"x{i}" for i in range(len(drawing.points))]
        lines = [f"e{i}" for i in range(len(drawing.lines))]
        rows = drawing_rows("view1", drawing, points, lines)
        facts = [(name, *row) for name, found in rows.items() for row in found]
        base.load_scene("drawing", [("view", "view1", "a picture"), *facts])
        found = base.query("line_label(view1, E, L)", scenes=("drawing",))
        return {
            int(edge.name[1:]): label.name
            for edge, label in found
            if isinstance(edge, Atom) and isinstance(label, Atom)
        }

    return labels


def owners(
    views: Sequence[View], solid: SolidTruth, hidden: Sequence[NDArray[np.bool_]]
) -> list[dict[int, tuple[float, float]]]:
    """Of each view the true vertices in sight, with their pixels."""
    found = []
    for view, gone in zip(views, hidden, strict=True):
        pixels, inside, _ = true_pixels(solid, view)
        found.append({i: (float(pixels[i][0]), float(pixels[i][1])) for i in inside if not gone[i]})
    return found


def owner(uv: NDArray[np.float64], true: Mapping[int, tuple[float, float]]) -> int:
    """The true vertex at a pixel, -1 for none."""
    near = {i: float(np.hypot(*(uv - at))) for i, at in true.items()}
    best = min(near, key=lambda i: near[i], default=-1)
    return best if best >= 0 and near[best] <= MATCH_PX else -1


def matched(
    tallies: Mapping[str, Matched],
    views: tuple[View, ...],
    pictures: tuple[PictureFeatures, ...],
    true: Sequence[Mapping[int, tuple[float, float]]],
) -> None:
    """Adds what each way matches among these views: sightings of vertices that two views show."""
    seen = Counter(i for each in true for i in each)
    sightings = sum(1 for each in true for i in each if seen[i] > 1)
    up = np.array([0.0, 0.0, 1.0])
    for way, tally in tallies.items():
        features = labelled_pictures(views, pictures, up)
        if way == POSITION:
            features = tuple(tuple(replace(v, mark=None) for v in each) for each in features)
        tally.true += sightings
        for track in track_vertices(features, views):
            named = [owner(o.uv, true[o.view]) for o in track.observations]
            best, count = Counter(named).most_common(1)[0]
            tally.found += len(named)
            tally.right += count if best >= 0 and count > 1 else 0


def edge_words(memo: SceneMemo, view: View) -> dict[frozenset[int], str]:
    """What the edges (pairs of vertices) of a solid are to a view, by their faces."""
    faces_of: dict[int, list[int]] = {}
    for edge, face in memo.bounds.tolist():
        faces_of.setdefault(edge, []).append(face)
    words = {}
    faces, points = memo.scene.faces, memo.scene.points
    for edge, sides in faces_of.items():
        seen = [faces[f] for f in sides if faces[f].plane.distance(view.pose.centre) > 0]
        if not seen:
            continue
        word = "occluding"
        if len(seen) == 2:
            behind = seen[0].plane.distance(points[list(seen[1].outline)].mean(axis=0)) < 0
            word = "convex" if behind else "concave"
        words[frozenset(memo.edges[edge].tolist())] = word
    return words


@dataclass
class Truths:
    """Junctions and line labels, in pictures and in exact drawings."""

    junctions: Right = field(default_factory=Right)
    lines: Right = field(default_factory=Right)
    exact: Right = field(default_factory=Right)
    drawings: int = 0
    impossible: int = 0

    def add(
        self,
        memo: SceneMemo,
        view: View,
        picture: PictureFeatures,
        true: Mapping[int, tuple[float, float]],
        labels: LineLabels,
    ) -> None:
        """One view of a solid."""
        words = edge_words(memo, view)
        shown = visible_lines(
            memo.table, memo.edges, memo.bounds, flat_along(memo), view.camera, view.pose
        )
        types = {
            int(v): rays.type.value
            for v, rays in zip(shown.vertex.tolist(), shown.drawing.rays, strict=True)
            if rays is not None and v >= 0
        }
        given = labels(shown.drawing)
        self.drawings += 1
        self.impossible += not given
        for line, edge in enumerate(shown.edge.tolist()):
            ends = frozenset(memo.edges[edge].tolist())
            if ends in words:
                self.exact.add(given.get(line), words[ends])
        drawing, _ = picture_drawing(picture.vertices, picture.lines)
        named = [owner(vertex.uv, true) for vertex in picture.vertices]
        for vertex, rays in zip(named, drawing.rays, strict=False):
            if vertex in types and rays is not None:
                self.junctions.add(rays.type.value, types[vertex])
        given = labels(drawing)
        for line, (a, b) in enumerate(drawing.lines.tolist()):
            ends = frozenset((named[a], named[b])) if max(a, b) < len(named) else frozenset()
            if ends in words:
                self.lines.add(given.get(line), words[ends])

    def row(self, name: str) -> Row:
        """The figures of one kind of solid."""
        return {
            "solids": name,
            **self.junctions.cells("junctions"),
            **self.lines.cells("lines"),
            **self.exact.cells("exact lines"),
            "exact drawings": self.drawings,
            "without labels": self.impossible,
        }


def of_views(
    name: str,
    sets: Iterable[tuple[tuple[View, ...], SolidTruth, World | None]],
    labels: LineLabels,
    thresholds: Mapping[str, int | None],
) -> tuple[list[Row], Row]:
    """Rows of matches, from two views and from six, and the row of truths."""
    tallies = {count: {way: Matched() for way in WAYS} for count in (2, A_SIDE)}
    truths = Truths()
    for views, solid, world in sets:
        pictures = tuple(picture_features(view.image, **thresholds) for view in views)
        none = np.zeros(len(solid.vertices), dtype=np.bool_)
        hidden = [none if world is None else hidden_corners(world, solid, v) for v in views]
        true = owners(views, solid, hidden)
        groups = {
            2: list(pairwise(range(len(views)))),
            A_SIDE: [tuple(range(i, i + A_SIDE)) for i in range(0, len(views) - 5, A_SIDE)],
        }
        for count, some in groups.items():
            for chosen in some:
                part = tuple(views[k] for k in chosen)
                of = tuple(pictures[k] for k in chosen)
                matched(tallies[count], part, of, [true[k] for k in chosen])
        scene = polyhedron(solid.vertices, solid.faces, sd=0.0, name=name)
        memo = SceneMemo.of(scene)
        for view, picture, each in zip(views, pictures, true, strict=True):
            truths.add(memo, view, picture, each, labels)
    rows: list[Row] = [
        {"solids": name, "views": count, "way": way, **tally.row()}
        for count, ways in tallies.items()
        for way, tally in ways.items()
    ]
    return rows, truths.row(name)


def measure(settings: Settings) -> Report:
    """Rows for each kind of solid, and for the cube where its pictures are."""
    seeds = settings.seeds(SEEDS)
    matches: list[Row] = []
    truths: list[Row] = []
    with KnowledgeBase() as base:
        labels = by_rules(base)
        for name, make in MAKERS.items():
            worlds = [(make(seed), seed) for seed in seeds]
            sets = (
                (
                    tour_views(world, seed, noise_sd=NOISE_GREY, blur_px=BLUR_PX),
                    world.truth.solids[0],
                    world,
                )
                for world, seed in worlds
            )
            rows, row = of_views(name, sets, labels, {})
            matches += rows
            truths.append(row)
        folder = data_set("images", CUBE)
        if not isinstance(folder, str):
            shape = true_shape(folder)
            points = tuple((float(x), float(y), float(z)) for x, y, z in shape.vertices)
            solid = SolidTruth(CUBE, points, shape.edges, shape.faces, CUBE_SIDES)
            cube = ((read_views(folder).views, solid, None),)
            rows, row = of_views(CUBE, cube, labels, {"threshold": None})
            matches += rows
            truths.append(row)
    return Report(
        NAME,
        (
            Table("Vertices matched, from successive pairs of views and from six", tuple(matches)),
            Table("Junctions and line labels as the solid has them", tuple(truths)),
        ),
        {"seeds": len(seeds), "first seed": seeds.start, "noise": NOISE_GREY, "blur px": BLUR_PX},
        (
            "vertices: sightings of those that two of the views or more show. recall: share of "
            "them in a track of which most are of that vertex. given: share of lines with a label; "
            "right: share of those given. exact: the solid's visible lines, drawn from the same "
            "places. without labels: drawings in which no line has one.",
        ),
    )
