"""What is recognised in real pictures with known cameras, and how exact is it?

Third-party sets under FACETLOG_DATA; without it the benchmark is skipped. Asked of visp_cube, a
picture cube: box and nothing else, three faces or more each pair of which is within 15 degrees of
square, 7 of the 12 true edges or more, their median length within 3 %, the worst of all edges
within 10 %. The same is asked with the world turned and scaled, and is measured with the views in
another order, with half of them, and with poses that are less exact.

Then each true face that cameras look at: how much of it do found faces cover that are turned by 3
degrees and off by 5 % of the thing's extent at most?
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.common import Cell, Report, Row, Settings, Table, find_data_set, hash_tree
from benchmarks.pictures.polygons import Polygon
from benchmarks.pictures.recognition import (
    SAME_FRAME,
    Run,
    Score,
    Shape,
    counted,
    in_frame,
    recognised,
    score,
)
from facetlog.perception.facts.relations import compute_pairwise_angles
from facetlog.perception.reading.read_views import ViewSet, read_views
from facetlog.perception.types import FloatArray
from facetlog.pipeline import FrontEnd
from facetlog.robot.rendering.views import Similarity, add_pose_noise, draw_similarity

NAME = "accuracy_pictures"
CUBE = "visp_cube"
SETS = (CUBE, "visp_teabox_table", "desk")
AS_IT_IS = "as it is"
SEEDS = 5
SCALE = 1000.0
POSE_NOISE_DEG = 0.3
# What is asked of the cube.
LEAST_EDGES, MEDIAN_ERROR, WORST_ERROR, SQUARE_DEG = 7, 0.03, 0.10, 15.0
# A found face covers what it is turned by so little to, and off by such a share of the extent; a
# face is large from such a share of the largest true one on.
TURN, OFFSET, LARGE = np.radians(3.0), 0.05, 0.05
# A face with no more than this share of its area on the thing is something else.
OTHER_SHARE = 0.1


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """One run: what it came to, its score, all its edges' errors, and its faces' angles.

    `off` are the relative errors of all edges against the nearest true length, `angles` those of
    all pairs of faces that are not parallel within 45 degrees, in degrees.
    """

    run: Run
    score: Score | None
    off: FloatArray
    angles: FloatArray

    @property
    def edge_errors(self) -> FloatArray:
        """Relative length errors of the edges found."""
        if self.score is None:
            return np.zeros(0)
        return np.abs(np.divide(self.score.edge_errors, self.score.edge_lengths))

    @property
    def passes(self) -> bool:
        """Whether it does what is asked of the cube."""
        errors = self.edge_errors
        return (
            self.run.is_box
            and len(errors) >= LEAST_EDGES
            and float(np.median(errors)) <= MEDIAN_ERROR
            and float(self.off.max()) <= WORST_ERROR
            and len(self.angles) >= 3
            and float(np.abs(self.angles - 90.0).max()) <= SQUARE_DEG
        )


def measure(settings: Settings) -> Report:
    """Measure all sets, as they are and changed."""
    rows: list[Row] = []
    faces: list[Row] = []
    folders: dict[str, Path] = {}
    for name in SETS:
        there = find_data_set("images", name)
        if isinstance(there, str):
            return Report(NAME, skipped=there)
        folders[name] = there
    for name in SETS:
        folder = folders[name]
        shape, view_set = true_shape(folder), read_views(folder)
        seeds = settings.seeds(SEEDS)
        for case, variants in _cases(view_set, seeds, everything=name == CUBE):
            found = [_found(views, frame, shape) for views, frame in variants]
            rows.append({"set": name, "case": case, **_row(found, asked=name == CUBE)})
            if case == AS_IT_IS:
                faces.append({"set": name, **_of_faces(found[0], view_set, shape)})
    return Report(
        NAME,
        (
            Table("Front end: lines", tuple(rows)),
            Table("True faces that cameras look at", tuple(faces)),
        ),
        {
            "seeds": settings.number(SEEDS),
            "first seed": settings.first,
            **{f"{name} sha256": hash_tree(folder) for name, folder in folders.items()},
        },
        (
            "Of several runs: the worst of all, the median of the medians, the range of the rest.",
            "edges: true edges found at both ends; all edges: against the nearest true length.",
            "other faces: of a tenth of their area or less on the thing; large: above 5 % of its "
            "largest face. Real things beside it are among them.",
        ),
    )


def true_shape(folder: Path) -> Shape:
    """Return the shape in a set's ground_truth.json."""
    truth = json.loads((folder / "ground_truth.json").read_text(encoding="utf-8"))
    faces = tuple(tuple(face["vertices"]) for face in truth["faces"])
    sides = {
        (min(a, b), max(a, b))
        for face in faces
        for a, b in zip(face, (*face[1:], face[0]), strict=True)
    }
    return Shape(np.array(truth["vertices"], dtype=np.float64), tuple(sorted(sides)), faces)


Variant = tuple[ViewSet, Similarity]


