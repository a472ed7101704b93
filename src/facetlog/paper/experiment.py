"""The paper's experiment (section 5): a block, 24 views, its own front end, and the recursion."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.detection.block_front_end.faces_of_block import (
    BlockFeatures,
    block_front_end,
    picture_features,
)
from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.point_filter import run_printed_recursion
from facetlog.perception.estimation.point_recursion import PointFilters
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.scene import Vertex
from facetlog.perception.step_clock import StepClock
from facetlog.perception.types import FloatArray, Observation, View
from facetlog.pipeline import (
    FrontEnd,
    Method,
    Progress,
    Recognised,
    open_models,
    recognize_views,
    render_simulated_views,
)

# "a large S0" of the paper's zero start, in the square of the unit: as its printed figures have it.
LARGE_S0 = 9999.0
# As the tour gives them, in metres; figures 12 and 13 are in inches.
METRES_PER_INCH = METRES_PER["in"]


@dataclass(frozen=True, eq=False, slots=True)
class VertexRun:
    """One vertex through its views, inches.

    `points` (n, 3) and `covs` (n, 3, 3) are the recursion's after each of the n `views` (indices)
    that saw it, NaN until it starts; `plain_points` and `plain_covs` the printed recursion's, from
    the zero start. `at_once` (3,) is the scene's, of all views together, `true` (3,) the corner.
    """

    label: str
    views: tuple[int, ...]
    pixels: FloatArray
    points: FloatArray
    covs: FloatArray
    plain_points: FloatArray
    plain_covs: FloatArray
    at_once: FloatArray
    true: FloatArray

    @property
    def nees(self) -> float:
        """The recursion's squared error after the last view over its covariance: 3 on average."""
        off = self.points[-1] - self.true
        return float(off @ np.linalg.solve(self.covs[-1], off))


@dataclass(frozen=True, eq=False, slots=True)
class Experiment:
    """Results of a run.

    `ungrown` and `grown` are the numbers of 2-D vertices in all pictures by thresholding alone and
    with region growing, `seconds` the time of detection in one picture, `total_seconds` that of all
    but the rendering.
    """

    found: Recognised
    block: BlockFeatures
    ungrown: int
    grown: int
    vertices: tuple[VertexRun, ...]
    seconds: float
    total_seconds: float

    @property
    def views(self) -> tuple[View, ...]:
        """The views as they were taken."""
        return self.found.view_set.views

    @property
    def shown_vertices(self) -> tuple[VertexRun, VertexRun]:
        """The vertex of the most views, and that of the fewest."""
        by_views = sorted(self.vertices, key=lambda v: (-len(v.views), v.label))
        return by_views[0], by_views[-1]


def run_experiment(seed: int, progress: Progress | None, clock: StepClock) -> Experiment:
    """Run the tour round the block of a seed. Raise InputError if no face is found."""
    from facetlog.robot.rendering.worlds import make_world

    view_set = render_simulated_views("block", seed, progress=progress, clock=clock)
    views = view_set.views
    true = np.array(make_world("block", seed).truth.solids[0].vertices) * METRES_PER_INCH
    start = perf_counter()
    with open_models() as base:
        method = Method(FrontEnd.PAPER)
        found = recognize_views(view_set, base=base, method=method, clock=clock)
    total = perf_counter() - start
    with clock.step("figures"):
        start = perf_counter()
        block = block_front_end(views, up=view_set.up)
        each = (perf_counter() - start) / len(views)
        ungrown = sum(len(picture_features(view.image, grow=False).vertices) for view in views)
        grown = sum(len(picture.vertices) for picture in block.pictures)
        runs = tuple(_vertex_run(v, found.placed_views, true) for v in found.scene.vertices)
    if not found.scene.faces:
        raise InputError(f"the paper's front end finds no face of the block of seed {seed}")
    return Experiment(found, block, ungrown, grown, runs, each, total)


def _vertex_run(vertex: Vertex, views: tuple[View, ...], true: FloatArray) -> VertexRun:
    """Follow a vertex of the scene through the views at their adjusted poses.

    Pixels have the covariance that the scene gives them: by edge pixels alone corners would be
    known two to five times too well.
    """
    seen = sorted(vertex.observations, key=lambda o: o.view)
    # The recursion works in inches, as the paper's.
    to_metres = np.diag([METRES_PER_INCH] * 3 + [1.0])
    projections = [views[o.view].projection @ to_metres for o in seen]
    filters = PointFilters(1)
    points, covs = [], []
    for o, projection in zip(seen, projections, strict=True):
        filters.add(projection, o.uv[None], o.cov[None], np.ones(1, np.bool_))
        points.append(filters.points[0].copy())
        covs.append(filters.covs[0].copy())
    numbered = [Observation(k, o.uv, o.cov) for k, o in enumerate(seen)]
    begin = State(np.zeros(3), LARGE_S0 * np.eye(3))
    plain = list(run_printed_recursion(numbered, projections, begin))
    nearest = int(((true - vertex.point) ** 2).sum(axis=1).argmin())
    return VertexRun(
        str(vertex.label or "no label"),
        tuple(o.view for o in seen),
        np.array([o.uv for o in seen]),
        np.array(points),
        np.array(covs),
        np.array([state.mean for state in plain]),
        np.array([state.cov for state in plain]),
        vertex.point / METRES_PER_INCH,
        true[nearest] / METRES_PER_INCH,
    )
