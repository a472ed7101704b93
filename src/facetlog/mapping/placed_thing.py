"""The things of a scene in the world: pose on the floor, size, and what the models say of them.

The covariance of a pose has two parts. What the pictures leave open is that of the corners. What
all views have in common - where the robot was when the first of them was taken, and how its head
sits on it - moves the whole scene, and no picture tells: that is taken from the view that is surest
of where the thing is. Poses of views are corrected among one another by the pictures, so that the
whole is at least as sure as from any one of them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated

import numpy as np
import shapely
from annotated_types import Ge
from numpy.typing import NDArray

from facetlog.mapping.plan_box import PlanBox, plan_box
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray, Pose, Share, frozen

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition

# A side that rises by less than this share of its length is level.
LEVEL = math.sin(math.radians(10.0))


@dataclass(frozen=True, slots=True)
class Length:
    """A length and its standard deviation, metres."""

    value: float
    sd: Annotated[float, Ge(0.0)]


@dataclass(frozen=True, slots=True)
class Said:
    """A model that holds, how sure that is, also as a text that says where it comes from, and all
    of it in a line.
    """

    model: str
    sure: Share
    figure: str
    summary: str


@dataclass(frozen=True, eq=False, slots=True)
class PlacedThing:
    """A thing of a scene in the world, metres and radians.

    `box` is the least rectangle round its plan, with the covariance that the pictures leave;
    `common` (3, 3) is that of x, y and heading by what all views have in common. `outline` (n, 2)
    is the convex hull of its plan, `low` and `high` are how far it reaches over the floor. `seen`
    is the area of it that views showed, m²; `said` are the models that hold, the best first.
    `source` says where it comes from: the visit, and the thing's name in its scene.
    """

    source: tuple[str, str]
    box: PlanBox
    common: FloatArray
    outline: FloatArray
    low: float
    high: Length
    seen: float
    said: tuple[Said, ...] = ()
    triangles: FloatArray = field(default_factory=lambda: np.zeros((0, 3, 3)), compare=False)
    """Triangles (n, 3, 3) that fill its faces, counter-clockwise from outside."""
    when: tuple[float, float] = (0.0, 0.0)
    """When the first and the last of its views were taken, seconds since 1970; 0 where nobody
    said."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "common", frozen(self.common, 3, 3))
        object.__setattr__(self, "outline", frozen(self.outline, len(self.outline), 2))

    @property
    def pose(self) -> FloatArray:
        """x, y and heading (3,)."""
        return self.box.values[:3]

    @property
    def cov(self) -> FloatArray:
        """Covariance (3, 3) of the pose, by pictures and by what all views have in common."""
        return np.asarray(self.box.cov[:3, :3] + self.common)

    @property
    def plan(self) -> shapely.Geometry:
        """The convex hull of its plan: of what is thin a line."""
        return shapely.convex_hull(shapely.multipoints(self.outline))

    @property
    def lengths(self) -> tuple[Length, Length, Length]:
        """Length and width of the rectangle, and height over the floor."""
        sds = np.sqrt(np.diag(self.box.cov)[3:]).tolist()
        length, width = (
            Length(float(value), float(sd))
            for value, sd in zip(self.box.values[3:], sds, strict=True)
        )
        return length, width, self.high


def place_things(
    scene: Scene,
    recognition: "Recognition",
    visit: str,
    poses: Sequence[Pose] = (),
    covariances: FloatArray | None = None,
) -> tuple[PlacedThing, ...]:
    """Return the scene's things that have an extent; the world's z is up, its floor at 0.

    `poses` and `covariances` (V, 6, 6) are those of the views as the robot stated them; without
    them poses count as exact.
    """
    said: dict[str, list[Said]] = {}
    for verdict in recognition.best:
        said.setdefault(verdict.thing, []).append(
            Said(
                verdict.model,
                verdict.sure,
                verdict.confidence.format(verdict.degree),
                verdict.summary,
            )
        )
    covs = np.zeros((0, 6, 6)) if covariances is None else covariances
    return tuple(_placed(scene, visit, said, poses, covs))


def _placed(
    scene: Scene,
    visit: str,
    said: dict[str, list[Said]],
    poses: Sequence[Pose],
    covs: FloatArray,
) -> Iterator[PlacedThing]:
    from facetlog.perception.facts.scene_memo import SceneMemo
    from facetlog.perception.surfaces.mesh_export import triangulate_face

    memo = SceneMemo.of(scene)
    areas = memo.table.areas
    vertex_covs = np.array([vertex.cov for vertex in scene.vertices]).reshape(-1, 3, 3)
    points = scene.points
    for index, (thing, name) in enumerate(zip(memo.things, memo.thing_names, strict=True)):
        own = memo.members[index]
        if not thing.faces or len(own) < 2:
            continue
        box = plan_box(
            points[own, :2],
            vertex_covs[own, :2, :2],
            np.searchsorted(own, _find_level_sides(scene, thing)),
        )
        if box is None:
            continue
        heights = points[own, 2]
        top = int(own[np.argmax(heights)])
        middle = np.array([*box.values[:2], float(heights.mean())])
        yield PlacedThing(
            (visit, str(name)),
            box,
            pose_covariance_at(middle, poses, covs),
            _hull(points[own, :2]),
            float(heights.min()),
            Length(float(points[top, 2]), float(np.sqrt(vertex_covs[top, 2, 2]))),
            float(sum(areas[i] * scene.faces[i].coverage for i in thing.faces)),
            tuple(said.get(str(name), ())),
            np.concatenate([triangulate_face(memo.table.faces[i], points) for i in thing.faces]),
        )


def _find_level_sides(scene: Scene, thing: Thing) -> NDArray[np.intp]:
    """Return the ends (m, 2) of the level sides of a thing's faces, as the scene's vertices, each
    once.
    """
    points = scene.points
    found = set()
    for index in thing.faces:
        loop = scene.faces[index].outline
        for one, other in pairwise((*loop, loop[0])):
            step = points[other] - points[one]
            if abs(step[2]) <= LEVEL * math.hypot(*step):
                found.add((min(one, other), max(one, other)))
    return np.array(sorted(found), dtype=np.intp).reshape(-1, 2)


def pose_covariance_at(
    place: FloatArray, poses: Sequence[Pose], covariances: FloatArray
) -> FloatArray:
    """Return the covariance (3, 3) of x, y and heading of what is at a place (3,) in a view's own
    frame, by the pose of the view that is surest of it; zero without views.

    A turn ω about the camera's centre c moves the place p by ω × (p - c).
    """
    best: FloatArray = np.zeros((3, 3))
    least = np.inf
    for pose, cov in zip(poses, covariances, strict=True):
        x, y, z = place - pose.centre
        moved = np.array(
            [
                [1.0, 0.0, 0.0, 0.0, z, -y],
                [0.0, 1.0, 0.0, -z, 0.0, x],
                [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            ]
        )
        found = moved @ cov @ moved.T
        spread = float(found[0, 0] + found[1, 1])
        if spread < least:
            best, least = found, spread
    return np.asarray((best + best.T) / 2)


def _hull(points: FloatArray) -> FloatArray:
    hull = shapely.convex_hull(shapely.multipoints(points))
    corners: FloatArray = shapely.get_coordinates(hull)
    return corners[:-1] if hull.geom_type == "Polygon" else corners