def _cases(
    view_set: ViewSet, seeds: Sequence[int], *, everything: bool
) -> Iterator[tuple[str, list[Variant]]]:
    """Yield the name of each case and its variants."""
    views = view_set.views

    def chosen(order: Sequence[int]) -> Variant:
        return replace(view_set, views=tuple(views[i] for i in order)), SAME_FRAME

    def disturbed(seed: int) -> Variant:
        noisy = add_pose_noise(
            views,
            np.random.default_rng(seed),
            position_sd=0.0,
            angle_sd=np.radians(POSE_NOISE_DEG),
        )
        return replace(view_set, views=noisy), SAME_FRAME

    def turned(seed: int) -> Variant:
        rng = np.random.default_rng(seed)
        return view_set, draw_similarity(rng, scale=SCALE, reach=SCALE)

    yield AS_IT_IS, [(view_set, SAME_FRAME)]
    if everything:
        yield f"world turned, x {SCALE:.0f}", [turned(seed) for seed in seeds]
        orders = [np.random.default_rng(seed).permutation(len(views)).tolist() for seed in seeds]
        yield "views in random order", [chosen(order) for order in orders]
        every = range(len(views))
        yield "every second view", [chosen(every[::2]), chosen(every[1::2])]
        yield f"poses off by {POSE_NOISE_DEG} deg", [disturbed(seed) for seed in seeds]


def _found(view_set: ViewSet, frame: Similarity, shape: Shape) -> Found:
    there = in_frame(view_set, frame)
    run = recognised(there, FrontEnd.LINES)
    if run.scene is None:
        return Found(run, None, np.zeros(0), np.zeros(0))
    vertices = frame.scale * shape.vertices @ frame.rotation.T + frame.shift
    shape = replace(shape, vertices=vertices)
    centres = np.array([v.pose.centre for v in there.views])
    true = np.array([np.linalg.norm(vertices[a] - vertices[b]) for a, b in shape.edges])
    points = run.scene.points
    lengths = np.array([np.linalg.norm(points[e.start] - points[e.end]) for e in run.scene.edges])
    angles, _ = compute_pairwise_angles([face.plane for face in run.scene.faces])
    degrees = np.degrees(angles[np.triu_indices(len(angles), 1)])
    return Found(
        run,
        score(run.scene, shape, centres),
        np.abs(lengths.reshape(-1, 1) / true - 1.0).min(axis=1),
        degrees[np.abs(degrees - 90.0) < 45.0],
    )


def _row(found: Sequence[Found], *, asked: bool) -> dict[str, Cell]:
    medians = [100 * float(np.median(f.edge_errors)) for f in found if len(f.edge_errors)]
    worst = [100 * float(f.edge_errors.max()) for f in found if len(f.edge_errors)]
    off = [100 * float(f.off.max()) for f in found if len(f.off)]
    angles = np.concatenate([f.angles for f in found])
    return {
        "runs": len(found),
        "verdicts": counted(f.run.outcome for f in found),
        "passes": sum(f.passes for f in found) if asked else None,
        "faces": _range([0 if f.run.scene is None else len(f.run.scene.faces) for f in found]),
        "vertices": _range([0 if f.score is None else len(f.score.vertex_errors) for f in found]),
        "edges": _range([len(f.edge_errors) for f in found]),
        "median %": round(float(np.median(medians)), 2) if medians else None,
        "worst %": round(max(worst), 2) if worst else None,
        "all edges worst %": round(max(off), 2) if off else None,
        "angles deg": f"{angles.min():.1f}–{angles.max():.1f}" if len(angles) else None,
    }


def _range(counts: Sequence[int]) -> str:
    low, high = min(counts), max(counts)
    return f"{low}" if low == high else f"{low}–{high}"


def _of_faces(found: Found, view_set: ViewSet, shape: Shape) -> dict[str, Cell]:
    centres = np.array([view.pose.centre for view in view_set.views])
    true = [Polygon(shape.vertices[list(shape.faces[k])]) for k in shape.seen_faces(centres)]
    off = OFFSET * float(np.ptp(shape.vertices, axis=0).max())
    scene = found.run.scene
    faces = [] if scene is None else [Polygon(scene.points[list(f.outline)]) for f in scene.faces]
    covered = [_share(one, faces, off) for one in true]
    others = [face for face in faces if _share(face, true, off) <= OTHER_SHARE]
    largest = max(face.area for face in true)
    nees = () if found.score is None else found.score.vertex_nees
    return {
        "true faces": len(true),
        "covered": ", ".join(f"{share:.2f}" for share in sorted(covered, reverse=True)),
        "faces": len(faces),
        "other faces": len(others),
        "large": sum(face.area > LARGE * largest for face in others),
        "NEES/3": round(float(np.mean(nees)), 2) if nees else None,
    }


def _share(face: Polygon, by: Sequence[Polygon], off: float) -> float:
    # How much of a face others cover.
    points = face.samples()
    normals = np.broadcast_to(face.normal, points.shape)
    hit = np.zeros(len(points), np.bool_)
    for one in by:
        hit |= one.covers(points, normals, offset=off, margin=off, turn=float(TURN))
    return float(hit.mean())
